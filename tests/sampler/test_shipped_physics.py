"""What physics forbids never comes out of the shipped table: a billion draws over its domain."""

import numba
import numpy as np
import pytest

import sampler

N, BATCH = 1_000_000_000, 10_000_000


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
    (low, high), speeds = table.alpha_range, table.speed_range
    batch = min(draws, BATCH)
    states, index = np.empty((batch, 6)), np.arange(batch, dtype=np.uint64)
    found = 0
    for hit in range(draws // batch):
        # angles denser near grazing, where there is least room
        alpha1 = low + (high - low) * rng.random(batch) ** 2
        speed = rng.uniform(*speeds, batch)
        table.sample(alpha1, speed, seed=hit, index=index, hit=hit, out=states)
        found += forbidden(states)
    return found


def test_a_million_draws():
    assert _draw_and_count(1_000_000) == 0


@pytest.mark.study
def test_a_billion_draws():
    assert _draw_and_count(N) == 0
