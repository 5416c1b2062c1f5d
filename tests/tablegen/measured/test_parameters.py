"""Parameters that can be freed, their coordinates, and the pairs that they make."""

import numpy as np
import pytest

from sampler.errors import InputError
from tablegen import load_config
from tablegen.measured.parameters import allowed_names, default_names, in_words, make_parameters
from tablegen.measured.search import Search, Targets
from tablegen.measured.search_coordinates import SHARES, bernstein
from tablegen.measured.trials import Evaluations, TrialPairs

CORUNDUM = load_config("corundum-steel")
TABLE = {"angle_deg": [0.0, 90.0], "value": [0.9, 0.2]}
LAWS = {
    "restitution": [
        {"law": "polynomial", "coefficients": [0.993, -1.76, 1.56, -0.49]},
        {"law": "constant", "value": 0.5},
        {"law": "power", "coefficient": 0.5, "reference_speed": 9.0, "exponent": 0.2},
        {"law": "tabulated", **TABLE, "speed": [50.0, 100.0], "value": [[0.9, 0.8], [0.4, 0.3]]},
    ],
    "resistance": [
        {"law": "constant", "value": 0.5},
        {"law": "tabulated", **TABLE},
        {"law": "coulomb", "static": 0.4, "dynamic": 0.3},
    ],
}


def changed(**changes):
    return CORUNDUM.with_changes({"domain": {"extrapolate": True}} | changes)


def with_law(section, law):
    return changed(pair={section: {**law, "source": "test"}})


CONFIGS = [CORUNDUM]
CONFIGS += [with_law(section, law) for section, laws in LAWS.items() for law in laws]
CONFIGS += [changed(population={"aspect": {"distribution": "fixed", "values": [0.8, 0.6]}})]
COULOMB = with_law("resistance", LAWS["resistance"][2])


@pytest.mark.parametrize("config", CONFIGS)
def test_the_start_is_the_given_pair_and_every_place_is_a_pair(config):
    names = [name for name in allowed_names(config) if not name.startswith("population.shapes.")]
    trials = TrialPairs(config, make_parameters(config, names), 0.0)
    x, low, high, first, last, _ = trials.space
    ours, theirs = trials.pair(x).kernel_arguments(), config.pair.kernel_arguments()
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9)
    here, there = trials.population(x).kernel_arguments(), config.population.kernel_arguments()
    np.testing.assert_allclose(here.cumulative_weights, there.cumulative_weights, atol=1e-7)
    np.testing.assert_allclose(here.aspect, there.aspect, rtol=1e-6)
    assert trials.wall_tilt_deg(x) == 0.0
    assert len(trials.labels) == len(trials.numbers(x)) == len(x)
    rng = np.random.default_rng(3)
    for x in (low, high, first, last, *(rng.uniform(low, high) for _ in range(3))):
        trials.pair(x)
        trials.population(x).kernel_arguments()
        shares = trials.shares(x)
        assert shares.min() >= 0.0
        assert shares.sum() == pytest.approx(1.0)
        assert len(shares) == len(trials.every_shape(x).strata())


@pytest.mark.parametrize(("name", "low", "high"), [("static", 0.3, 10.0), ("dynamic", 0.0, 0.4)])
def test_one_friction_coefficient_stays_on_its_side_of_the_other(name, low, high):
    trials = TrialPairs(COULOMB, make_parameters(COULOMB, [f"pair.resistance.{name}"]), 0.0)
    assert (trials.space.low[0], trials.space.high[0]) == (low, high)
    for x in (trials.space.low, trials.space.high):
        trials.pair(x)


def test_shares_of_one_shape_leave_the_others_their_ratios():
    weights = {"ellipsoid": 1.0, "prism": 3.0, "truncated-prism": 0.0, "tetrahedron": 0.0}
    config = changed(population={"shapes": weights})
    trials = TrialPairs(config, make_parameters(config, ["population.shapes.sphere"]), 0.0)
    found = trials.population(np.array([0.5])).shapes.positive()
    assert found == pytest.approx({"ellipsoid": 0.5, "prism": 1.5, "sphere": 2.0})
    assert trials.of_shares.all()


def test_slopes_of_numbers_by_coordinates():
    trials = TrialPairs(CORUNDUM, make_parameters(CORUNDUM, ["pair.restitution.coefficient"]), 0.0)
    # a logarithm: the slope is the number itself
    np.testing.assert_allclose(trials.slopes(trials.space.start), [[0.1]], rtol=1e-6)


def test_coordinates_keep_rules_between_numbers():
    """Polynomials stay from 0 to 1, and shares add up to at most 1."""
    rng, scale, grid = np.random.default_rng(4), bernstein(5, np.pi / 2), np.linspace(0, np.pi / 2)
    for _ in range(50):
        x = rng.uniform(0.0, 1.0, 5)
        values = np.polynomial.Polynomial(scale.values(x))(grid)
        assert values.min() > -1e-12
        assert values.max() < 1.0 + 1e-12
        np.testing.assert_allclose(values[[0, -1]], x[[0, -1]], atol=1e-12)
        shares = SHARES.values(x)
        assert shares.min() >= 0.0
        assert shares.sum() <= 1.0 + 1e-15
        np.testing.assert_allclose(SHARES.coordinates(shares), x)


def test_default_names():
    assert default_names(CORUNDUM, 6) == (
        "pair.restitution.coefficient",
        "pair.restitution.exponent",
        "pair.resistance.strength",
        "pair.resistance.factor",
        "population.aspect.mean",
    )
    # four shapes have three shares
    assert default_names(CORUNDUM, 9)[5:] == ("population.shapes",)
    assert "population.aspect.standard_deviation" in default_names(CORUNDUM, 10)


def test_rare_shapes_are_left_out():
    trials = TrialPairs(CORUNDUM, make_parameters(CORUNDUM, ["population.shapes"]), 0.0)
    search = Search(Evaluations(trials, np.ones(1), np.ones(1), 1), Targets(), 200)
    for x, kept in (([0.5, 0.03, 0.5], [0.5, 0, 0.5]), ([0.01, 0.99, 0.4], [0, 1, 0])):
        np.testing.assert_array_equal(search._on_bounds(np.array(x)), kept)


def test_words():
    table = with_law("restitution", LAWS["restitution"][3])
    at = "restitution at 90 degrees and 100 m/s"
    assert in_words(table, "pair.restitution.value[1][1]") == at
    assert in_words(table, "population.aspect.mean") == "aspect ratio mean"
    assert in_words(table, "wall_tilt_deg") == "wall roughness"


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["domain.speed"], "free: got 'domain.speed', allowed: pair.restitution.coefficient, "),
        ([], r"free: got \[\], allowed: each name once, at least one"),
        (["wall_tilt_deg", "wall_tilt_deg"], "allowed: each name once"),
        (["population.shapes", "population.shapes.prism"], "allowed: one of both"),
    ],
)
def test_names_that_cannot_be_freed(names, said):
    with pytest.raises(InputError, match=said):
        make_parameters(CORUNDUM, names)


def test_a_start_out_of_bounds_is_refused():
    config = CORUNDUM.with_changes({"pair": {"resistance": {"factor": 0.0}}})
    said = r"^pair\.resistance\.factor: got 0 to start from, allowed: 0.001 to 100$"
    with pytest.raises(InputError, match=said):
        make_parameters(config, ["pair.resistance.factor"])
