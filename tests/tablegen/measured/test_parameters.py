"""Parameters that can be freed, their coordinates, and the pairs that they make."""

import numpy as np
import pytest

from sampler.errors import InputError
from tablegen import load_config
from tablegen.measured.coordinates import SHARES, bernstein
from tablegen.measured.parameters import allowed_names, default_names, make_parameters
from tablegen.measured.trials import TrialPairs

CORUNDUM = load_config("corundum-steel")
SOURCE = {"source": "test"}
LAWS = {
    "polynomial": {"law": "polynomial", "coefficients": [0.993, -1.76, 1.56, -0.49], **SOURCE},
    "constant": {"law": "constant", "value": 0.5, **SOURCE},
    "power": {
        "law": "power",
        "coefficient": 0.5,
        "reference_speed": 9.0,
        "exponent": 0.2,
        **SOURCE,
    },
    "tabulated": {
        "law": "tabulated",
        "angle_deg": [0.0, 90.0],
        "speed": [50.0, 100.0],
        "value": [[0.9, 0.8], [0.4, 0.3]],
        **SOURCE,
    },
}
RESISTANCES = {
    "constant": {"law": "constant", "value": 0.5, **SOURCE},
    "tabulated": {"law": "tabulated", "angle_deg": [0.0, 90.0], "value": [0.9, 0.2], **SOURCE},
    "coulomb": {"law": "coulomb", "static": 0.4, "dynamic": 0.3, **SOURCE},
}


def with_laws(restitution=None, resistance=None, **changes):
    pair = {}
    if restitution:
        pair["restitution"] = LAWS[restitution]
    if resistance:
        pair["resistance"] = RESISTANCES[resistance]
    return CORUNDUM.with_changes({"pair": pair, "domain": {"extrapolate": True}, **changes})


CONFIGS = {
    "exponential": CORUNDUM,
    **{name: with_laws(name) for name in LAWS},
    **{f"{name} resistance": with_laws(resistance=name) for name in RESISTANCES},
    "fixed aspect": with_laws(
        population={"aspect": {"distribution": "fixed", "values": [0.8, 0.6]}}
    ),
}


def every_trial(config):
    """Trials with all free but single shapes."""
    names = [name for name in allowed_names(config) if not name.startswith("population.shapes.")]
    return TrialPairs(config, make_parameters(config, names), 0.0)


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_the_start_is_the_given_pair(config):
    trials = every_trial(config)
    x = trials.space.start
    assert (trials.space.low <= x).all()
    assert (x <= trials.space.high).all()
    ours, theirs = trials.pair(x).kernel_arguments(), config.pair.kernel_arguments()
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9)
    here, there = trials.population(x).kernel_arguments(), config.population.kernel_arguments()
    np.testing.assert_allclose(here.cumulative_weights, there.cumulative_weights, atol=1e-7)
    np.testing.assert_allclose(here.aspect, there.aspect, rtol=1e-6)
    assert trials.wall_tilt_deg(x) == 0.0
    assert len(trials.labels) == len(trials.numbers(x)) == len(x)


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_every_place_within_the_bounds_is_a_pair(config):
    rng, trials = np.random.default_rng(3), every_trial(config)
    _, low, high, first, last, _ = trials.space
    places = [low, high, first, last, *(rng.uniform(low, high) for _ in range(3))]
    for x in places:
        trials.pair(x)
        trials.population(x).kernel_arguments()
        shares = trials.shares(x)
        assert shares.min() >= 0.0
        assert shares.sum() == pytest.approx(1.0)
        assert len(shares) == len(trials.every_shape(x).strata())


@pytest.mark.parametrize("name", ["static", "dynamic"])
def test_one_friction_coefficient_stays_on_its_side_of_the_other(name):
    config = with_laws(resistance="coulomb")
    trials = TrialPairs(config, make_parameters(config, [f"pair.resistance.{name}"]), 0.0)
    space = trials.space
    for x in (space.low, space.start, space.high):
        trials.pair(x)
    assert (space.low[0] == 0.3) == (name == "static")
    assert (space.high[0] == 0.4) == (name == "dynamic")


def test_shares_of_one_shape_leave_the_others_their_ratios():
    weights = {"ellipsoid": 1.0, "prism": 3.0, "truncated-prism": 0.0, "tetrahedron": 0.0}
    config = with_laws(population={"shapes": weights})
    trials = TrialPairs(config, make_parameters(config, ["population.shapes.sphere"]), 0.0)
    found = trials.population(np.array([0.5])).shapes.positive()
    assert found == pytest.approx({"ellipsoid": 0.5, "prism": 1.5, "sphere": 2.0})
    assert trials.of_shares.all()


def test_slopes_of_numbers_by_coordinates():
    trials = TrialPairs(CORUNDUM, make_parameters(CORUNDUM, ["pair.restitution.coefficient"]), 0.0)
    # a logarithm: the slope is the number itself
    np.testing.assert_allclose(trials.slopes(trials.space.start), [[0.1]], rtol=1e-6)


def test_bernstein_coefficients_from_0_to_1_give_polynomials_that_stay_there():
    rng, scale, grid = np.random.default_rng(4), bernstein(5, np.pi / 2), np.linspace(0, np.pi / 2)
    for _ in range(50):
        coefficients = rng.uniform(0.0, 1.0, 5)
        values = np.polynomial.Polynomial(scale.values(coefficients))(grid)
        assert values.min() > -1e-12
        assert values.max() < 1.0 + 1e-12
        # the ends are the first and the last coefficient
        np.testing.assert_allclose(values[[0, -1]], coefficients[[0, -1]], atol=1e-12)


def test_shares_never_add_up_to_more_than_one():
    rng = np.random.default_rng(4)
    for _ in range(50):
        x = rng.uniform(0.0, 1.0, 4)
        shares = SHARES.values(x)
        assert shares.min() >= 0.0
        assert shares.sum() <= 1.0 + 1e-15
        np.testing.assert_allclose(SHARES.coordinates(shares), x)
    assert SHARES.coordinates(np.array([0.2, 0.8, 0.0])).tolist() == pytest.approx([0.2, 1.0, 0.0])


def test_names():
    assert default_names(CORUNDUM) == (
        "pair.restitution.coefficient",
        "pair.restitution.exponent",
        "pair.resistance.strength",
        "pair.resistance.factor",
        "population.aspect.mean",
    )
    none = dict.fromkeys(("ellipsoid", "prism", "truncated-prism", "tetrahedron"), 0.0)
    spheres = with_laws(population={"shapes": none | {"sphere": 1.0}})
    assert not {"population.truncation", "population.shapes"} & set(allowed_names(spheres))


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["domain.speed"], "free: got 'domain.speed', allowed: pair.restitution.coefficient, "),
        ([], "free: got [], allowed: each name once, at least one"),
        (["wall_tilt_deg", "wall_tilt_deg"], "allowed: each name once"),
        (["population.shapes", "population.shapes.prism"], "allowed: one of both"),
    ],
)
def test_names_that_cannot_be_freed(names, said):
    with pytest.raises(InputError) as error:
        make_parameters(CORUNDUM, names)
    assert said in str(error.value)


def test_a_start_out_of_bounds_is_refused():
    config = CORUNDUM.with_changes({"pair": {"resistance": {"factor": 0.0}}})
    said = r"^pair\.resistance\.factor: got 0 to start from, allowed: 0.001 to 100$"
    with pytest.raises(InputError, match=said):
        make_parameters(config, ["pair.resistance.factor"])
