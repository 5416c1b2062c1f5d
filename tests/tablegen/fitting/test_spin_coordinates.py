"""Coordinates of the spin law: within their bounds, invertible, and those of the draw."""

from dataclasses import replace

import numpy as np
import pytest
from reference_draw import (
    reference_before,
    reference_contact,
    reference_inertia,
    reference_kappa,
    reference_spin_draw,
)
from small_tables import works
from spin_laws import tilted_departures
from spin_tables import with_spin_law

from sampler import Table
from sampler.formats.bounds import (
    FOLD,
    MEAN_UNIT,
    N_DIRECTIONS,
    N_FEATURES,
    N_INPUTS,
    SCORE_MAX,
    SPIN_CORE,
    TILT_CORE,
)
from tablegen.config.config import load_config
from tablegen.fitting.law_conditions import grain_moments, inertia_coefficients
from tablegen.fitting.spin_coordinates import (
    INPUT_SIGNS,
    OUTCOME_SIGNS,
    Moments,
    SpeedCoordinate,
    beside_sphere,
    choose_reflected,
    features,
    impact_inputs,
    inertia_from_kappa,
    kappa_from_inertia,
    nominal_contact,
    normal_work_outcome,
    rebound_outcomes,
    reflect,
    used_features,
)
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import Impacts, energy_factor, simulate_departures
from tablegen.simulation.sphere_rebounds import sphere_laws, sphere_rebounds

N = 300
CONFIG = load_config("corundum-steel")
POPULATION = CONFIG.population
SPEED = SpeedCoordinate(0.1, 0.61, 600.0)
CODES = (0, 1, 3)
#: A random law of ellipsoids, prisms and tetrahedra with the moments that they have.
CONTENTS = with_spin_law(works(), codes=CODES)
CONTENTS["spin/shape_inertia"][:] = [inertia_coefficients(POPULATION, code) for code in CODES]


def random_impacts(seed=1, code=1, spin=1.0):
    """Impacts of a shape within the law of `CONTENTS`, whose spins lie on either side."""
    rng = np.random.default_rng(seed)
    ratios = rng.uniform(0.5, 1.0, (N, 2))
    grain = np.column_stack([np.full(N, float(code)), ratios])
    moments = grain_moments(POPULATION, code, ratios)
    index, hit = np.arange(N, dtype=np.uint64), np.ones(N, dtype=np.uint32)
    spins = spin * rng.normal(0.0, 1.0, (N, 3))
    inertia = inertia_from_kappa(rng.uniform(0.0, 1.0, N), moments)
    alpha1 = np.radians(rng.uniform(*CONTENTS["axes/alpha_deg"][[0, -1]], N))
    speed = rng.uniform(*CONTENTS["axes/speed"][[0, -1]], N) / energy_factor(spins, inertia)
    return Impacts(alpha1, speed, spins, inertia, grain, index, hit), moments


def inputs_of(impacts, moments):
    return impact_inputs(impacts, moments, nominal_contact(impacts, moments), SPEED)


