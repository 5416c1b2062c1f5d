"""Particles in lockstep have the same bits as one at a time, whatever is in the other lanes."""

import numpy as np
import pytest
from crowds import CROWD
from motion_fixtures import ALLOWED, PAIR
from one_particle import prepared_rows, shapes_of, simulate_alone

from tablegen.model.random_particles import prepare_particles
from tablegen.model.simd import WIDTH
from tablegen.simulation.simulate import make_condition, simulate_condition

pytestmark = pytest.mark.processor

SPINS = [(0.0, 0.0, 0.0), (1.0, -2.0, 3.0)]


def same(pair, population, condition, count, seed=5):
    """Compare a run in lockstep with one that follows one particle at a time."""
    together = simulate_condition(pair, population, condition, count, seed=seed)
    values, grain, audit = simulate_alone(pair, population, condition, count, seed=seed)
    kinds = np.column_stack([together.shape, together.aspect])
    np.testing.assert_array_equal(kinds, grain)
    columns = together.state, together.energy[:, 1], together.collisions
    np.testing.assert_array_equal(np.column_stack(columns), values[:, :8])
    np.testing.assert_array_equal(together.work, values[:, 8:10] / values[:, 11:])
    np.testing.assert_array_equal(together.inertia, values[:, 10])
    assert np.all(audit <= ALLOWED), audit
    return together


@pytest.mark.parametrize(("spin", "inertia"), [(SPINS[0], 0.0), (SPINS[1], 0.0), (SPINS[1], 0.3)])
@pytest.mark.parametrize("alpha_deg", [0.05, 0.5, 20.0, 90.0])
def test_a_crowd_of_all_shapes_and_meshes(alpha_deg, spin, inertia):
    condition = make_condition(np.radians(alpha_deg), 200.0, spin, inertia=inertia)
    simulation = same(PAIR, CROWD, condition, 2000)
    assert len(np.unique(simulation.shape)) == 7


@pytest.mark.parametrize("count", [1, WIDTH - 1, WIDTH, WIDTH + 1, 5 * WIDTH + 3])
def test_few_particles(count):
    same(PAIR, CROWD, make_condition(0.6, 150.0), count)


def test_particles_in_lanes_are_prepared_as_one_alone():
    condition = make_condition(0.5, 200.0, SPINS[1], inertia=0.3)
    rows, together = prepared_rows(CROWD, condition, 1001, 2**63 + 5)
    rows.spin[::2] = 0.0
    shapes = shapes_of(CROWD)
    prepare_particles(shapes, rows, together)
    for i in range(len(together)):
        one = [array[i : i + 1] for array in rows[:-1]]
        alone = np.empty((1, together.shape[1]))
        prepare_particles(shapes, type(rows)(*one, rows.seed), alone)
        np.testing.assert_array_equal(alone[0], together[i])
