"""Exact symmetries: mirror at the impact plane, rotation about the wall normal at 90 degrees."""

import numpy as np
import pytest
from motion_fixtures import (
    ACHIRAL,
    NON_SPHERICAL,
    body_of,
    random_aspect,
    random_rotations,
    run_rebound,
    with_vertices,
)
from scipy.spatial.transform import Rotation
from scipy.stats import norm

from tablegen.simulation.simulate import make_condition

#: Mirror at the impact plane, and what it does to a state: spin is an axial vector.
MIRROR = np.diag([1.0, 1.0, -1.0])
MIRRORED_STATE = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])

#: Collisions up to which rounding has not yet grown past the tolerance of a comparison.
FEW = 5

#: Columns of a state.
U, V, W, OMEGA_X, OMEGA_Y, OMEGA_Z = range(6)

#: False-alarm rate of one test of symmetry, over all its z-scores; there are 13 such tests.
FALSE_ALARM = 1e-6


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


def mirror_asymmetry(state):
    """Largest z-score of twelve means that vanish if (w, omega_x, omega_y) may change sign."""
    odd = state[:, [W, OMEGA_X, OMEGA_Y]]
    even = state[:, [U, V, OMEGA_Z]] - state[:, [U, V, OMEGA_Z]].mean(axis=0)
    parts = [odd] + [odd * even[:, [i]] for i in range(3)]
    values = np.hstack(parts)
    return np.abs(values.mean(axis=0) / values.std(axis=0) * np.sqrt(len(values))).max()


def limit(scores):
    """Largest of some z-scores that is passed with probability `FALSE_ALARM`, at most."""
    return norm.isf(0.5 * FALSE_ALARM / scores)


@pytest.mark.parametrize("alpha_deg", [10.0, 45.0, 75.0, 90.0])
@pytest.mark.parametrize("name", ACHIRAL)
def test_statistics_of_achiral_shapes_are_mirror_symmetric(name, alpha_deg, simulated):
    state = simulated(name, alpha_deg, 40_000, seed=65).state
    assert mirror_asymmetry(state) < limit(12)


def test_asymmetric_samples_are_rejected(simulated):
    state = simulated("prism", 45.0, 40_000, seed=65).state
    # one particle in twenty leaves on the wrong side
    skewed = state.copy()
    skewed[::20, W] = np.abs(skewed[::20, W])
    # each of w, omega_x, omega_y stays symmetric, but u depends on the side
    sided = state.copy()
    sided[:, U] += 0.01 * np.sign(sided[:, W])
    assert min(mirror_asymmetry(skewed), mirror_asymmetry(sided)) > limit(12)


@pytest.mark.parametrize("name", NON_SPHERICAL)
def test_at_normal_impact_u_and_omega_z_are_symmetric_too(name, simulated):
    # the half turn about the normal changes the sign of all four
    odd = simulated(name, 90.0, 40_000, seed=65).state[:, [U, W, OMEGA_X, OMEGA_Z]]
    scores = odd.mean(axis=0) / odd.std(axis=0) * np.sqrt(len(odd))
    assert np.abs(scores).max() < limit(4)


def test_away_from_normal_impact_u_is_not_symmetric(simulated):
    u = simulated("prism", 75.0, 40_000, seed=65).state[:, U]
    assert u.mean() / u.std() * np.sqrt(len(u)) > limit(4)


def test_the_box_tetrahedron_is_chiral(simulated):
    # With a > b > c its symmetry group holds half turns only, no reflection, so a population of
    # one handedness need not be mirror symmetric, and is not: mean omega_x is -0.003 at 20 degrees.
    omega_x = simulated("tetrahedron", 20.0, 400_000, seed=66).state[:, OMEGA_X]
    assert omega_x.mean() < -5.0 * omega_x.std() / np.sqrt(len(omega_x))
    assert omega_x.mean() == pytest.approx(-0.003, abs=0.002)
