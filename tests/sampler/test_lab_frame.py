"""Lab frame and wall frame: geometry, moving walls, and the azimuth at normal impact."""

import math

import numpy as np
import pytest
from impacts import impacts
from reference_draw import key_words

pytestmark = pytest.mark.processor


def _lab(velocity, normal, half_size, state):
    """Lab-frame velocity and angular velocity of states, by numpy and independent formulae."""
    speed = np.linalg.norm(velocity, axis=1, keepdims=True)
    e_y = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    tangential = velocity - np.einsum("nk,nk->n", velocity, e_y)[:, None] * e_y
    e_x = tangential / np.linalg.norm(tangential, axis=1, keepdims=True)
    basis = np.stack((e_x, e_y, np.cross(e_x, e_y)), axis=1)
    v, omega = (np.einsum("np,npc->nc", part, basis) for part in (state[:, :3], state[:, 3:]))
    return v * speed, omega * speed / half_size


def test_rebound_is_the_state_in_the_lab_frame(table):
    velocity, normal = impacts(2000)
    speed = np.linalg.norm(velocity, axis=1)
    keys, fall = {"seed": 1, "index": range(2000), "hit": 4}, -(velocity * normal).sum(axis=1)
    alpha1 = np.arcsin(fall / speed / np.linalg.norm(normal, axis=1))
    state = table.sample(alpha1, speed, **keys)
    expected = _lab(velocity, normal, 2e-5, state)
    v, omega, _ = table.rebound(velocity, normal, 2e-5, grain="fresh", **keys)
    scale = speed[:, None]
    np.testing.assert_allclose(v / scale, expected[0] / scale, rtol=0, atol=1e-11)
    np.testing.assert_allclose(omega * 2e-5 / scale, expected[1] * 2e-5 / scale, rtol=0, atol=1e-10)
    # Away from the wall, with no more translational energy than before.
    assert (np.einsum("nk,nk->n", v, normal) > 0.0).all()
    assert (np.linalg.norm(v, axis=1) <= speed).all()


@pytest.mark.parametrize(("roughness", "rounding"), [(None, 1e-9), (0.1, 1e-8)])
def test_galilean_invariance(table, roughness, rounding):
    """A wall and a particle that move along together rebound as at rest."""
    velocity, normal = impacts(1000)
    wall = np.random.default_rng(9).standard_normal((1000, 3)) * 300.0
    keys = {"grain": "fresh", "seed": 2, "index": range(1000), "roughness": roughness}
    v, omega, _ = table.rebound(velocity, normal, 1e-5, **keys)
    moving = table.rebound(velocity + wall, normal, 1e-5, wall_velocity=wall, **keys)
    scale = np.linalg.norm(velocity, axis=1, keepdims=True)
    # Adding 300 m/s and taking it away loses some digits.
    assert (np.abs(moving[0] - wall - v) / scale).max() < rounding
    assert np.abs((moving[1] - omega) * 1e-5 / scale).max() < rounding
    # The check sees a wall velocity that is not taken back.
    assert np.abs(moving[0] - v).max() > 100.0


def test_length_of_the_normal_is_idle(table):
    velocity, normal = impacts(100)
    keys = {"grain": "fresh", "seed": 5, "index": range(100)}
    expected = table.rebound(velocity, normal, 1e-5, **keys)
    for factor in (1e-300, 1e-30, 1e30, 1e300):
        scaled = table.rebound(velocity, normal * factor, 1e-5, **keys)
        np.testing.assert_allclose(scaled[0], expected[0], rtol=0, atol=1e-9)


def _azimuths(table, normal, n):
    """Azimuth of e_x in [0, 1) turns, found from the rebounds at normal impact.

    Azimuth 0 is in the plane of e_y and the coordinate axis furthest from it.
    """
    e_y = np.asarray(normal) / np.linalg.norm(normal)
    keys = {"seed": 4, "index": np.arange(n)}
    state = table.sample(math.pi / 2, 150.0, **keys)
    v = table.rebound(-150.0 * e_y, normal, 1e-5, grain="fresh", **keys).velocity
    axis = np.eye(3)[np.argmin(np.abs(e_y))]
    zero = axis - (axis @ e_y) * e_y
    zero /= np.linalg.norm(zero)
    lab = np.arctan2(v @ np.cross(e_y, zero), v @ zero)
    # e_z = e_x cross e_y lies a quarter turn before e_x: w counts backwards.
    wall = np.arctan2(-state[:, 2], state[:, 0])
    np.testing.assert_allclose(v @ e_y, 150.0 * state[:, 1], rtol=1e-10)
    return np.mod((lab - wall) / (2.0 * math.pi), 1.0)


@pytest.mark.parametrize("normal", [[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 2.0, -0.5]])
def test_azimuth_takes_the_ninth_word(table, normal):
    """The first word after the eight of the draw: uniform, and independent of the state."""
    words = [key_words(4, k, 0, n_blocks=3)[8] for k in range(100)]
    expected = (np.array(words) + 0.5) / 2.0**32
    difference = _azimuths(table, normal, 100) - expected
    assert np.abs(difference - np.round(difference)).max() < 1e-10


def test_threshold_of_normal_impact(table):
    """Just above it the tangential direction counts, just below it does not."""
    keys = {"grain": "fresh", "seed": 4, "index": np.arange(50)}
    normal = [0.0, 1.0, 0.0]
    along = table.rebound([2e-12 * 100.0, -100.0, 0.0], normal, 1e-5, **keys)[0]
    against = table.rebound([-2e-12 * 100.0, -100.0, 0.0], normal, 1e-5, **keys)[0]
    np.testing.assert_allclose(along[:, [0, 2]], -against[:, [0, 2]], atol=1e-8)
    below = table.rebound([0.5e-12 * 100.0, -100.0, 0.0], normal, 1e-5, **keys)[0]
    exactly = table.rebound([0.0, -100.0, 0.0], normal, 1e-5, **keys)[0]
    np.testing.assert_allclose(below, exactly, atol=1e-8)


def test_the_smallest_and_fastest_that_are_taken_have_finite_spins(table):
    for v, half_size in ((1e-150, 1e-9), (1e149, 1e-9), (1e149, 0.1)):
        keys = {"grain": "fresh", "seed": 1, "index": 2, "hit": 3}
        velocity, omega, _ = table.rebound((v, -v, 0.0), (0.0, 1.0, 0.0), half_size, **keys)
        assert np.isfinite([*velocity, *omega]).all()
        assert velocity[1] > 0.0
