"""Conditions of impacts: checked, and written as kernels take them.

An impact is given in the frame of the wall (angle, speed, spin) or in the lab frame (velocities,
normal, half-size, angular velocity), by arrays with a row for each particle or one row for all. Its
condition is a row of ten numbers, the fields of `Condition` in their order, with three for the
spin. A rebound takes a `Condition` of floats, or of lanes made from eight rows.

A row that is not allowed is reported by its number and a code of `sampler.errors`, or
`TURNS_TOO_OFTEN` or `OUT_OF_BOUNDS`.

Units: angles in rad; lab frame in SI; in a condition the speed in m/s, the spin in V / a, the
inertia over m a^2.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.errors import NOT_APPROACHING, NOT_FINITE, OK, SPEED_NOT_POSITIVE
from tablegen.model.elementary import cosine_and_sine
from tablegen.model.frames import (
    combine,
    cross,
    dot,
    impact_status,
    is_finite,
    item,
    keys_of_row,
    tangent,
    to_lab,
    unit,
    vector,
)
from tablegen.model.jit import (
    inline_kernel,
    kernel,
    no_refcount_inline_kernel,
    no_refcount_kernel,
)
from tablegen.model.model_bounds import ALPHA_DEG, MOST_TURNED, SPEED, SPIN
from tablegen.model.simd import WIDTH, lane_array, load, store

#: Numbers of a condition.
CONDITION_SIZE = 10

#: Places of `Condition.instant` and `Condition.inertia` among them.
INSTANT, INERTIA = 8, 9

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
    ``inertia`` is that about the spin over m a^2, or 0 if it is not known.
    """

    cosine: float
    sine: float
    speed: float
    spin: tuple[float, float, float]
    resolution: float
    tolerance: float
    instant: float
    inertia: float


@inline_kernel
def angle_turned(sine, spin):
    """Bound the angle [rad] by which a particle turns before its first contact."""
    # a fall of the centre by 2 a, at the speed V sin(alpha1)
    return math.sqrt(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]) * 2.0 / sine


@inline_kernel
def impact_condition(cosine, sine, speed, spin, inertia, numerics):
    """Make the condition of an impact.

    ``numerics`` are the resolution of contacts, the tolerance of flights, and whether the angular
    velocity after the impact is that of the departure. At grazing impact the resolution is smaller,
    and after many turns before the first contact the tolerance is.
    """
    resolution = numerics[0] * min(1.0, sine / GRAZING)
    tolerance = numerics[1] / max(1.0, angle_turned(sine, spin) / MANY_TURNS)
    return Condition(cosine, sine, speed, spin, resolution, tolerance, numerics[2], inertia)


@inline_kernel
def translates(condition):
    """Tell whether particles arrive without spin."""
    x, y, z = condition.spin
    return (x == 0.0) & (y == 0.0) & (z == 0.0)


@no_refcount_inline_kernel
def condition_of(values):
    """Make a condition of its ten numbers: for one particle (10,), for lanes (10, WIDTH)."""
    spin = load(values, 3), load(values, 4), load(values, 5)
    cosine, sine, speed = load(values, 0), load(values, 1), load(values, 2)
    numerics = load(values, 6), load(values, 7), load(values, 8)
    return Condition(cosine, sine, speed, spin, *numerics, load(values, 9))


@no_refcount_inline_kernel
def store_condition(condition, values, row):
    """Write a condition to a row of an array."""
    values[row, 0], values[row, 1] = condition.cosine, condition.sine
    values[row, 2] = condition.speed
    for k in range(3):
        values[row, 3 + k] = condition.spin[k]
    values[row, 6], values[row, 7] = condition.resolution, condition.tolerance
    values[row, 8], values[row, 9] = condition.instant, condition.inertia


def condition_row(condition: Condition) -> NDArray[np.float64]:
    """Write a condition that all particles share to an array (1, 10)."""
    values = np.empty((1, CONDITION_SIZE))
    store_condition(condition, values, 0)
    return values


#: Status code: the particle turns by more than `MOST_TURNED` before its first contact.
TURNS_TOO_OFTEN = -101

#: Status code: an angle, a speed or a spin is outside of the bounds of `model_bounds`.
OUT_OF_BOUNDS = -104

#: Largest impact angle, pi / 2 and a rounding.
_STEEPEST = 0.5 * math.pi * (1.0 + 1e-15)

#: Bounds as plain numbers, because kernels take no `Bounds`. The angle is checked by its sine,
#: which is what an impact in the lab frame gives.
_LEAST_SINE = math.sin(math.radians(ALPHA_DEG.low)) * (1.0 - 1e-9)
_LEAST_SPEED, _MOST_SPEED, _MOST_SPIN = SPEED.low, SPEED.high, SPIN.high


@inline_kernel
def _checked_condition(speed, cosine, sine, spin, inertia, numerics):
    """Check an impact whose numbers are finite; return its status and its condition."""
    x, y, z = spin
    status = OK
    # a comparison with NaN is false, so neither NaN nor infinity passes
    if not (sine >= _LEAST_SINE and _LEAST_SPEED <= speed <= _MOST_SPEED):
        status = OUT_OF_BOUNDS
    elif not angle_turned(sine, spin) <= MOST_TURNED:
        status = TURNS_TOO_OFTEN
    elif not max(abs(x), abs(y), abs(z)) <= _MOST_SPIN:
        status = OUT_OF_BOUNDS
    return status, impact_condition(cosine, sine, speed, spin, inertia, numerics)


