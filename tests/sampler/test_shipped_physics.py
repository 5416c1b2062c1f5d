"""What physics forbids never comes out of the shipped table: a billion draws over its domain."""

from itertools import product

import numba
import numpy as np
import pytest
from scipy.stats import ks_2samp

import sampler
from tablegen import DirectModel, load_config

N, BATCH = 1_000_000_000, 10_000_000
WITH_SPIN = [
    "corundum-steel",
    "corundum-steel-compact",
    "forder-1998",
    "wakeman-tabakoff-1981",
    "grant-tabakoff-1975",
]


@numba.njit(nogil=True)
def forbidden(states):
    """How many states are not finite, do not leave the wall, or gain translational energy."""
    bad = 0
    for k in range(states.shape[0]):
        u, v, w = states[k, 0], states[k, 1], states[k, 2]
        total = u + v + w + states[k, 3] + states[k, 4] + states[k, 5]
        if not (np.isfinite(total) and v > 0.0 and u * u + v * v + w * w <= 1.0):
            bad += 1
    return bad


def _draw_and_count(draws):
    table = sampler.load("corundum-steel", outside="raise")
    rng = np.random.Generator(np.random.Philox(key=20))
    (low, high), speeds = np.radians(table.alpha_nodes_deg[[0, -1]]), table.speed_nodes[[0, -1]]
    batch = min(draws, BATCH)
    states, index = np.empty((batch, 6)), np.arange(batch, dtype=np.uint64)
    count = 0
    for hit in range(draws // batch):
        # angles denser near grazing, where there is least room
        alpha1 = low + (high - low) * rng.random(batch) ** 2
        speed = rng.uniform(*speeds, batch)
        table.sample(alpha1, speed, seed=hit, index=index, hit=hit, out=states)
        count += forbidden(states)
    return count


def test_a_million_draws():
    assert _draw_and_count(1_000_000) == 0


@pytest.mark.study
def test_a_billion_draws():
    assert _draw_and_count(N) == 0


@pytest.mark.study
@pytest.mark.parametrize("name", WITH_SPIN)
def test_mirror_images_in_the_plane_of_impact(name):
    """Differ by chance alone: false-alarm rate 1e-3 of a table, by Kolmogorov's bound."""
    table, n = sampler.load(name), 200_000
    index, angles = np.arange(n), np.radians([2.0, 10.0, 30.0, 60.0, 85.0])
    bound = np.sqrt(np.log(2.0 * 6 * 3 * len(angles) / 1e-3) / n)
    for alpha1, (x, y, z) in product(angles, [(0, 1.5, 0.2), (0, 3.5, -1), (0, 0, 0.8)]):
        sides = [
            table.sample(
                alpha1, 100.0, spin=(x, side * y, z), seed=int(side + 9), index=index, hit=2
            )
            for side in (1.0, -1.0)
        ]
        mirrored = sides[1] * [1.0, 1.0, -1.0, -1.0, -1.0, 1.0]
        assert ks_2samp(sides[0], mirrored).statistic.max() < bound
        if y == 0:
            across = sides[0][:, 2:5]
            assert (np.abs(across.mean(axis=0)) < 3.5 * across.std(axis=0) / np.sqrt(n)).all()


@pytest.mark.study
def test_handed_grains_spin_about_the_normal_as_in_direct_simulation():
    """Tetrahedra differ from their mirror images; two samples of one law are 0.002 apart at most.

    The bound is Kolmogorov's at 1e-3.
    """
    n, noise = 2_000_000, np.sqrt(np.log(2.0 / 1e-3) / 2_000_000)
    given = {"alpha1": np.pi / 2.0, "speed": 300.0, "index": np.arange(n), "hit": 0}
    table = sampler.load("corundum-steel").sample(**given, seed=1)[:, 4]
    model = DirectModel(load_config("corundum-steel")).sample(**given, seed=2)[:, 4]
    assert ks_2samp(model, -model).statistic > 0.008
    assert ks_2samp(table, -table).statistic == pytest.approx(0.012, abs=noise)
    assert ks_2samp(table, model).statistic < 0.004 + noise
    rounded = sampler.load("forder-1998").sample(**given, seed=1)[:, 4]
    assert (np.abs(rounded) < 1e-9).mean() == pytest.approx(0.56, abs=0.01)