class TestKappa:
    MOMENTS = Moments(np.linspace(0.3, 0.6, N), np.geomspace(0.01, 0.29, N))

    def test_is_the_inverse_of_the_inertia(self):
        kappa = np.random.default_rng(2).uniform(0.0, 1.0, N)
        kappa[:3] = 0.0, 1.0, 0.5
        inertia = inertia_from_kappa(kappa, self.MOMENTS)
        assert (inertia >= self.MOMENTS.smallest * (1.0 - 1e-15)).all()
        assert (inertia <= self.MOMENTS.largest * (1.0 + 1e-15)).all()
        # a rounding of the inertia is the square root of it in kappa
        np.testing.assert_allclose(
            kappa_from_inertia(inertia, self.MOMENTS), kappa, rtol=0.0, atol=1e-7
        )
        np.testing.assert_allclose(
            inertia_from_kappa(np.zeros(N), self.MOMENTS), self.MOMENTS.smallest
        )
        np.testing.assert_allclose(
            inertia_from_kappa(np.ones(N), self.MOMENTS), self.MOMENTS.largest
        )

    def test_is_that_of_the_draw(self):
        kappa = np.random.default_rng(3).uniform(0.0, 1.0, N)
        inertia = inertia_from_kappa(kappa, self.MOMENTS)
        ends = list(zip(self.MOMENTS.smallest, self.MOMENTS.largest, strict=True))
        expected = [reference_inertia(x, *two) for x, two in zip(kappa, ends, strict=True)]
        np.testing.assert_allclose(inertia, expected, rtol=1e-13)
        expected = [reference_kappa(x, *two) for x, two in zip(inertia, ends, strict=True)]
        np.testing.assert_allclose(
            kappa_from_inertia(inertia, self.MOMENTS), expected, rtol=0.0, atol=1e-12
        )

    def test_of_inertias_beyond_the_moments_is_that_of_the_nearest(self):
        least, most = self.MOMENTS.smallest, self.MOMENTS.largest
        np.testing.assert_array_equal(kappa_from_inertia(0.99 * least, self.MOMENTS), 0.0)
        np.testing.assert_array_equal(kappa_from_inertia(1.01 * most, self.MOMENTS), 1.0)

    def test_of_spheres_and_cubes_is_a_half(self):
        moments = grain_moments(POPULATION, 1, np.ones((2, 2)))
        np.testing.assert_allclose(moments, 2.0 / 3.0)
        inertia = np.array([0.5, 2.0 / 3.0])
        np.testing.assert_array_equal(kappa_from_inertia(inertia, moments), 0.5)
        np.testing.assert_array_equal(
            inertia_from_kappa(np.array([0.0, 1.0]), moments), moments.largest
        )

    def test_grows_as_the_angle_from_the_axis_at_both_ends(self):
        # a spin at the angle t from an axis of a grain with two equal moments
        angle = np.array([1e-4, 2e-4])
        ends = Moments(np.full(2, 0.4), np.full(2, 0.1))
        for square, kappa in ((np.sin(angle) ** 2, 1.0), (np.cos(angle) ** 2, 0.0)):
            # |L|^2 / 2T of angular velocities J^-1 L, with L along the angle
            inertia = 1.0 / (square / 0.1 + (1.0 - square) / 0.4)
            near = np.abs(kappa_from_inertia(inertia, ends) - kappa)
            np.testing.assert_allclose(near, angle, rtol=1e-3)


class TestInputs:
    def test_are_bounded_and_keep_the_direction_of_any_spin(self):
        impacts, moments = random_impacts()
        impacts = impacts._replace(spin=impacts.spin * np.geomspace(1e-9, 1e6, N)[:, None])
        inputs = inputs_of(impacts, moments)
        assert np.isfinite(inputs).all()
        sigma, size = inputs[:, 2:5].copy(), np.linalg.norm(impacts.spin, axis=1)
        square = sigma[:, :2] ** 2  # of sigma / sqrt(|sigma| + core)
        root = np.sqrt(0.25 * square**2 + TILT_CORE * square)
        sigma[:, :2] = np.sign(sigma[:, :2]) * (0.5 * square + root)
        length = np.linalg.norm(sigma, axis=1)
        np.testing.assert_allclose(sigma * (size / length)[:, None], impacts.spin, rtol=1e-12)
        assert (np.diff(length[np.argsort(size)]) >= 0.0).all()
        np.testing.assert_allclose(length[size < 1e-6], SPIN_CORE, rtol=1e-4)

    def test_without_a_spin_are_those_of_the_impact_alone(self):
        impacts, moments = random_impacts(spin=0.0)
        inputs = inputs_of(impacts._replace(inertia=np.zeros(N)), moments)
        np.testing.assert_array_equal(inputs[:, [2, 3, 4, 6]], 0.0)
        np.testing.assert_allclose(inputs[:, 5], np.cos(impacts.alpha1), rtol=1e-12)
        np.testing.assert_allclose(inputs[:, 1], SPEED.transform(impacts.speed), rtol=1e-12)

    @pytest.mark.parametrize("code", CODES)
    def test_are_those_of_the_draw(self, code):
        impacts, moments = random_impacts(code=code)
        inputs = inputs_of(impacts, moments)
        for k in range(20):
            before = reference_before(
                *(CONTENTS, impacts.speed[k], impacts.spin[k], impacts.inertia[k]),
                *(impacts.grain[k], np.zeros(12)),
            )
            spin, inertia, kappa, energy, _ = before
            _, square, slip = reference_contact(
                impacts.alpha1[k], spin, inertia, kappa, impacts.grain[k]
            )
            speed = np.sqrt(square)
            place = np.log((kappa + 0.03) / (1.03 - kappa))
            expected = SPEED.transform(impacts.speed[k] * speed), slip / speed, place
            assert inputs[k, [1, 5, 6]] == pytest.approx(expected, rel=1e-9)
            own = energy_factor(impacts.spin, impacts.inertia)[k]
            assert own**2 == pytest.approx(energy, rel=1e-12)

    @pytest.mark.parametrize("code", CODES[:2])
    def test_and_features_are_those_of_tables(self, code):
        """A table whose scores are one feature each gives that feature back."""
        impacts, moments = random_impacts(4, code)
        inputs = inputs_of(impacts, moments)
        is_reflected = inputs[:, 2] < 0.0
        expected = features(reflect(inputs, is_reflected, INPUT_SIGNS))
        apart = np.abs(inputs[:, 2]) > FOLD  # nearer to it, chance chooses the side
        for number in range(1, N_FEATURES):
            score = draw_score(impacts, number)
            np.testing.assert_allclose(score[apart], expected[apart, number], atol=0.02, rtol=0.02)