@inline_kernel
def _wall_condition(alpha1, cosine_sine, speed, spin, inertia, numerics):
    """Check an impact in the frame of the wall; return its status and its condition.

    ``alpha1`` is in rad, ``cosine_sine`` are those of this angle if it is allowed; ``speed`` is in
    m/s, ``spin`` in V / a, ``inertia`` over m a^2.
    """
    status = OK if _is_inertia(inertia) else NOT_FINITE
    if not (math.isfinite(alpha1) and math.isfinite(speed) and is_finite(spin)):
        status = NOT_FINITE
    elif status == OK and not 0.0 < alpha1 <= _STEEPEST:
        status = NOT_APPROACHING
    elif status == OK and speed <= 0.0:
        status = SPEED_NOT_POSITIVE
    if status != OK:
        return status, impact_condition(0.0, 1.0, 1.0, (0.0, 0.0, 0.0), 0.0, numerics)
    return _checked_condition(speed, cosine_sine[0], cosine_sine[1], spin, inertia, numerics)


@inline_kernel
def _is_inertia(inertia):
    """Tell whether a number can be an inertia about a spin; 0 stands for one that is not known."""
    return 0.0 <= inertia < math.inf


@inline_kernel
def _allowed_angle(alpha1):
    """Return the nearest angle that an impact may have."""
    return min(max(alpha1, 0.0), 0.5 * math.pi)


@inline_kernel
def _lab_condition(impact, omega, inertia, keys, numerics):
    """Check an impact in the lab frame; return its status and its condition.

    ``impact`` is the velocity of the particle [m/s], the normal into the gas, of any length but
    zero, the half-size [m] and the velocity of the wall [m/s]; ``omega`` is in rad/s, ``inertia``
    over m a^2. At normal impact the keys choose the wall axis x.
    """
    velocity, normal, half_size, wall_velocity = impact
    status = impact_status(velocity, normal, half_size, wall_velocity)
    relative = combine(1.0, velocity, -1.0, wall_velocity)
    speed = math.sqrt(dot(relative, relative))
    if status == OK and not (math.isfinite(speed) and is_finite(omega) and _is_inertia(inertia)):
        status = NOT_FINITE
    if status == OK and speed == 0.0:
        status = SPEED_NOT_POSITIVE
    if status == OK and not dot(relative, unit(normal)) < 0.0:
        status = NOT_APPROACHING
    if status != OK:
        return status, impact_condition(0.0, 1.0, 1.0, (0.0, 0.0, 0.0), 0.0, numerics)
    e_y = unit(normal)
    approach = -dot(relative, e_y)
    along = combine(1.0, relative, approach, e_y)
    e_x = tangent(relative, e_y, keys)
    scale = half_size / speed
    e_z = cross(e_x, e_y)
    spin = scale * dot(omega, e_x), scale * dot(omega, e_y), scale * dot(omega, e_z)
    sine = min(approach / speed, 1.0)
    cosine = math.sqrt(dot(along, along)) / speed
    return _checked_condition(speed, cosine, sine, spin, inertia, numerics)


@kernel
def wall_conditions(alpha1, speed, spin, inertia, numerics, values):
    """Write the conditions of impacts in the frame of the wall.

    Returns the first row that is not allowed, or -1, and its code.

    ``alpha1``, ``speed`` and ``inertia`` are (n,) or (1,), ``spin`` (n, 3) or (1, 3); ``values``
    (n, 10) gets the conditions.
    """
    lanes = lane_array(3)
    for first in range(0, values.shape[0], WIDTH):
        count = min(WIDTH, values.shape[0] - first)
        for i in range(WIDTH):
            lanes[0, i] = _allowed_angle(item(alpha1, first + min(i, count - 1)))
        cosine, sine = cosine_and_sine(load(lanes, 0))
        store(lanes, 1, cosine)
        store(lanes, 2, sine)
        for i in range(count):
            row = first + i
            given = item(alpha1, row), (lanes[1, i], lanes[2, i]), item(speed, row)
            turning = vector(spin, row), item(inertia, row)
            status, condition = _wall_condition(*given, *turning, numerics)
            if status != OK:
                return row, status
            store_condition(condition, values, row)
    return -1, OK


@no_refcount_inline_kernel
def _impact_of_row(impacts, row):
    """Read velocity, normal, half-size and velocity of the wall of a row."""
    velocity, normal, half_size, wall_velocity = impacts
    moving = vector(velocity, row), vector(normal, row), item(half_size, row)
    return *moving, vector(wall_velocity, row)


@no_refcount_kernel
def lab_conditions(impacts, omega, inertia, keys, numerics, values):
    """Write the conditions of impacts in the lab frame; results are those of `wall_conditions`.

    ``impacts`` are velocity, normal, half-size and velocity of the wall, ``omega`` is (n, 3) or
    (1, 3), ``inertia`` (n,) or (1,); ``keys`` are seed, index and hit. Each array has n rows or
    one.
    """
    for row in range(values.shape[0]):
        turning = vector(omega, row), item(inertia, row)
        given = _impact_of_row(impacts, row), *turning, keys_of_row(keys, row)
        status, condition = _lab_condition(*given, numerics)
        if status != OK:
            return row, status
        store_condition(condition, values, row)
    return -1, OK


@no_refcount_kernel
def states_to_lab(impacts, keys, states):
    """Replace states (n, 6) by velocities and angular velocities in the lab frame."""
    for row in range(states.shape[0]):
        to_lab(_impact_of_row(impacts, row), keys_of_row(keys, row), states[row])
