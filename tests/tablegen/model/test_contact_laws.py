"""Contact laws: each against its formula, and rebounds under each against invariants."""

import itertools
import math

import contact_law_samples as samples
import numba
import numpy as np
import pytest
from audit import ANGULAR, ENERGY, NORMAL, TANGENTIAL
from motion_fixtures import PAIR, POPULATION
from one_particle import simulate_alone
from scipy.interpolate import RegularGridInterpolator

from sampler.formats.shape_codes import SHAPE_NAMES
from tablegen.config.pairs import MaterialPair
from tablegen.model.contact_laws import (
    EXPONENTIAL,
    ORIENTATION,
    POLYNOMIAL,
    POWER,
    TABULATED_RESISTANCE,
    LawArguments,
    exponential_restitution,
    impact_angle,
    orientation_resistance,
    pack_table,
    polynomial_restitution,
    power_restitution,
    resistance,
    restitution,
    tabulated_coefficient,
)
from tablegen.model.jit import kernel
from tablegen.simulation.simulate import make_condition, simulate_condition

# called from Python here
exponential_restitution = kernel(exponential_restitution)
impact_angle = kernel(impact_angle)
orientation_resistance = kernel(orientation_resistance)
polynomial_restitution = kernel(polynomial_restitution)
power_restitution = kernel(power_restitution)
resistance = kernel(resistance)
restitution = kernel(restitution)

SPEEDS = [0.0, 1e-300, 1e-9, 0.3, 49.0, 50.0, 120.0, 200.0, 201.0, 700.0, 1e5]
COSINES = [0.0, 1e-12, 0.1, 0.5, 1.0 / math.sqrt(2.0), 0.9, 1.0 - 1e-16, 1.0]

ANGLES = np.radians([10.0, 30.0, 75.0])
NODES = np.array([50.0, 120.0, 200.0, 400.0])
VALUES = np.random.default_rng(5).uniform(0.0, 1.0, (3, 4))

RESTITUTION = samples.RESTITUTION | {
    "exponential": PAIR.restitution.model_dump(mode="json"),
    "inelastic": {"law": "constant", "value": 0.0},
}
RESISTANCE = samples.RESISTANCE | {
    "tripled": PAIR.resistance.model_dump() | {"factor": 3.0},
    "none": {"law": "constant", "value": 0.0},
}


def entries(restitution_law=EXPONENTIAL, resistance_law=ORIENTATION, **given):
    """Return arguments of laws: some entries are given, the others are values of no law."""
    rest = {"coefficient": 77.0, "exponent": 77.0, "strength": 77.0, "factor": 77.0}
    rest |= {"numbers": np.full(3, 77.0), "resistances": np.full(3, 77.0)}
    return LawArguments(
        restitution_law=restitution_law, resistance_law=resistance_law, **(rest | given)
    )


def pair_with(restitution, resistance="orientation"):
    """The shipped pair with other laws, by name or field by field."""
    first = RESTITUTION[restitution] if isinstance(restitution, str) else restitution
    second = RESISTANCE[resistance] if isinstance(resistance, str) else resistance
    laws = {"restitution": samples.SOURCE | first, "resistance": samples.SOURCE | second}
    return MaterialPair.from_tree({"particle": "any", "wall": "any", **laws})


def run(pair, alpha_deg=45.0, speed=150.0, count=2000, shape="mixture", seed=31):
    condition = make_condition(np.radians(alpha_deg), speed)
    population = POPULATION.restricted_to(shape)
    return simulate_condition(pair, population, condition, count, seed=seed)


class TestRestitution:
    def test_default_law_is_the_small_kernel(self):
        law = entries(coefficient=0.1, exponent=0.61)
        for speed, cosine in itertools.product(SPEEDS, COSINES):
            expected = exponential_restitution(0.1, 0.61, speed, cosine)
            assert restitution(law, speed, cosine) == expected
            library = 1.0 + math.expm1(-0.1 * speed**0.61) * cosine
            assert expected == pytest.approx(library, abs=1e-15)

    @pytest.mark.parametrize("coefficients", [[0.4], [0.9, -0.3], [0.993, -1.76, 1.56, -0.49]])
    def test_polynomial(self, coefficients):
        law = entries(POLYNOMIAL, numbers=np.array(coefficients))
        for cosine in COSINES:
            angle = math.asin(cosine)
            expected = sum(c * angle**i for i, c in enumerate(coefficients))
            for speed in SPEEDS:
                assert restitution(law, speed, cosine) == pytest.approx(expected, abs=1e-15)
            assert polynomial_restitution(law.numbers, angle) == restitution(law, 1.0, cosine)

    def test_power(self):
        law = entries(POWER, coefficient=0.5 * 100.0**0.25, exponent=0.25)
        for speed, cosine in itertools.product(SPEEDS, COSINES):
            normal = speed * cosine
            # 0.5 (normal / 100)^-0.25 reaches one at 100 / 16
            expected = 0.5 * (normal / 100.0) ** -0.25 if normal > 6.25 else 1.0
            assert restitution(law, speed, cosine) == pytest.approx(expected, rel=1e-14)

    def test_table_is_bilinear_between_its_nodes(self):
        numbers = pack_table(ANGLES, NODES, VALUES)
        truth = RegularGridInterpolator((ANGLES, NODES), VALUES)
        rng = np.random.default_rng(6)
        points = np.column_stack(
            [rng.uniform(ANGLES[0], ANGLES[-1], 500), rng.uniform(50, 400, 500)]
        )
        values = [tabulated_coefficient(numbers, angle, speed) for angle, speed in points]
        np.testing.assert_allclose(values, truth(points), rtol=0.0, atol=1e-14)
        # Refused: the table with its rows and columns confused.
        confused = pack_table(ANGLES, NODES, VALUES.reshape(4, 3).T.copy())
        wrong = [tabulated_coefficient(confused, angle, speed) for angle, speed in points]
        assert np.abs(np.array(wrong) - truth(points)).max() > 0.1

    def test_axis_of_one_node_stands_for_no_dependence(self):
        by_angle = pack_table(ANGLES, NODES[:1], VALUES[:, :1])
        by_speed = pack_table(ANGLES[:1], NODES, VALUES[:1])
        single = pack_table(ANGLES[:1], NODES[:1], VALUES[:1, :1])
        for speed in SPEEDS:
            expected = np.interp(0.9, ANGLES, VALUES[:, 0])
            assert tabulated_coefficient(by_angle, 0.9, speed) == pytest.approx(expected)
            expected = np.interp(speed, NODES, VALUES[0])
            assert tabulated_coefficient(by_speed, 0.9, speed) == pytest.approx(expected)
            assert tabulated_coefficient(single, 0.9, speed) == VALUES[0, 0]


