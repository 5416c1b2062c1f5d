"""Contacts: none is missed, and the right point of the body touches."""

import numpy as np
import pytest
from free_rotation import FreeRotation
from motion_fixtures import NON_SPHERICAL, body_of, motion_of, random_aspect, random_rotations
from one_particle import fly_to_contact
from scipy.optimize import brentq

from tablegen.model.contact import _fall_bound, contact_point
from tablegen.model.rebound import CLEARANCE, HEIGHT, V
from tablegen.model.rotation import ORDER
from tablegen.model.shapes import support_depth

#: Instants at which the dense search looks, a radian of turning.
DENSITY = 200


class FreeFlight:
    """Flight of a body by the independent integrator: gap to the wall at any time."""

    def __init__(self, body, motion, duration):
        self._body, self._y, self._v = body, motion[HEIGHT], motion[V]
        self._rotation = FreeRotation(body.moments, motion, duration)

    def gap(self, times):
        """Height of the lowest point at (m,) times."""
        normal = self._rotation.rotation(times)[:, 1]
        if len(self._body.candidates) == 0:
            sizes = np.array(self._body.half)
            depth = np.linalg.norm(normal * sizes, axis=1)
        else:
            depth = -(normal @ self._body.candidates.T).min(axis=1)
        return self._y + self._v * np.asarray(times) - depth

    def first_contact(self, times):
        """First time at which the lowest point comes down to the wall, or None."""
        gaps = self.gap(times)
        down = np.flatnonzero((gaps[:-1] > 0.0) & (gaps[1:] <= 0.0))
        if len(down) == 0:
            return None
        low, high = times[down[0]], times[down[0] + 1]
        return brentq(lambda t: self.gap([t])[0], low, high, xtol=1e-14)


def random_spin(rng, rate):
    spin = rng.normal(size=3)
    return rate * spin / np.linalg.norm(spin)


def falling_flight(rng, name, rate):
    """Body, and its motion from just over the wall, falling or slowly rising."""
    body = body_of(name, *random_aspect(rng, 0.1))
    velocity = [0.3, rng.uniform(-1.0, 0.4), 0.0]
    motion = motion_of(random_rotations(rng, 1)[0], random_spin(rng, rate), velocity)
    motion[HEIGHT] = support_depth(body, *motion[3:6]) + 10.0 ** rng.uniform(-6.0, 0.0)
    return body, motion


def launched_flight(rng, name, rate):
    """Make a body just after a collision; its contact point rises with a velocity of 1e-3 to 1."""
    body = body_of(name, *random_aspect(rng, 0.1))
    rotation, spin = random_rotations(rng, 1)[0], random_spin(rng, rate)
    motion, point = motion_of(rotation, spin, [0.3, -1e3, 0.0]), np.empty(3)
    motion[HEIGHT] = support_depth(body, *motion[3:6])
    contact_point(body, motion, motion[HEIGHT], motion[V], point)
    motion[V] = 10.0 ** rng.uniform(-3.0, 0.0) - np.cross(spin, rotation @ point)[1]
    return body, motion


def duration_of(body, motion):
    """Return a time within which the body touches the wall or has left it."""
    v, y = motion[V], motion[HEIGHT]
    top = body.bounding_radius + CLEARANCE
    return (top - y) / v if v > 0.0 else (y + body.bounding_radius) / -v


def touches_like_dense_search(body, motion, duration):
    """Follow a motion to its next contact, compare with the dense search; whether it touches."""
    flight = FreeFlight(body, motion, duration)
    rate = np.linalg.norm(motion[0:3])
    times = np.linspace(0.0, duration, int(DENSITY * (1.0 + duration * rate)))
    expected = flight.first_contact(times)
    before = motion.copy()
    top = body.bounding_radius + CLEARANCE
    touches = fly_to_contact(body, top, 1e-12, motion, np.empty((9, ORDER + 1)))
    if not touches:
        assert expected is None
        assert motion[V] > 0.0
        assert motion[HEIGHT] == top
        return False
    t = (motion[HEIGHT] - before[HEIGHT]) / before[V]
    assert expected is None or t <= expected + 1e-8
    # the contact of the kernel is one, even where the dense search saw none
    assert abs(flight.gap([t])[0]) < 1e-9
    assert flight.gap([t - 1e-6])[0] > flight.gap([t])[0]
    if expected is None or t < expected - 1e-8:
        assert flight.gap(times[times < t]).min(initial=np.inf) > -1e-9
    return True


