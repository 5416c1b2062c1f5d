"""Rebounds of meshes are those of known shapes, whatever the pose and units, and keep every law."""

import math

import numpy as np
import pytest
from mesh_fixtures import (
    KNOWN,
    PAIR,
    POPULATION,
    cylinder,
    grain,
    icosphere,
    known_body,
    population_of,
    posed,
    rebounds,
    tetrahedron,
)
from scipy.spatial.transform import Rotation

from tablegen.config.mesh import mesh_particle
from tablegen.model.audit import (
    ANGULAR,
    AUDIT_SIZE,
    ENERGY,
    FLIGHT_ENERGY,
    FLIGHT_MOMENTUM,
    NORMAL,
    PENETRATION,
    TANGENTIAL,
)
from tablegen.model.jit import kernel
from tablegen.model.rebound import LEFT, MOTION_SIZE, approach, rebound, wall_spin, workspace
from tablegen.simulation.simulate import make_condition

# called from Python here
wall_spin = kernel(wall_spin)
workspace = kernel(workspace)

LAW = PAIR.kernel_arguments()

ALLOWED = np.zeros(AUDIT_SIZE)
ALLOWED[[ENERGY, ANGULAR, NORMAL, TANGENTIAL]] = 1e-12
ALLOWED[PENETRATION] = 1e-11
ALLOWED[[FLIGHT_ENERGY, FLIGHT_MOMENTUM]] = 1e-9


def body_of(points):
    """Body of a mesh, and the principal axes that it is given in."""
    particle = mesh_particle(points)
    return particle.body(), particle.axes


def rebound_of(body, rotation, alpha_deg):
    """State and number of collisions of a body with an orientation (wall from body axes)."""
    condition = make_condition(np.radians(alpha_deg), 200.0)
    motion = np.empty(MOTION_SIZE)
    motion[3:6], motion[6:9] = rotation[1], rotation[0]
    approach(condition, body, motion)
    status, collisions, _ = rebound(LAW, condition, body, motion, workspace(), np.empty(0))
    assert status == LEFT
    spin = wall_spin(body.moments, condition.instant, motion)
    return np.array([*motion[9:12], *spin]), collisions


def agree(first, second, alpha_deg, count=300):
    """Whether rebounds agree one by one; rounding may show in few, the longest, chains.

    Both are given as (body, axes): the orientation is that of the common axes in which each
    body's own ones are given by rows.
    """
    differences = []
    for rotation in Rotation.random(count, rng=np.random.default_rng(71)).as_matrix():
        one, n_one = rebound_of(first[0], rotation @ first[1].T, alpha_deg)
        two, n_two = rebound_of(second[0], rotation @ second[1].T, alpha_deg)
        differences.append(np.abs(one - two).max() + (n_one != n_two))
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
        made = rebounds(population_of(icosphere(4, sizes)), 2000, seed=72).state
        assert (np.median(np.abs(made - expected)) < 0.03) == is_same
        # five standard errors of independent samples: a false alarm in 10^6 even without pairing
        allowed = 5.0 * expected.std(axis=0) * math.sqrt(2.0 / 2000.0)
        assert np.all(np.abs(made.mean(axis=0) - expected.mean(axis=0)) < allowed) == is_same


@pytest.mark.parametrize(
    ("points", "alpha_deg", "spin"),
    [
        (grain(1000), 0.01, (0, 0, 0)),
        (grain(1000), 30, (1, -2, 3)),
        (cylinder(60, 0.02), 60, (0, 0, 0)),
        (grain(300, 4, (1.0, 0.03, 0.02)), 90, (0, 0, 0)),
    ],
    ids=["grazing", "spinning", "disc", "needle"],
)
def test_every_collision_and_flight_keeps_its_laws(points, alpha_deg, spin):
    made = rebounds(population_of(points), 2000, alpha_deg, spin=spin, seed=73, audited=True)
    assert np.all(made.audit <= ALLOWED), made.audit
    assert np.isfinite(made.state).all()
    assert np.all(made.state[:, 1] > 0.0)
    assert np.all(made.energy.sum(axis=1) <= 1.0 + 1e-12)
