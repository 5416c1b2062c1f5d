"""Exact symmetries: mirror at the impact plane, rotation about the wall normal at 90 degrees."""

import numpy as np
import pytest
from motion_fixtures import (
    NON_SPHERICAL,
    body_of,
    random_aspect,
    random_rotations,
    run_rebound,
    with_vertices,
)
from scipy.spatial.transform import Rotation

from tablegen.simulation.simulate import make_condition

#: Shapes that are their own mirror images.
ACHIRAL = ("ellipsoid", "prism", "truncated-prism")

#: Mirror at the impact plane, and its effect on a state: spin is an axial vector.
MIRROR = np.diag([1.0, 1.0, -1.0])
MIRRORED_STATE = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])

#: Collisions up to which rounding has not yet grown past the tolerance of a comparison.
FEW = 5


def compare(rotations, name, run, transformed, expected_of):
    """Compare rebounds pathwise where both take the same few collisions; return their number."""
    compared = 0
    for rotation in rotations:
        one, other = run(rotation), transformed(rotation)
        if max(one.collisions, other.collisions) <= FEW:
            assert one.collisions == other.collisions, name
            np.testing.assert_allclose(other.state, expected_of(one.state), rtol=0.0, atol=1e-9)
            compared += 1
    return compared


@pytest.mark.parametrize("alpha_deg", [5.0, 20.0, 45.0, 80.0])
@pytest.mark.parametrize("name", NON_SPHERICAL)
def test_mirrored_orientation_gives_the_mirrored_rebound(name, alpha_deg):
    rng = np.random.default_rng(61)
    body = body_of(name, *random_aspect(rng))
    # mirroring space and body is a rotation of a body that is its own mirror image
    image = body if name in ACHIRAL else with_vertices(body, body.candidates @ MIRROR)
    condition = make_condition(np.radians(alpha_deg), 200.0)
    compared = compare(
        random_rotations(rng, 200),
        name,
        lambda rotation: run_rebound(condition, body, rotation),
        lambda rotation: run_rebound(condition, image, MIRROR @ rotation @ MIRROR),
        lambda state: MIRRORED_STATE * state,
    )
    assert compared > 50


def test_tetrahedron_is_not_its_own_mirror_image():
    # the pathwise comparison tells a body from its mirror image
    rng = np.random.default_rng(63)
    body = body_of("tetrahedron", 0.8, 0.6)
    condition = make_condition(np.radians(20.0), 200.0)
    differences = [
        MIRRORED_STATE * run_rebound(condition, body, rotation).state
        - run_rebound(condition, body, MIRROR @ rotation @ MIRROR).state
        for rotation in random_rotations(rng, 20)
    ]
    assert np.abs(differences).max() > 0.1


@pytest.mark.parametrize("turn_deg", [37.0, 90.0, 180.0])
@pytest.mark.parametrize("name", NON_SPHERICAL)
def test_at_normal_impact_the_rebound_turns_with_the_particle(name, turn_deg):
    rng = np.random.default_rng(64)
    body = body_of(name, *random_aspect(rng))
    condition = make_condition(np.pi / 2, 200.0)
    turn = Rotation.from_euler("y", turn_deg, degrees=True).as_matrix()
    compared = compare(
        random_rotations(rng, 200),
        name,
        lambda rotation: run_rebound(condition, body, rotation),
        lambda rotation: run_rebound(condition, body, turn @ rotation),
        lambda state: np.concatenate([turn @ state[:3], turn @ state[3:]]),
    )
    assert compared > 40