@pytest.mark.parametrize("make_flight", [falling_flight, launched_flight])
@pytest.mark.parametrize("rate", [0.5, 5.0, 40.0])
@pytest.mark.parametrize("name", NON_SPHERICAL)
def test_no_contact_is_jumped_over(name, rate, make_flight):
    rng = np.random.default_rng(int(10 * rate))
    touched = compared = 0
    while compared < 6:
        body, motion = make_flight(rng, name, rate)
        duration = duration_of(body, motion)
        if 0.0 < duration * rate < 60.0:
            touched += touches_like_dense_search(body, motion, duration)
            compared += 1
    assert touched >= 1


@pytest.mark.parametrize("t", [0.3, 1.0, 3.0])
def test_no_vertex_falls_faster_than_its_bound(t):
    """With a constant spin the height of a vertex is a sinusoid. Here spin and distance are 1.

    A bound without the growth of p . n is too small for 0.2 % of these vertices at t = 0.3, and
    for 2 % at t = 1, by up to 0.013.
    """
    rows = np.random.default_rng(12).normal(size=(3, 20_000, 3))
    spin, normal, vertex = rows / np.linalg.norm(rows, axis=2)[..., None]
    along = np.sum(vertex * spin, axis=1) * np.sum(normal * spin, axis=1)
    height = np.sum(vertex * normal, axis=1)
    cosine, sine = height - along, np.sum(vertex * np.cross(normal, spin), axis=1)
    fallen = cosine * (1.0 - np.cos(t)) + sine * (t - np.sin(t))
    constant, share = _fall_bound(1.0, (1.0, 0.0), 0.0, t)
    assert (fallen <= 0.5 * t * t * (constant + share * height)).all()


def lands(body, motion):
    """Contact point of a motion at the height of its first contact, and its gap."""
    point = np.empty(3)
    motion[HEIGHT] = support_depth(body, *motion[3:6])
    return point, contact_point(body, motion, motion[HEIGHT], motion[V], point)


def turned(*rows):
    """Orientation whose wall normal, in body axes, is along ``rows``."""
    n = np.array(rows, dtype=float)
    n /= np.linalg.norm(n)
    x = np.cross(n, [0.3, -0.5, 0.81])
    x /= np.linalg.norm(x)
    return np.array([x, n, np.cross(x, n)])


ASKEW = np.array([0.3, -0.7, 0.5])


@pytest.mark.parametrize(
    "normal",
    [*np.eye(3), *-np.eye(3), *(ASKEW * (1.0 - np.eye(3))), ASKEW],
    ids=[*("face",) * 6, *("edge",) * 3, "corner"],
)
def test_prism_lands_on_the_centre_of_its_face_or_edge_or_on_a_corner(normal):
    body = body_of("prism", 0.8, 0.6)
    point, gap = lands(body, motion_of(turned(*normal), velocity=[0.0, -1.0, 0.0]))
    np.testing.assert_allclose(point, -np.sign(normal) * [1.0, 0.8, 0.6], atol=1e-15)
    assert abs(gap) < 1e-15


@pytest.mark.parametrize(("tilt", "x"), [(1e-10, 0.0), (1e-7, -1.0)])
def test_a_face_lands_flat_within_the_tie_height_only(tilt, x):
    body = body_of("prism", 0.8, 0.6)
    point, _ = lands(body, motion_of(turned(tilt, 0.0, 1.0), velocity=[0.0, -1.0, 0.0]))
    np.testing.assert_allclose(point, [x, 0.0, -0.6], atol=1e-15)


def test_a_falling_corner_is_preferred_to_a_rising_one():
    # flat on its third face and turning about the second body axis: one edge falls, one rises
    body = body_of("prism", 0.8, 0.6)
    motion = motion_of(turned(0.0, 0.0, 1.0))
    motion[0:3] = [0.0, 1.0, 0.0]
    point, _ = lands(body, motion)
    # rate of p along the normal: (W x p)_3 = -p_1
    np.testing.assert_allclose(point, [1.0, 0.0, -0.6], atol=1e-15)


@pytest.mark.parametrize(("b", "c"), [(1.0, 1.0), (0.8, 0.6), (0.5, 0.02)])
def test_contact_point_of_ellipsoids_is_the_tangent_point(b, c):
    body = body_of("ellipsoid", b, c)
    sizes = np.array([1.0, b, c])
    for rotation in random_rotations(np.random.default_rng(33), 100):
        point, gap = lands(body, motion_of(rotation, velocity=[0.0, -1.0, 0.0]))
        assert np.sum((point / sizes) ** 2) == pytest.approx(1.0, rel=1e-13)
        # the surface normal there points into the wall
        outward = point / sizes**2
        np.testing.assert_allclose(outward / np.linalg.norm(outward), -rotation[1], atol=1e-13)
        assert abs(gap) <= 1e-15
