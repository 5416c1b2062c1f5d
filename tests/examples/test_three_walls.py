"""Compiled examples through three walls: the table beside direct simulation that tumbles."""

import dusty_gas
import numba
import numpy as np
import particles
import pytest
from scipy.stats import ks_2samp

from tablegen import DirectModel

N = 40_000


def agree(found, direct, most=0.015):
    """Whether mean squares are within 1.5 % and two standard errors, of each column.

    An exact law fails with a probability below 1e-4 a column.
    """
    a, b = found**2, direct**2
    error = np.hypot(a.std(axis=0) / b.mean(axis=0), b.std(axis=0) / b.mean(axis=0)) / np.sqrt(N)
    return np.abs(a.mean(axis=0) / b.mean(axis=0) - 1.0) < most + 2.0 * error


@numba.njit
def crossed(wall, arrays, n, keeps, work):
    """Speeds of particles after each of three walls, met in turn, by a wall of `dusty_gas`."""
    speeds = np.empty((n, 3))
    for k in range(n):
        v, out, turned = (180.0, -140.0, 0.0), np.zeros(6), np.zeros(4)
        for hit in range(3):
            side = 1.0 if hit % 2 == 0 else -1.0
            normal, time = (0.0, side, 0.0), 2e-4 / max(np.hypot(v[0], v[1]), 1e-3)
            omega = (out[3], out[4], out[5])
            wall(arrays, v, normal, 2e-5, omega, (turned, time), (k, hit), work, out)
            if not keeps:
                out[3:] = 0.0
            v = (out[0], out[1], out[2])
            speeds[k, hit] = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    return speeds


def test_walls_of_the_dusty_gas(table, config):
    model = DirectModel(config)
    work = np.empty(model.work_size)
    direct = crossed(dusty_gas.simulated, model.arrays, N, True, work)
    assert agree(crossed(dusty_gas.drawn, table.handle, N, True, work), direct).all()
    assert not agree(crossed(dusty_gas.drawn, table.handle, N, False, work), direct)[2]


@pytest.mark.parametrize("spinning", [True, False])
def test_particles_between_plates(table, config, spinning):
    """Speeds and spins after three plates; a loop that loses its spins is seen."""
    velocity, omega, _, (failed, _) = particles.run(table, N, 3, 0.0)
    model, moving, turning = DirectModel(config), *particles.start(N)
    keys, turned = {"seed": particles.SEED + 1, "index": np.arange(N)}, None
    for hit in range(3):
        normal = np.array([0.0, 1.0 - 2.0 * (hit % 2), 0.0])
        given = {"omega": turning if spinning else None, "orientation": turned, "hit": hit, **keys}
        moving, turning, left = model.rebound(moving, normal, particles.HALF_SIZE, **given)
        moving += 0.8 * (np.array([150.0, 80.0 * normal[1], 0.0]) - moving)
        time = 10.0 * particles.HALF_SIZE / np.linalg.norm(moving, axis=1)
        grain = model.grains(keys["seed"], keys["index"])
        turned, _ = model.tumble(left, turning, grain, particles.HALF_SIZE, time)
        turned = turned if spinning else None
    assert failed == 0
    distances = [
        ks_2samp(table_side, direct_side).statistic
        for table_side, direct_side in (
            (velocity[:, 0], moving[:, 0]),
            (omega[:, 2], turning[:, 2]),
        )
    ]
    # equal laws exceed 0.014 in one of 700
    assert (max(distances) < 0.015 + 0.014) == spinning
