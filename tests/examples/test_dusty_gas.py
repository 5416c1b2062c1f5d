"""Dusty gas: flight and hits against an independent integration, and the models of the wall."""

import re

import dusty_gas
import numpy as np
import pytest
from dusty_gas import BAND, COLUMNS, LEFT, PITCH, ROWS, STEP, Gas
from scipy.integrate import solve_ivp

from tablegen import DirectModel


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("stokes", [1.0, 30.0])
def test_hits_are_those_of_an_independent_integration(dimension, stokes):
    gas, start = Gas(dimension, 1.0 / stokes, 80.0), (-4.0, 0.1, 0.0, 1.0, 0.0, 0.0)

    def slope(_, s):
        x, y, u, v = s
        r = np.hypot(x, y)
        flow = 1.0 - 1.0 / complex(x, y) ** 2  # of the complex potential z + 1/z
        wind = np.array([flow.real, -flow.imag])
        if dimension == 3:
            wind = np.array([1.0 + 0.5 / r**3 - 1.5 * x * x / r**5, -1.5 * x * y / r**5])
        slip = wind - (u, v)
        return u, v, *(slip / stokes * (1.0 + 0.15 * (80.0 * np.hypot(*slip)) ** 0.687))

    def surface(_, s):
        return np.hypot(s[0], s[1]) - 1.0

    surface.terminal = True
    given = {"method": "DOP853", "events": surface, "rtol": 1e-11}
    made = solve_ivp(slope, (0.0, 12.0), (-4.0, 0.1, 1.0, 0.0), **given)
    p, passed = start, 0.0
    while dusty_gas.radius(gas, end := dusty_gas.step(gas, p, STEP)) > 1.0:
        p, passed = end, passed + STEP
    flown = dusty_gas.hit_time(gas, p, STEP)
    p = dusty_gas.step(gas, p, flown)
    assert passed + flown == pytest.approx(made.t_events[0][0], abs=3e-4)
    np.testing.assert_allclose(np.take(p, [0, 1, 3, 4]), made.y_events[0][0], atol=1e-3)


@pytest.mark.parametrize("body", ["cylinder", "sphere"])
def test_the_density_of_a_uniform_stream_is_one(body):
    """Points at random in the stream, as many as there are time steps of particles."""
    rng, particles = np.random.default_rng(1), 20_000
    n = round(particles * COLUMNS * PITCH / STEP)
    a = rng.random(n)
    across = BAND * (np.abs(2.0 * a - 1.0) if body == "cylinder" else np.sqrt(a))
    edges = PITCH * np.arange(ROWS + 1), LEFT + PITCH * np.arange(COLUMNS + 1)
    along = LEFT + PITCH * COLUMNS * rng.random(n)
    found = dusty_gas.density(body, np.histogram2d(across, along, edges)[0], particles)
    assert np.nanmean(found[40:]) == pytest.approx(1.0, abs=0.01)
    assert np.isnan(found[:30, 100:105]).all()


def test_models_of_the_wall_are_those_of_python_and_the_table_has_the_law(table, config, capsys):
    direct = DirectModel(config)
    impact = (70.0, -60.0, 20.0), (0.6, 0.8, 0.0), 2e-5
    keys = {"omega": (2e6, -3e6, 4e6), "seed": dusty_gas.SEED, "index": 7, "hit": 2}
    left, grain = (0.1, 0.5, -0.7, 0.5), direct.grains(dusty_gas.SEED, 7)
    met, _ = direct.tumble(left, keys["omega"], grain, impact[2], 2e-5)
    models = {
        dusty_gas.simulated: (direct.arrays, direct.rebound(*impact, orientation=met, **keys)),
        dusty_gas.drawn: (table.handle, table.rebound(*impact, **keys)),
    }
    for wall, (arrays, expected) in models.items():
        out, work = np.empty(6), np.empty(direct.work_size)
        turning = (np.array(left), 2e-5)
        assert wall(arrays, *impact, keys["omega"], turning, (7, 2), work, out) == 0
        np.testing.assert_allclose(out, np.concatenate(expected[:2]), rtol=1e-9)
    np.testing.assert_array_equal(turning[0], left)  # the table has no use for it
    dusty_gas.main(["--count", "3200"])
    found = re.findall(r"([\d.]+)%", capsys.readouterr().out)
    off, chance = np.array(found, float).reshape(6, 2).T
    assert (off[[1, 4]] < 2.0 * chance[[1, 4]]).all()  # table, past a cylinder and a sphere
    assert (off[[2, 5]] > 20.0).all()  # spheres