class TestResistance:
    # contact ahead of the centre, behind, abreast; r . V_p, |r|, |V_p|
    CONTACTS = ((0.6, 0.3, 2.0), (-0.6, 0.3, 2.0), (0.0, 0.3, 2.0), (0.1, 0.5, 0.7))

    @pytest.mark.parametrize("factor", [0.0, 1.0, 2.5])
    def test_orientation(self, factor):
        law = entries(strength=0.8, factor=factor)
        for product, length, speed in self.CONTACTS:
            expected = factor * math.exp(0.8 * product / (length * speed))
            value = resistance(law, product, length, speed, 0.6)
            assert value == pytest.approx(expected, rel=1e-15)
        assert resistance(law, 0.0, 0.3, 0.0, 0.6) == factor

    def test_table_is_linear_in_the_angle_of_the_contact(self):
        angles, values = np.radians([10.0, 40.0, 75.0]), np.array([0.9, 2.5, 0.1])
        table = pack_table(angles, np.ones(1), values[:, None])
        law = entries(resistance_law=TABULATED_RESISTANCE, resistances=table)
        for cosine, contact in itertools.product(COSINES, self.CONTACTS):
            expected = np.interp(math.asin(cosine), angles, values)
            assert resistance(law, *contact, cosine) == pytest.approx(expected, abs=1e-14)


def test_one_compiled_model_serves_all_laws():
    pairs = [pair_with(e, c) for e, c in itertools.product(RESTITUTION, RESISTANCE)]
    types = {numba.typeof(pair.kernel_arguments()) for pair in pairs}
    assert types == {numba.typeof(PAIR.kernel_arguments())}


@pytest.mark.parametrize("shape", SHAPE_NAMES)
@pytest.mark.parametrize("name", RESTITUTION)
def test_every_collision_obeys_its_law(name, shape):
    for resistance_name, alpha_deg in itertools.product(RESISTANCE, (0.5, 20.0, 45.0, 70.0, 90.0)):
        pair = pair_with(name, resistance_name)
        # the audit of Coulomb's law follows each collision in small steps: slow, and not exact
        coulomb = resistance_name == "coulomb"
        condition = make_condition(np.radians(alpha_deg), 150.0)
        population, count = POPULATION.restricted_to(shape), 10 if coulomb else 60
        values, _, audit = simulate_alone(pair, population, condition, count, seed=31)
        assert audit[[ENERGY, ANGULAR]].max() <= 1e-12
        worst = audit[[NORMAL, TANGENTIAL]]
        assert worst.max() <= (1e-9 if coulomb else 1e-12), (resistance_name, alpha_deg, worst)
        assert audit.max() <= 1e-9
        assert np.isfinite(values).all()
        assert values[:, 1].min() > 0.0
        # sustained contact ends: the longest chains have some hundreds of bounces
        assert values[:, 7].max() < 5000


@pytest.mark.parametrize("shape", SHAPE_NAMES)
@pytest.mark.parametrize("name", RESTITUTION)
def test_works_are_not_negative_and_together_what_the_energy_lacks(name, shape):
    """2,000 rebounds of each combination: over 10,000 of each shape and of each law."""
    angles = itertools.cycle((0.5, 20.0, 45.0, 90.0))
    population = POPULATION.restricted_to(shape)
    for resistance_name, alpha_deg in zip(RESISTANCE, angles, strict=False):
        # the tolerance of the flights, in which energy is kept, adds to the difference
        condition = make_condition(np.radians(alpha_deg), 150.0, tolerance=1e-14)
        pair = pair_with(name, resistance_name)
        simulation = simulate_condition(pair, population, condition, 2000, seed=33)
        lost = 1.0 - simulation.energy.sum(axis=1)
        np.testing.assert_allclose(simulation.work.sum(axis=1), lost, rtol=0.0, atol=1e-12)
        assert simulation.work.min() >= -1e-15, resistance_name
        if resistance_name == "none":
            assert simulation.work[:, 1].max() < 1e-6  # lifted bounces only
        # Refused: works of other particles.
        assert shape == "sphere" or np.abs(simulation.work[::-1].sum(axis=1) - lost).max() > 1e-6
