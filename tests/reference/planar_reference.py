"""Rebounds in the impact plane by other means: a rectangle or an ellipse that turns about z.

A body one of whose principal axes is along z, without spin about the others, stays in the impact
plane: its edges along z strike as a whole, and between collisions it turns uniformly. So a rebound
needs two coordinates, sines and cosines. Contacts are looked for on a dense grid of instants, the
scalar equation of a collision is bracketed and solved by bisection and secants; nothing is shared
with `tablegen.model`.

Units as there: lengths in a, velocities in V, mass one. Equation numbers are those of Panfilov &
Tsirkunov 2022.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

#: Instants a radian at which a contact is looked for, and how many at a time.
DENSITY, CHUNK = 1000, 4000

#: Corners this close to the wall touch it: those of a face that lands flat.
TOUCHES = 1e-9


class Section(NamedTuple):
    """Cross-section: half-sizes along its two principal axes, moment about z, rectangle or not."""

    sizes: tuple[float, float]
    moment: float
    is_round: bool

    def corners(self, theta):
        """Corners in wall axes at the angles ``theta`` (m,), (m, 4, 2)."""
        p = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * self.sizes
        cos, sin = np.cos(theta)[:, np.newaxis], np.sin(theta)[:, np.newaxis]
        return np.stack([cos * p[:, 0] - sin * p[:, 1], sin * p[:, 0] + cos * p[:, 1]], axis=-1)

    def support(self, theta):
        """Depth of the lowest point below the centre at the angles ``theta`` (m,)."""
        if self.is_round:
            return np.hypot(self.sizes[0] * np.sin(theta), self.sizes[1] * np.cos(theta))
        return -self.corners(theta)[..., 1].min(axis=1)

    def lowest(self, theta):
        """Points that touch the wall on which the body lies, (n, 2)."""
        if not self.is_round:
            corners = self.corners(np.array([theta]))[0]
            return corners[corners[:, 1] <= corners[:, 1].min() + TOUCHES]
        p, q = self.sizes
        sin, cos = math.sin(theta), math.cos(theta)
        depth = math.hypot(p * sin, q * cos)
        return np.array([[-(p * p - q * q) * sin * cos / depth, -depth]])


class Motion(NamedTuple):
    """Angle, height of the centre, velocity of the centre, spin."""

    theta: float
    y: float
    u: float
    v: float
    omega: float


class Law(NamedTuple):
    """Restitution of (speed [m/s], cosine), resistance of (arm, velocity), floor over V, V."""

    restitution: Callable[[float, float], float]
    resistance: Callable[[np.ndarray, np.ndarray], float]
    resolution: float
    speed: float


def paper_law(speed, resolution=1e-3):
    """Corundum on steel: equations (6) and (7)."""
    return Law(
        lambda size, cosine: 1.0 - (1.0 - math.exp(-0.1 * size**0.61)) * cosine,
        lambda r, v: math.exp(np.dot(r, v) / (np.linalg.norm(r) * np.linalg.norm(v))),
        resolution,
        speed,
    )


# --- One collision ---


def mobility(section, r):
    """A_xx, A_xy, A_yy of a contact at ``r``."""
    j = section.moment
    return 1.0 + r[1] ** 2 / j, -r[0] * r[1] / j, 1.0 + r[0] ** 2 / j


def solve(matrix, u_c, k, jump):
    """Impulse (S_x, S_y) that changes the normal contact velocity by ``jump``, equations (5)."""
    a_xx, a_xy, a_yy = matrix

    def side(s):
        return -k * s * (u_c + 0.5 * a_xy * s) / (1.0 + 0.5 * k * s * a_xx)

    def balance(s):
        return a_yy * s + a_xy * side(s) - jump

    high = jump
    while balance(high) < 0.0:
        high *= 2.0
    s = brentq(balance, 0.0, high, xtol=1e-300, rtol=1e-15)
    return side(s), s


def collide(section, law, motion, r):
    """Motion after a collision at ``r``, from the centre in wall axes."""
    u_c, v_c = motion.u - motion.omega * r[1], motion.v + motion.omega * r[0]
    size = math.hypot(u_c, v_c)
    bounce = -v_c * law.restitution(law.speed * size, -v_c / size)
    k = law.resistance(r, np.array([motion.u, motion.v])) / size
    matrix = mobility(section, r)

    def kicked(jump):
        s_x, s_y = solve(matrix, u_c, k, jump)
        turn = (r[0] * s_y - r[1] * s_x) / section.moment
        return motion._replace(u=motion.u + s_x, v=motion.v + s_y, omega=motion.omega + turn)

    after = kicked(max(bounce, law.resolution) - v_c)
    if bounce < law.resolution and energy(section, after) > energy(section, motion):
        after = kicked(max(bounce, -v_c) - v_c)
    return after


def energy(section, motion):
    """Kinetic energy."""
    return 0.5 * (motion.u**2 + motion.v**2 + section.moment * motion.omega**2)


# --- Flight ---


def falling_points(section, motion):
    """Points that touch and approach the wall, (n, 2)."""
    points = section.lowest(motion.theta)
    return points[motion.v + motion.omega * points[:, 0] < 0.0]


def contact_time(section, motion):
    """Time of the next contact of a body that no longer approaches; None if it leaves."""
    v, omega = motion.v, motion.omega

    def gap(t):
        return motion.y + v * t - section.support(motion.theta + omega * np.atleast_1d(t))

    step = 1.0 / (DENSITY * abs(omega)) if omega != 0.0 else math.inf
    reach = math.hypot(*section.sizes)
    start = 0.0
    while v <= 0.0 or motion.y + v * start < reach:
        if math.isinf(step):
            return None if v >= 0.0 else float(gap(0.0)[0] / -v)
        times = start + step * np.arange(1, CHUNK + 1)
        below = np.flatnonzero(gap(times) < 0.0)
        if below.size:
            high = times[below[0]]
            # at the start itself the gap is zero where a contact has just been
            low = max(high - step, 1e-6 * step)
            return brentq(lambda t: gap(t)[0] / t, low, high, xtol=1e-15, rtol=1e-14)
        start = times[-1]
    return None


# --- Whole rebounds ---


def rebound(section, law, motion):
    """State (u, v, omega) and number of collisions; ``motion`` starts on or over the wall."""
    collisions = 0
    while True:
        falling = falling_points(section, motion)
        lies = motion.y - section.support(np.array([motion.theta]))[0] <= TOUCHES
        if not (lies and len(falling)):
            t = contact_time(section, motion)
            if t is None:
                return np.array([motion.u, motion.v, motion.omega]), collisions
            theta = motion.theta + motion.omega * t
            motion = motion._replace(theta=theta, y=section.support(np.array([theta]))[0])
            falling = falling_points(section, motion)
            if not len(falling):
                falling = section.lowest(theta)
        motion = collide(section, law, motion, falling.mean(axis=0))
        collisions += 1


def impact(section, theta, alpha, spin=0.0):
    """Motion at the first contact of a body that comes at the angle ``alpha``."""
    y = section.support(np.array([theta]))[0]
    return Motion(theta, float(y), math.cos(alpha), -math.sin(alpha), spin)


# --- The same body in space ---


def section_of(name, b, c, axis):
    """Section of an ellipsoid or prism with half-sizes (1, b, c) across its principal ``axis``."""
    sizes = (1.0, b, c)
    p, q = sizes[(axis + 1) % 3], sizes[(axis + 2) % 3]
    share = 0.2 if name == "ellipsoid" else 1.0 / 3.0
    return Section((p, q), share * (p * p + q * q), name == "ellipsoid")


def rotation_of_section(theta, axis):
    """Rotation, wall from body, that puts the section's first axis at ``theta`` from x."""
    rotation = np.zeros((3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rotation[0, i], rotation[0, j] = math.cos(theta), -math.sin(theta)
    rotation[1, i], rotation[1, j] = math.sin(theta), math.cos(theta)
    rotation[2, axis] = 1.0
    return rotation
