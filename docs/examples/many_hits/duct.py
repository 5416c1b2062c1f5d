"""A duct with a bend of 90 degrees, and the gas in it.

The bend is about the z axis, between two cylinders. The gas comes along +x above it, turns
clockwise and leaves along -y; before and behind the bend the duct is straight. Its velocity is the
same all over a straight part, and in the bend that of a free vortex of the same flow rate: it has
no vorticity anywhere but where the parts meet.

A point's `foot` in the first quadrant makes all parts one: the distance of the foot from the axis
is the place across the duct, and its direction the outward one.
"""

import math
from typing import NamedTuple

import numpy as np

from many_hits.models import FloatArray


class Bend(NamedTuple):
    """Radii of both walls, and lengths of the straight parts before and behind, m."""

    inner: float
    outer: float
    before: float
    behind: float

    @property
    def width(self) -> float:
        """Distance of the walls."""
        return self.outer - self.inner

    @property
    def middle(self) -> float:
        """Radius of the duct's middle line."""
        return 0.5 * (self.inner + self.outer)

    @property
    def length(self) -> float:
        """Length of the duct's middle line."""
        return self.before + 0.5 * math.pi * self.middle + self.behind


def foot(x: FloatArray) -> FloatArray:
    """Foot of points (2, n) in the first quadrant."""
    return np.maximum(x, 0.0)


def across(x: FloatArray) -> FloatArray:
    """Place across the duct, from the inner radius to the outer one, m."""
    fx, fy = foot(x)
    return np.sqrt(fx * fx + fy * fy)


def outward(x: FloatArray) -> FloatArray:
    """Direction from the inner wall to the outer one, (2, n)."""
    return foot(x) / across(x)


def along(bend: Bend, x: FloatArray) -> FloatArray:
    """Place along the duct's middle line, m, from the start of the bend."""
    fx, fy = foot(x)
    return np.minimum(x[0], 0.0) + bend.middle * np.arctan2(fx, fy) - np.minimum(x[1], 0.0)


def gas_velocity(bend: Bend, speed: float, x: FloatArray) -> FloatArray:
    """Velocity of the gas at points (2, n), for a speed in the straight parts."""
    fx, fy = foot(x)
    r2 = fx * fx + fy * fy
    r = np.sqrt(r2)
    vortex = bend.width / math.log(bend.outer / bend.inner) / r
    size = speed * np.where((x[0] > 0.0) & (x[1] > 0.0), vortex, 1.0) / r
    return np.stack((size * fy, -size * fx))


def gap(bend: Bend, x: FloatArray) -> FloatArray:
    """Distance from the nearer wall, negative behind it."""
    r = across(x)
    return np.minimum(bend.outer - r, r - bend.inner)


def onto_wall(bend: Bend, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Nearest points on a wall, moved into the gas by rounding, and wall normals there, (2, n)."""
    r, direction = across(x), outward(x)
    outer = r > bend.middle
    target = np.where(outer, bend.outer * (1.0 - 1e-12), bend.inner * (1.0 + 1e-12))
    return x + (target - r) * direction, np.where(outer, -direction, direction)
