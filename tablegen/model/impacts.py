"""Conditions of impacts: one as a record, many as rows of an array, checked row by row.

A row has ten numbers, the fields of `Condition` in their order, the spin as three; so the
conditions of WIDTH particles are ten lanes (see `tablegen.model.simd`), and the kernels of a
rebound take a record of floats or of lanes.

Impacts are given in the frame of the wall or in the lab frame, by arrays with a row for each
particle or one row for all. A bad row is reported by its number and a code of `sampler.errors`, or
`TURNS_TOO_OFTEN` or `OUT_OF_BOUNDS`.
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

    ``cosine`` and ``sine`` of the impact angle, which are the velocity before the impact,
    ``speed`` [m/s], ``spin``: mean angular velocity before the impact in wall axes times a / V,
    ``resolution``: smallest rebound speed of a contact point over V, ``tolerance``: truncation of
    the flight series, ``instant``: 0 if the angular velocity after the impact is the mean over free
    tumbling, 1 if it is that of the departure, ``inertia``: that about the spin over m a^2, 0 if it
    is not known.
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
    """Angle [rad] that a particle turns at most before its first contact."""
    # from its greatest height to its least, turning all the way
    return math.sqrt(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]) * 2.0 / sine


@inline_kernel
def impact_condition(cosine, sine, speed, spin, inertia, numerics):
    """Condition of an impact, with numerical parameters that shrink at grazing and with many turns.

    ``numerics``: resolution of contacts, tolerance of flights, and whether the angular velocity
    after the impact is that of the departure.
    """
    resolution = numerics[0] * min(1.0, sine / GRAZING)
    tolerance = numerics[1] / max(1.0, angle_turned(sine, spin) / MANY_TURNS)
    return Condition(cosine, sine, speed, spin, resolution, tolerance, numerics[2], inertia)


@inline_kernel
def translates(condition):
    """Whether particles arrive without spin."""
    x, y, z = condition.spin
    return (x == 0.0) & (y == 0.0) & (z == 0.0)


@no_refcount_inline_kernel
def condition_of(values):
    """Condition from its ten numbers: of one particle, (10,), or of lanes, (10, WIDTH)."""
    spin = load(values, 3), load(values, 4), load(values, 5)
    cosine, sine, speed = load(values, 0), load(values, 1), load(values, 2)
    numerics = load(values, 6), load(values, 7), load(values, 8)
    return Condition(cosine, sine, speed, spin, *numerics, load(values, 9))


@no_refcount_inline_kernel
def put_condition(condition, values, row):
    """Write a condition to a row of an array."""
    values[row, 0], values[row, 1] = condition.cosine, condition.sine
    values[row, 2] = condition.speed
    for k in range(3):
        values[row, 3 + k] = condition.spin[k]
    values[row, 6], values[row, 7] = condition.resolution, condition.tolerance
    values[row, 8], values[row, 9] = condition.instant, condition.inertia


def one_row(condition: Condition) -> NDArray[np.float64]:
    """Array (1, 10) of a condition that all particles have."""
    values = np.empty((1, CONDITION_SIZE))
    put_condition(condition, values, 0)
    return values


#: Status code: a particle turns by more than `MOST_TURNED` before its first contact.
TURNS_TOO_OFTEN = -101

#: Status code: an angle, a speed or a component of a spin outside of `tablegen.model.model_bounds`.
OUT_OF_BOUNDS = -104

#: Largest impact angle, pi / 2 and a rounding.
_STEEPEST = 0.5 * math.pi * (1.0 + 1e-15)

#: Bounds as plain numbers, which kernels take; of the angle, as its sine in the lab frame has it.
_LEAST_SINE = math.sin(math.radians(ALPHA_DEG.low)) * (1.0 - 1e-9)
_LEAST_SPEED, _MOST_SPEED, _MOST_SPIN = SPEED.low, SPEED.high, SPIN.high


@inline_kernel
def _checked(speed, cosine, sine, spin, inertia, numerics):
    """Status of an impact whose numbers are finite, and its condition."""
    x, y, z = spin
    status = OK
    # in this form neither NaN nor infinity passes
    if not (sine >= _LEAST_SINE and _LEAST_SPEED <= speed <= _MOST_SPEED):
        status = OUT_OF_BOUNDS
    elif not angle_turned(sine, spin) <= MOST_TURNED:
        status = TURNS_TOO_OFTEN
    elif not max(abs(x), abs(y), abs(z)) <= _MOST_SPIN:
        status = OUT_OF_BOUNDS
    return status, impact_condition(cosine, sine, speed, spin, inertia, numerics)


@inline_kernel
def _wall_condition(alpha1, cosine_sine, speed, spin, inertia, numerics):
    """Status of an impact in the frame of the wall, and its condition.

    ``alpha1`` in rad, ``cosine_sine`` of this angle if it is allowed, ``speed`` in m/s, ``spin``
    times a / V, ``inertia`` over m a^2.
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
    return _checked(speed, cosine_sine[0], cosine_sine[1], spin, inertia, numerics)


@inline_kernel
def _is_inertia(inertia):
    """Whether a number can be the inertia about a spin, or is 0 for one that is not known."""
    return 0.0 <= inertia < math.inf


@inline_kernel
def _allowed_angle(alpha1):
    """Return the nearest angle that an impact may have."""
    return min(max(alpha1, 0.0), 0.5 * math.pi)


@inline_kernel
def _lab_condition(impact, omega, inertia, keys, numerics):
    """Status of an impact in the lab frame, and its condition.

    ``impact``: velocity of the particle [m/s], normal into the gas, of any length but zero,
    half-size [m], velocity of the wall [m/s]; ``omega`` in rad/s,
    ``inertia`` over m a^2. The keys choose the wall axis x at normal impact.
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
    return _checked(speed, cosine, sine, spin, inertia, numerics)


@kernel
def wall_conditions(alpha1, speed, spin, inertia, numerics, values):
    """Conditions of impacts in the frame of the wall: first bad row, or -1, and its code.

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
            put_condition(condition, values, row)
    return -1, OK


@no_refcount_inline_kernel
def _impact(impacts, row):
    """Velocity, normal, half-size and velocity of the wall in a row."""
    velocity, normal, half_size, wall_velocity = impacts
    moving = vector(velocity, row), vector(normal, row), item(half_size, row)
    return *moving, vector(wall_velocity, row)


@no_refcount_kernel
def lab_conditions(impacts, omega, inertia, keys, numerics, values):
    """Conditions of impacts in the lab frame; the results are those of `wall_conditions`.

    ``impacts``: velocity, normal, half-size and velocity of the wall, of n rows or one, as is
    ``omega``, (n, 3) or (1, 3), and ``inertia``, (n,) or (1,); ``keys``: seed, and index and hit of
    n rows or one.
    """
    for row in range(values.shape[0]):
        turning = vector(omega, row), item(inertia, row)
        given = _impact(impacts, row), *turning, keys_of_row(keys, row)
        status, condition = _lab_condition(*given, numerics)
        if status != OK:
            return row, status
        put_condition(condition, values, row)
    return -1, OK


@no_refcount_kernel
def states_to_lab(impacts, keys, states):
    """Replace states (n, 6) by velocities and angular velocities in the lab frame."""
    for row in range(states.shape[0]):
        to_lab(_impact(impacts, row), keys_of_row(keys, row), states[row])
