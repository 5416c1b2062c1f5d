"""Rebounds of meshes are those of known shapes, whatever the pose and units."""

import math

import numpy as np
import pytest
from mesh_fixtures import (
    KNOWN,
    POPULATION,
    icosphere,
    known_body,
    population_of,
    posed,
    rebounds,
    tetrahedron,
)
from motion_fixtures import random_rotations, run_rebound
from scipy.spatial.transform import Rotation

from tablegen.meshes.particle import mesh_particle
from tablegen.simulation.simulate import make_condition


def body_of(points):
    """Body of a mesh, and the principal axes that it is given in."""
    particle = mesh_particle(points)
    return particle.body(), particle.axes


def agree(first, second, alpha_deg, count=300):
    """Return whether rebounds agree one by one, except for rounding in a few long chains.

    Both are given as (body, axes): the orientation is that of the common axes in which each
    body's own ones are given by rows.
    """
    condition, differences = make_condition(np.radians(alpha_deg), 200.0), []
    for rotation in random_rotations(np.random.default_rng(71), count):
        one, two = (
            run_rebound(condition, body, rotation @ axes.T) for body, axes in (first, second)
        )
        other = one.collisions != two.collisions
        differences.append(np.abs(one.state - two.state).max() + other)
    return np.quantile(differences, 0.9) < 1e-8 and np.mean(np.array(differences) > 1e-6) < 0.02


@pytest.mark.parametrize("shape", KNOWN)
def test_known_shapes(shape):
    known = known_body(shape, 0.8, 0.64)
    mesh = body_of(posed(KNOWN[shape](0.8, 0.64), seed=5, scale=1e-4))
    turn = Rotation.random(rng=np.random.default_rng(5)).as_matrix()
    # the known shape's axes, in those of the file, are the columns of the turn
    assert agree(mesh, (known, turn.T), 20.0)


def test_the_mirrored_tetrahedron_is_told_apart():
    known = known_body("tetrahedron", 0.8, 0.64)
    mirrored = tetrahedron(0.8, 0.64) * [1.0, 1.0, -1.0]
    assert agree(body_of(tetrahedron(0.8, 0.64)), (known, np.eye(3)), 45.0)
    assert not agree(body_of(mirrored), (known, np.eye(3)), 45.0)


def test_a_fine_mesh_approaches_the_ellipsoid():
    # paired particles: number i has the same orientation in both populations
    smooth = POPULATION.restricted_to("ellipsoid").with_aspect(0.8, 0.75)
    expected = rebounds(smooth, 2000, seed=72).state
    for sizes, is_same in (((1.0, 0.8, 0.6), True), ((1.0, 0.6, 0.4), False)):
        states = rebounds(population_of(icosphere(4, sizes)), 2000, seed=72).state
        assert (np.median(np.abs(states - expected)) < 0.03) == is_same
        # five standard errors of independent samples: a false alarm in 10^6 even without pairing
        allowed = 5.0 * expected.std(axis=0) * math.sqrt(2.0 / 2000.0)
        assert np.all(np.abs(states.mean(axis=0) - expected.mean(axis=0)) < allowed) == is_same
