"""Simulated means and spreads, against plain simulations and their own symmetries."""

import numpy as np
import pytest
from crowds import CROWD

from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.measured.records import QUANTITIES
from tablegen.measured.simulated_moments import SimulatedRows
from tablegen.measured.strata import variables_of
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.simulate import simulate

CONFIG = load_config("corundum-steel")
PAIR, MIXTURE = CONFIG.pair, CONFIG.population
SPHERES = MIXTURE.restricted_to("sphere")


def moments(alpha_deg=45.0, speed=100.0, count=300, population=MIXTURE, **changes):
    return SimulatedRows(PAIR, population, alpha_deg, speed, **{"seed": 1} | changes).moments(count)


def same(a, b):
    return all(
        np.array_equal(x[name], y[name], equal_nan=True)
        for x, y in ((a.mean, b.mean), (a.std, b.std), (a.std_error, b.std_error))
        for name in QUANTITIES
    )


@pytest.mark.parametrize("tilt", [0.0, 6.0])
def test_strata_are_the_plain_mixture_within_chance(tilt):
    """Means and spreads at 30 degrees within five standard errors; at 35 they are refused."""
    n, alpha = 20_000, np.radians(30.0)
    if tilt:
        velocity = 100.0 * np.array([np.cos(alpha), -np.sin(alpha), 0.0])
        keys = {"seed": 8, "index": np.arange(n), "roughness": np.radians(tilt)}
        plain = np.hstack(DirectModel(CONFIG).rebound(velocity, (0, 1, 0), 1.0, **keys)) / 100.0
    else:
        plain = simulate(CONFIG, alpha, 100.0, n, seed=8).state
    found = moments([30.0, 35.0], count=n // 4, wall_tilt_deg=tilt)
    x = variables_of(plain)
    far = []
    for name, k, scale in (
        ("e_n", 1, 2.0),
        ("e_t", 0, 1.0 / np.cos(alpha)),
        ("out_of_plane_deg", 3, 1.0),
        ("omega_z", 4, 1.0),
    ):
        # both have as many particles
        for value, error, ours in (
            (found.mean, found.mean_error, x[:, k].mean()),
            (found.std, found.std_error, x[:, k].std()),
        ):
            off = (value[name] - scale * ours) / (np.sqrt(2.0) * error[name])
            assert abs(off[0]) < 5.0, name
            far.append(abs(off[1]))
    assert max(far) > 20.0


def test_spheres_have_the_closed_form_and_no_spread():
    """Of one collision: what the model itself gives for one sphere."""
    found = moments([20.0, 60.0], count=50, population=SPHERES)
    for k, alpha_deg in enumerate((20.0, 60.0)):
        alpha = np.radians(alpha_deg)
        one = simulate(CONFIG, alpha, 100.0, 1, seed=3, population=SPHERES)
        u, v, w, _, _, omega = one.state[0]
        assert abs(w) < 1e-15
        expected = (v / np.sin(alpha), u / np.cos(alpha), np.degrees(np.arctan2(v, u)), 0.0, omega)
        for name, value in zip(QUANTITIES, expected, strict=True):
            assert found.mean[name][k] == pytest.approx(value, abs=1e-12), name
            assert found.std[name][k] < 1e-10
    assert (found.mean["omega_z"] < 0.0).all()


def test_no_result_depends_on_threads():
    assert same(moments([30.0, 80.0], threads=1), moments([30.0, 80.0], threads=2))


def test_random_numbers_are_common():
    """Rows differ; a law that changes a little changes every moment a little, and smoothly."""
    two = moments([45.0, 45.0])
    assert two.mean["e_n"][0] != two.mean["e_n"][1]
    values = []
    for strength in (1.0, 1.001, 1.002):
        resistance = PAIR.resistance.model_copy(update={"strength": strength})
        pair = PAIR.model_copy(update={"resistance": resistance})
        found = SimulatedRows(pair, MIXTURE, 45.0, 100.0, seed=1).moments(300)
        values.append(found.mean["e_t"][0])
    steps = np.diff(values)
    assert 0.0 < abs(steps[0]) < 1e-3
    assert steps[1] == pytest.approx(steps[0], rel=0.2)


def test_strata_do_not_depend_on_the_weights():
    weights = {"ellipsoid": 0.1, "tetrahedron": 0.9}
    lopsided = MIXTURE.model_copy(update={"shapes": type(MIXTURE.shapes)(**weights)})
    uneven = SimulatedRows(PAIR, lopsided, 45.0, 100.0, seed=1).strata(200)
    even = SimulatedRows(PAIR, MIXTURE, 45.0, 100.0, seed=1).strata(200)
    np.testing.assert_allclose(uneven.shares, [0.1, 0.9])
    np.testing.assert_array_equal(uneven.moments.mean, even.moments.mean[:, [0, 3]])
    assert same(uneven.mixed(), even.mixed([0.1, 0.0, 0.0, 0.9]))


def test_meshes_are_strata_too():
    strata = SimulatedRows(PAIR, CROWD, 45.0, 100.0, seed=1).strata(40)
    assert strata.moments.mean.shape[1] == len(CROWD.strata())
    assert strata.shares.sum() == pytest.approx(1.0)


def test_tilt_goes_to_the_smooth_wall_and_widens_the_spread():
    smooth, faint, rough = (moments(30.0, wall_tilt_deg=tilt) for tilt in (0.0, 1e-4, 10.0))
    for name in QUANTITIES:
        np.testing.assert_allclose(faint.mean[name], smooth.mean[name], atol=1e-2)
    assert rough.std["e_t"] > 1.02 * smooth.std["e_t"]
    assert rough.std["out_of_plane_deg"] > smooth.std["out_of_plane_deg"]


def test_spin_before_the_impact_counts():
    top, back = (moments(spin=(0.0, 0.0, z)).mean["e_t"][0] for z in (-0.8, 0.8))
    assert top > back + 0.1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"alpha_deg": [30.0, 91.0]}, r"^alpha_deg: got 91 degrees, allowed: 1e-06 to 90 degrees$"),
        ({"alpha_deg": 0.0}, r"^alpha_deg: got 0"),
        ({"alpha_deg": []}, r"^alpha_deg: got shape \(0,\), allowed: \(n,\)"),
        ({"alpha_deg": [[30.0]]}, r"^alpha_deg: got shape \(1, 1\)"),
        ({"speed": [1.0, 2.0, 3.0], "alpha_deg": [1.0, 2.0]}, r"^speed: got shape \(3,\)"),
        ({"speed": np.nan}, r"^speed: got nan"),
        ({"count": 1}, r"^count: got 1, allowed: 2 to"),
        ({"seed": -1}, r"^seed: got -1"),
        ({"wall_tilt_deg": 29.0}, r"^wall_tilt_deg: got 29, allowed: 0 to 28.65 degrees$"),
        ({"wall_tilt_deg": -1.0}, r"^wall_tilt_deg: got -1"),
        ({"wall_tilt_deg": "much"}, r"^wall_tilt_deg: got 'much'"),
        ({"spin": (1.0, 2.0)}, r"^spin: got shape \(2,\), allowed: \(3,\)"),
    ],
)
def test_wrong_arguments_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        moments(**changes)
