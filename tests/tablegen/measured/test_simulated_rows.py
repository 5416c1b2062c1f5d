"""Simulated means and spreads, against plain simulations and their own symmetries."""

import numpy as np
import pytest
from crowds import CROWD

from tablegen.config.config import load_config
from tablegen.measured.measurements import QUANTITIES
from tablegen.measured.moments import variables_of
from tablegen.measured.simulated_rows import SimulatedRows
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.simulate import simulate

CONFIG = load_config("corundum-steel")
PAIR, MIXTURE = CONFIG.pair, CONFIG.population


def make_rows(
    alpha_deg=45.0, speed=100.0, tilt=0.0, population=MIXTURE, pair=PAIR, seed=1, threads=2
):
    alpha_deg = np.atleast_1d(alpha_deg)
    speeds = np.full(len(alpha_deg), speed)
    config = CONFIG.model_copy(update={"pair": pair, "population": population})
    keys = {"seed": seed, "wall_tilt_deg": tilt, "threads": threads}
    return SimulatedRows(config, alpha_deg, speeds, **keys)


@pytest.mark.parametrize("tilt", [0.0, 6.0])
def test_strata_are_the_plain_mixture_within_chance(tilt):
    """Means and spreads at 30 degrees within five standard errors; at 35 they are refused."""
    n, alpha = 8_000, np.radians(30.0)
    if tilt:
        velocity = 100.0 * np.array([np.cos(alpha), -np.sin(alpha), 0.0])
        keys = {"seed": 8, "index": np.arange(n), "roughness": np.radians(tilt)}
        after = DirectModel(CONFIG).rebound(velocity, (0, 1, 0), 1e-5, **keys)
        plain = np.hstack([after.velocity, 1e-5 * after.omega]) / 100.0
    else:
        plain = simulate(CONFIG, alpha, 100.0, n, seed=8).state
    moments = make_rows([30.0, 35.0], tilt=tilt).moments(n // 4)
    x, far = variables_of(plain), []
    for name, scale in {"e_n": 2.0, "e_t": 1 / np.cos(alpha), "omega_z": 1.0}.items():
        column = scale * x[:, QUANTITIES[name].variable]
        # both have the same number of particles
        for value, error, ours in (
            (moments.mean, moments.mean_error, column.mean()),
            (moments.std, moments.std_error, column.std()),
        ):
            off = (value[name] - ours) / (np.sqrt(2.0) * error[name])
            assert abs(off[0]) < 5.0, name
            far.append(abs(off[1]))
    assert max(far) > 10.0


def test_spheres_have_the_closed_form_and_no_spread():
    moments = make_rows([20.0, 60.0], population=MIXTURE.restricted_to("sphere")).moments(50)
    for k, alpha in enumerate(np.radians([20.0, 60.0])):
        spheres = MIXTURE.restricted_to("sphere")
        (state,) = simulate(CONFIG, alpha, 100.0, 1, seed=3, population=spheres).state
        u, v, omega = state[0], state[1], state[5]
        expected = (v / np.sin(alpha), u / np.cos(alpha), np.degrees(np.arctan2(v, u)), 0.0, omega)
        for name, value in zip(QUANTITIES, expected, strict=True):
            assert moments.mean[name][k] == pytest.approx(value, abs=1e-12), name
            assert moments.std[name][k] < 1e-10


def test_random_numbers_are_common():
    """Rows differ; a law that changes a little changes every moment a little, and smoothly."""
    two = make_rows([45.0, 45.0]).moments(300)
    assert two.mean["e_n"][0] != two.mean["e_n"][1]
    values = []
    for strength in (1.0, 1.001, 1.002):
        resistance = PAIR.resistance.model_copy(update={"strength": strength})
        pair = PAIR.model_copy(update={"resistance": resistance})
        values.append(make_rows(pair=pair).moments(300).mean["e_t"][0])
    steps = np.diff(values)
    assert 0.0 < abs(steps[0]) < 1e-3
    assert steps[1] == pytest.approx(steps[0], rel=0.2)


def test_shapes_have_the_same_particles_whatever_their_weights():
    """So the mean is linear in the weights; meshes are shapes, too."""
    means = []
    for part in (0.0, 0.25, 1.0):
        weights = type(MIXTURE.shapes)(ellipsoid=1.0 - part, tetrahedron=part)
        mixed = MIXTURE.model_copy(update={"shapes": weights})
        means.append(make_rows(population=mixed).moments(200).mean["e_n"][0])
    assert means[1] == pytest.approx(0.75 * means[0] + 0.25 * means[2])
    assert np.isfinite(make_rows(population=CROWD).moments(40).mean["e_n"]).all()
