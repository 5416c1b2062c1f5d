"""The condition of an impact, as a rebound takes it.

Units: the speed in m/s, spins in V / a. Angles and speeds are given by the cosine and the sine of
the impact angle and by V. A condition holds floats, or lanes made of the conditions of eight
particles; in an array it has `CONDITION_SIZE` numbers.
"""

import math
from typing import NamedTuple

from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel
from tablegen.model.simd import load

#: Numbers of a condition, and the place of `Condition.instant` among them.
CONDITION_SIZE, INSTANT = 9, 8

#: Sine of the impact angle, half a degree, below which the resolution of contacts shrinks with it.
GRAZING = 0.0087

#: Angle [rad] turned in a flight above which its tolerance shrinks with it.
MANY_TURNS = 10.0


class Condition(NamedTuple):
    """Impact condition and numerical parameters of a rebound.

    ``cosine`` and ``sine`` are those of the impact angle, so the velocity before the impact is
    (cosine, -sine, 0). ``speed`` is V [m/s]. ``spin`` is the mean angular velocity before the
    impact in wall axes, times a / V. ``resolution`` is the smallest rebound speed of a contact
    point over V, ``tolerance`` the truncation of the flight series. ``instant`` is 0 if the angular
    velocity after the impact is the mean over free tumbling, and 1 if it is that of the departure.
    """

    cosine: float
    sine: float
    speed: float
    spin: tuple[float, float, float]
    resolution: float
    tolerance: float
    instant: float


@inline_kernel
def angle_turned(sine, spin):
    """Bound the angle [rad] by which a particle turns before its first contact."""
    # a fall of the centre by 2 a, at the speed V sin(alpha1)
    return math.sqrt(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]) * 2.0 / sine


@inline_kernel
def impact_condition(cosine, sine, speed, spin, numerics):
    """Make the condition of an impact.

    ``numerics`` are the resolution of contacts, the tolerance of flights, and whether the angular
    velocity after the impact is that of the departure. At grazing impact the resolution is smaller,
    and after many turns before the first contact the tolerance is.
    """
    resolution = numerics[0] * min(1.0, sine / GRAZING)
    tolerance = numerics[1] / max(1.0, angle_turned(sine, spin) / MANY_TURNS)
    return Condition(cosine, sine, speed, spin, resolution, tolerance, numerics[2])


@inline_kernel
def translates(condition):
    """Tell whether particles arrive without spin."""
    x, y, z = condition.spin
    return (x == 0.0) & (y == 0.0) & (z == 0.0)


@no_refcount_inline_kernel
def condition_of(values):
    """Make a condition of its numbers: for one particle (9,), for lanes (9, WIDTH)."""
    spin = load(values, 3), load(values, 4), load(values, 5)
    cosine, sine, speed = load(values, 0), load(values, 1), load(values, 2)
    return Condition(cosine, sine, speed, spin, load(values, 6), load(values, 7), load(values, 8))


@no_refcount_inline_kernel
def store_condition(condition, values, slot):
    """Write a condition to a column of an array (9, WIDTH)."""
    values[0, slot], values[1, slot] = condition.cosine, condition.sine
    values[2, slot] = condition.speed
    for k in range(3):
        values[3 + k, slot] = condition.spin[k]
    values[6, slot], values[7, slot] = condition.resolution, condition.tolerance
    values[8, slot] = condition.instant