def with_leaves(**arrays):
    """`CONTENTS` with some arrays of its leaves filled."""
    changed = {}
    for name, values in arrays.items():
        old = CONTENTS[f"spin/{name}"]
        changed[f"spin/{name}"] = np.broadcast_to(values, old.shape).astype(old.dtype)
    return replace(CONTENTS, datasets=CONTENTS.datasets | changed)


def draw_score(impacts, number):
    """Scores of o_z, undone, of a table in which they are a quarter of a feature."""
    mean = np.zeros((N_FEATURES, 8))
    mean[number, 5] = 0.25 * MEAN_UNIT
    factor = np.zeros(36)
    factor[[row * (row + 3) // 2 for row in range(8)]] = 1.0  # 1/4096, the least
    bounded = np.linspace(-SCORE_MAX, SCORE_MAX, 33)
    quantiles = np.full((8, 33), 0.5)
    quantiles[3:5], quantiles[5] = 0.0, 0.02 * bounded  # so small that a draw stays in its half
    contents = with_leaves(centre=0.0, scale=1.0, mean=mean, factor=factor, quantiles=quantiles)
    after = np.empty(N)
    moments = grain_moments(POPULATION, int(impacts.grain[0, 0]), impacts.grain[:, 1:])
    states = draw_states(contents, impacts, after)
    contact = nominal_contact(impacts, moments)
    score = 50.0 * rebound_outcomes(states[:, :6], after, moments, contact)[:, 5]
    return 4.0 * score / np.sqrt(1.0 - (score / SCORE_MAX) ** 2)


def draw_states(contents, impacts, after):
    return Table(contents).sample(
        impacts.alpha1,
        impacts.speed,
        spin=impacts.spin,
        inertia=impacts.inertia,
        grain=impacts.grain,
        seed=1,
        index=impacts.index,
        hit=impacts.hit,
        inertia_after=after,
    )


@pytest.mark.parametrize("rolls", [False, True])
@pytest.mark.parametrize("code", CODES)
def test_draws_make_the_simulated_rebounds_of_their_outcomes(code, rolls):
    """States, inertias and works, by the specification and by a table: to single precision."""
    impacts, moments = random_impacts(7, code)
    if rolls:  # the contact has a part of the rotation only
        flat = np.full(N, np.radians(CONTENTS["axes/alpha_deg"][0]))
        impacts = impacts._replace(spin=0.2 * impacts.spin - [0.0, 0.0, 1.3], alpha1=flat)
        contact = nominal_contact(impacts, moments)
        turning = contact.root_inertia * contact.spin
        assert (contact.speed < 0.8 * turning).mean() > 0.3
    departures = simulate_departures(DirectModel(CONFIG), impacts, 3, threads=1)
    energy = energy_factor(impacts.spin, impacts.inertia) ** 2
    outcomes = rebound_outcomes(
        departures.states, departures.inertia, moments, nominal_contact(impacts, moments)
    )
    outcomes = np.column_stack([outcomes, normal_work_outcome(departures.works)])
    sigma_x = inputs_of(impacts, moments)[:, 2]
    signs = np.where((sigma_x < 0.0)[:, None], OUTCOME_SIGNS, 1.0)
    outcomes[:, :7] *= signs
    expected = np.column_stack([departures.states, departures.works])
    for k in np.flatnonzero(np.abs(sigma_x) > FOLD)[:25]:
        contents = with_leaves(quantiles=outcomes[k, :, None])
        condition = impacts.alpha1[k], impacts.speed[k], impacts.spin[k], impacts.inertia[k]
        words = np.zeros(12, dtype=np.int64)
        *again, inertia = reference_spin_draw(contents, *condition, impacts.grain[k], words)
        np.testing.assert_allclose(again, expected[k], rtol=1e-6, atol=1e-6 * np.sqrt(energy[k]))
        assert inertia == pytest.approx(departures.inertia[k], rel=1e-6)
        one, after = impacts.select(slice(k, k + 1)), np.empty(1)
        drawn = draw_states(contents, one, after)[0]
        np.testing.assert_allclose(drawn, expected[k], rtol=2e-4, atol=2e-4 * np.sqrt(energy[k]))
        assert after[0] == pytest.approx(departures.inertia[k], rel=1e-5)


def test_ellipsoids_without_spin_count_from_spheres():
    """Of a tabulated law; draws make the simulated rebounds, a sphere's own has outcomes of 0."""
    config = load_config("grant-tabakoff-1975")
    impacts, moments = random_impacts(9, code=0, spin=0.0)
    impacts = impacts._replace(inertia=np.zeros(N))
    after = sphere_rebounds(config, impacts)
    contact = beside_sphere(nominal_contact(impacts, moments), impacts, after)
    departures = simulate_departures(DirectModel(config), impacts, 3, threads=1)
    inertia = np.where(departures.inertia > 0.0, departures.inertia, moments.largest)
    outcomes = rebound_outcomes(departures.states, inertia, moments, contact)
    outcomes = np.column_stack([outcomes, normal_work_outcome(departures.works)])
    states, law = np.column_stack([departures.states, departures.works]), sphere_laws(config)
    for k in range(25):
        contents = with_leaves(quantiles=outcomes[k, :, None])
        contents = replace(contents, datasets=contents.datasets | {"spin/laws": law})
        condition = impacts.alpha1[k], impacts.speed[k], np.zeros(3), 0.0, impacts.grain[k]
        again = reference_spin_draw(contents, *condition, np.zeros(12, dtype=np.int64))[:-1]
        np.testing.assert_allclose(again, states[k], atol=1e-6)
        drawn = draw_states(contents, impacts.select(slice(k, k + 1)), np.empty(1))[0]
        drawn[2:5] *= np.sign(drawn[2] * states[k, 2])  # of either image: chance chooses the side
        np.testing.assert_allclose(drawn, states[k], atol=2e-4)
    u = np.cos(impacts.alpha1)
    turning = -2.5 * (u - after[:, 0])  # of a sphere; the grain's own d stays
    spin = 0.4 * turning / (contact.distance * inertia)
    sphere = np.column_stack([after, np.zeros((N, 3)), spin])
    loses = (after**2).sum(axis=1) + inertia * spin**2 < 0.9
    outcomes = rebound_outcomes(sphere, inertia, moments, contact)[loses]
    np.testing.assert_allclose(outcomes[:, [0, 2, 3, 4]], 0.0, atol=1e-9)
    assert len(outcomes) > 0.5 * N


def test_fold_is_the_reflection_in_the_impact_plane():
    impacts, moments = random_impacts()
    inputs, image = (
        inputs_of(impacts._replace(spin=impacts.spin * signs), moments)
        for signs in ([1.0, 1.0, 1.0], [-1.0, -1.0, 1.0])
    )
    np.testing.assert_array_equal(image, inputs * INPUT_SIGNS)
    once = reflect(inputs, inputs[:, 2] < 0.0, INPUT_SIGNS)
    assert (once[:, 2] >= 0.0).all()
    np.testing.assert_array_equal(once, reflect(image, image[:, 2] < 0.0, INPUT_SIGNS))


def test_the_side_is_chosen_by_chance_near_the_fold_only():
    inputs = np.zeros((30_000, N_INPUTS + N_DIRECTIONS))
    inputs[:10_000, 2], inputs[10_000:20_000, 2], inputs[20_000:, 2] = FOLD, -FOLD, 0.5 * FOLD
    is_reflected = choose_reflected(inputs, np.random.default_rng(5))
    assert not is_reflected[:10_000].any()
    assert is_reflected[10_000:20_000].all()
    assert is_reflected[20_000:].mean() == pytest.approx(0.25, abs=0.025)


def test_reflected_rebounds_have_reflected_outcomes():
    impacts, moments = random_impacts(6)
    states = np.random.default_rng(6).normal(0.0, 0.3, (N, 6))
    inertia, signs = 0.5 * (moments.smallest + moments.largest), [-1.0, -1.0, 1.0]
    image = impacts._replace(spin=impacts.spin * signs)
    outcomes = rebound_outcomes(states, inertia, moments, nominal_contact(impacts, moments))
    other = rebound_outcomes(
        states * [1.0, 1.0, -1.0, *signs], inertia, moments, nominal_contact(image, moments)
    )
    np.testing.assert_array_equal(other, outcomes * OUTCOME_SIGNS)


def test_a_motion_that_does_not_change_has_outcomes_o_of_its_share():
    """A rolling grain's o is small; one whose energy is at its contact counts from rest."""
    impacts, moments = random_impacts(8)
    contact = nominal_contact(impacts, moments)
    velocity = np.column_stack([np.cos(impacts.alpha1), np.sin(impacts.alpha1), np.zeros(N)])
    states = np.hstack([velocity, impacts.spin])
    o = rebound_outcomes(states, impacts.inertia, moments, contact)[:, 3:6]
    share = np.minimum(1.0, contact.speed / np.sqrt(contact.energy))
    root, arm = contact.root_inertia, np.hypot(contact.root_inertia, contact.distance)
    rest = (root * root / arm)[:, None] * impacts.spin
    rest[:, 1] = root * impacts.spin[:, 1]
    rest[:, 2] -= velocity[:, 0] * contact.distance / arm
    size = np.linalg.norm(rest, axis=1) / np.sqrt(contact.energy)
    angle = np.arcsin(size) - np.arcsin((1.0 - share**2) * size)
    expected = 2.0 * np.tan(0.5 * angle) / share
    np.testing.assert_allclose(np.linalg.norm(o, axis=1), expected, rtol=1e-6, atol=1e-9)


def sizes_out_of_the_plane(tilt):
    """Medians of p_w, o_x and o_y of ellipsoids that turn about their shortest axes, by size."""
    (impacts, states, inertia, _), moments = tilted_departures(CONFIG, 0, tilt)
    contact = nominal_contact(impacts, moments)
    outcomes = rebound_outcomes(states, inertia, moments, contact)
    return np.median(np.abs(outcomes[:, 2:5]), axis=0)


def test_ellipsoids_leave_the_plane_of_an_impact_in_units_of_their_tilt():
    """Without units, the sizes would be 16 times larger at the larger tilt."""
    ratios = sizes_out_of_the_plane(0.08) / sizes_out_of_the_plane(0.005)
    np.testing.assert_allclose(ratios, 1.0, atol=0.3)


def test_a_rebound_without_a_loss_has_finite_outcomes():
    impacts, moments = random_impacts(spin=0.0)
    impacts, moments = impacts.select(slice(0, 2)), Moments(*(some[:2] for some in moments))
    states = np.array([[0.8, 0.6, 0.0, 0.0, 0.0, 0.0], [0.6, 0.0, 0.0, 0.0, 0.0, 0.8]])
    contact = nominal_contact(impacts, moments)
    assert np.isfinite(rebound_outcomes(states, moments.largest, moments, contact)).all()


def test_share_of_the_normal_work():
    shares = normal_work_outcome(
        np.array([[2.0, 6.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0], [-1e-9, 1.0]])
    )
    np.testing.assert_allclose(shares**6, [0.25, 0.0, 1.0, 0.0, 0.0], atol=1e-12)


def test_features_are_the_inputs_their_products_and_the_directions():
    t = np.array([[2.0, -1.0, 0.5, 3.0, 0.0, -2.0, 5.0, 7.0, 11.0, 0.6, -0.8, 0.1, 0.9]])
    products = [t[0, i] * t[0, j] - 0.5 * (i == j) for i in range(9) for j in range(i, 9)]
    np.testing.assert_array_equal(features(t), [[1.0, *t[0, :9], *products, 0.6, -0.8, 0.1, 0.9]])
    assert features(t).shape == (1, N_FEATURES)
    varies = np.zeros(13, dtype=bool)
    varies[[0, 1, 7, 10]] = True
    # 1, three inputs, the six products of two of these, and a direction
    used = [0, 1, 2, 8, 10, 11, 17, 19, 25, 52, 56]
    assert np.flatnonzero(used_features(varies)).tolist() == used
