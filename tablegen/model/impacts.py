"""Conditions of many impacts, in the frame of the wall or in the lab frame, checked row by row.

Arguments are arrays with a row for each particle, or with one for all. A bad row is reported by its
number and a code of `sampler.errors`, or `TURNS_TOO_OFTEN` or `OUT_OF_BOUNDS`.
"""

import math

from sampler.errors import NOT_APPROACHING, NOT_FINITE, OK, SPEED_NOT_POSITIVE
from tablegen.model.correctly_rounded import cosine_and_sine
from tablegen.model.frames import (
    combine,
    cross,
    dot,
    impact_status,
    is_finite,
    item,
    tangent,
    to_lab,
    unit,
    vector,
)
from tablegen.model.impact_condition import angle_turned, impact_condition, put_condition
from tablegen.model.jit import (
    inline_kernel,
    kernel,
    no_refcount_inline_kernel,
    no_refcount_kernel,
)
from tablegen.model.model_bounds import ALPHA_DEG, MOST_TURNED, SPEED, SPIN
from tablegen.model.simd import WIDTH, lane_array, load, store

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
def _checked(speed, cosine, sine, spin, numerics):
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
    return status, impact_condition(cosine, sine, speed, spin, numerics)


@inline_kernel
def wall_condition(alpha1, cosine_sine, speed, spin, numerics):
    """Status of an impact in the frame of the wall, and its condition.

    Parameters
    ----------
    alpha1 : float
        Impact angle [rad].
    cosine_sine : tuple of two floats
        Of the angle, if it is allowed.
    speed : float
        m/s.
    spin : tuple of three floats
        Angular velocity before the impact times a / V.
    numerics : tuple of two floats
        Resolution of contacts and tolerance of flights.
    """
    status = OK
    if not (math.isfinite(alpha1) and math.isfinite(speed) and is_finite(spin)):
        status = NOT_FINITE
    elif not 0.0 < alpha1 <= _STEEPEST:
        status = NOT_APPROACHING
    elif speed <= 0.0:
        status = SPEED_NOT_POSITIVE
    if status != OK:
        return status, impact_condition(0.0, 1.0, 1.0, (0.0, 0.0, 0.0), numerics)
    return _checked(speed, cosine_sine[0], cosine_sine[1], spin, numerics)


@inline_kernel
def allowed_angle(alpha1):
    """Give the angle if an impact may have it, else the nearest that it may have."""
    return min(max(alpha1, 0.0), 0.5 * math.pi)


@inline_kernel
def lab_condition(impact, omega, keys, numerics):
    """Status of an impact in the lab frame, and its condition.

    Parameters
    ----------
    impact : tuple
        Velocity of the particle [m/s], normal into the gas, of any length but zero, half-size [m],
        velocity of the wall [m/s]; vectors are tuples.
    omega : tuple of three floats
        Angular velocity before the impact [rad/s].
    keys : tuple of three int
        Seed, index and hit: they choose the wall axis x at normal impact.
    numerics : tuple of two floats
        As of `wall_condition`.
    """
    velocity, normal, half_size, wall_velocity = impact
    status = impact_status(velocity, normal, half_size, wall_velocity)
    relative = combine(1.0, velocity, -1.0, wall_velocity)
    speed = math.sqrt(dot(relative, relative))
    if status == OK and not (math.isfinite(speed) and is_finite(omega)):
        status = NOT_FINITE
    if status == OK and speed == 0.0:
        status = SPEED_NOT_POSITIVE
    if status == OK and not dot(relative, unit(normal)) < 0.0:
        status = NOT_APPROACHING
    if status != OK:
        return status, impact_condition(0.0, 1.0, 1.0, (0.0, 0.0, 0.0), numerics)
    e_y = unit(normal)
    approach = -dot(relative, e_y)
    along = combine(1.0, relative, approach, e_y)
    e_x = tangent(relative, e_y, keys)
    scale = half_size / speed
    spin = (
        scale * dot(omega, e_x),
        scale * dot(omega, e_y),
        scale * dot(omega, cross(e_x, e_y)),
    )
    sine = min(approach / speed, 1.0)
    return _checked(speed, math.sqrt(dot(along, along)) / speed, sine, spin, numerics)


@kernel
def wall_conditions(alpha1, speed, spin, numerics, values, start):
    """Conditions of impacts in the frame of the wall.

    Parameters
    ----------
    alpha1, speed : (n,) or (1,) float64
    spin : (n, 3) or (1, 3) float64
    numerics : tuple of two floats
    values : (m, 8) float64
        Output: those of the rows from ``start`` on.
    start : int

    Returns
    -------
    tuple of two int
        First bad row, or -1; its code.
    """
    lanes = lane_array(3)
    for first in range(0, values.shape[0], WIDTH):
        count = min(WIDTH, values.shape[0] - first)
        for i in range(WIDTH):
            lanes[0, i] = allowed_angle(item(alpha1, start + first + min(i, count - 1)))
        cosine, sine = cosine_and_sine(load(lanes, 0))
        store(lanes, 1, cosine)
        store(lanes, 2, sine)
        for i in range(count):
            row = start + first + i
            given = item(alpha1, row), (lanes[1, i], lanes[2, i]), item(speed, row)
            status, condition = wall_condition(*given, vector(spin, row), numerics)
            if status != OK:
                return row, status
            put_condition(condition, values, first + i)
    return -1, OK


@no_refcount_inline_kernel
def _impact(impacts, row):
    """Velocity, normal, half-size and velocity of the wall in a row."""
    velocity, normal, half_size, wall_velocity = impacts
    return (
        vector(velocity, row),
        vector(normal, row),
        item(half_size, row),
        vector(wall_velocity, row),
    )


@no_refcount_kernel
def lab_conditions(impacts, omega, keys, numerics, values, start):
    """Conditions of impacts in the lab frame.

    Parameters
    ----------
    impacts : tuple of four float64 arrays
        Velocity, normal, half-size and velocity of the wall, of n rows or one.
    omega : (n, 3) or (1, 3) float64
    keys : tuple
        Seed; index and hit, of n rows or one.
    numerics, values, start
        As of `wall_conditions`, and so are the results.
    """
    seed, index, hit = keys
    for k in range(values.shape[0]):
        row = start + k
        one = seed, item(index, row), item(hit, row)
        status, condition = lab_condition(_impact(impacts, row), vector(omega, row), one, numerics)
        if status != OK:
            return row, status
        put_condition(condition, values, k)
    return -1, OK


@no_refcount_kernel
def states_to_lab(impacts, keys, states, start):
    """Replace the states of the rows from ``start`` on by velocities and angular velocities."""
    seed, index, hit = keys
    for k in range(states.shape[0]):
        row = start + k
        one = seed, item(index, row), item(hit, row)
        to_lab(_impact(impacts, row), one, states[k])
