"""Particles in lockstep have the same bits as one at a time, whatever is in the other lanes."""

import numpy as np
import pytest
from crowds import CROWD
from motion_fixtures import ALLOWED, PAIR

from tablegen.model.impacts import condition_row
from tablegen.model.random_particles import ParticleKeys, draw_grain, draw_particles
from tablegen.model.simd import WIDTH
from tablegen.simulation.simulate import make_condition, simulate_condition

pytestmark = pytest.mark.processor

SPINS = [(0.0, 0.0, 0.0), (1.0, -2.0, 3.0)]


def same(pair, population, condition, count, seed=5):
    """Compare a run in lockstep with an audited one, which follows one particle at a time."""
    together = simulate_condition(pair, population, condition, count, seed=seed)
    alone = simulate_condition(pair, population, condition, count, seed=seed, audited=True)
    for field in ("state", "collisions", "shape", "aspect", "energy", "work", "inertia"):
        np.testing.assert_array_equal(getattr(together, field), getattr(alone, field), field)
    assert np.all(alone.audit <= ALLOWED), alone.audit
    return together


@pytest.mark.parametrize(("spin", "inertia"), [(SPINS[0], 0.0), (SPINS[1], 0.0), (SPINS[1], 0.3)])
@pytest.mark.parametrize("alpha_deg", [0.05, 0.5, 20.0, 90.0])
def test_a_crowd_of_all_shapes_and_meshes(alpha_deg, spin, inertia):
    condition = make_condition(np.radians(alpha_deg), 200.0, spin, inertia=inertia)
    simulation = same(PAIR, CROWD, condition, 2000)
    assert len(np.unique(simulation.shape)) == 6


@pytest.mark.parametrize("count", [1, WIDTH - 1, WIDTH, WIDTH + 1, 5 * WIDTH + 3])
def test_few_particles(count):
    same(PAIR, CROWD, make_condition(0.6, 150.0), count)


def test_draws_in_lanes_are_those_of_one_particle():
    population_args = CROWD.kernel_arguments()
    index = np.arange(2**40, 2**40 + 1001, dtype=np.uint64)
    hit, grain = np.arange(1001, dtype=np.uint32) % 3, np.ones(1, dtype=np.uint32)
    keys = ParticleKeys(np.uint64(2**63 + 5), index, hit, grain)
    axes, kind = np.empty((1001, 6)), np.empty((1001, 3))
    conditions = np.repeat(
        condition_row(make_condition(0.5, 200.0, SPINS[1], inertia=0.3)), 1001, axis=0
    )
    conditions[::2, 3:6] = 0.0
    draw_particles(population_args, conditions, keys, axes, kind)
    for i in range(len(axes)):
        alone, one = np.empty((1, 6)), keys._replace(particle=index[i : i + 1], hit=hit[i : i + 1])
        draw_particles(population_args, conditions[i : i + 1], one, alone, np.empty((1, 3)))
        np.testing.assert_array_equal(alone[0], axes[i])
        drawn = draw_grain(population_args, keys.seed, index[i], grain[0])
        np.testing.assert_array_equal(drawn, kind[i])
