"""Conditions of many impacts, in the frame of the wall or in the lab frame, checked row by row.

Arguments are arrays with a row for each particle, or with one for all. A bad row is reported by its
number and a code of `sampler.errors`, or `TURNS_TOO_OFTEN` or `OUT_OF_BOUNDS`.
"""

import math

from sampler.compilation.jit import inline_kernel, no_refcount_kernel
from sampler.drawing.block import item
from sampler.drawing.frames import impact_status, tangent, to_lab
from sampler.drawing.vectors import combine, cross, dot, is_finite, unit, vector
from sampler.errors import NOT_APPROACHING, NOT_FINITE, OK, SPEED_NOT_POSITIVE
from tablegen.model.bounds import ALPHA_DEG, MOST_TURNED, SPEED, SPIN
from tablegen.model.conditions import angle_turned, impact_condition, put_condition
from tablegen.model.correctly_rounded import cosine_and_sine

#: Status code: a particle turns by more than `MOST_TURNED` before its first contact.
TURNS_TOO_OFTEN = -101

#: Status code: an angle, a speed or a component of a spin outside of `tablegen.model.bounds`.
OUT_OF_BOUNDS = -102

#: Rounding by which an impact angle may exceed pi / 2.
_ROUNDING = 1e-15

#: Bounds as plain numbers, which kernels take; of the angle, as its sine in the lab frame has it.
_LEAST_SINE = math.sin(math.radians(ALPHA_DEG.low)) * (1.0 - 1e-9)
_LEAST_SPEED, _MOST_SPEED, _MOST_SPIN = SPEED.low, SPEED.high, SPIN.high


@inline_kernel
def _checked(speed, cosine, sine, spin, numerics):
    """Status of an impact whose numbers are finite, and its condition."""
    x, y, z = spin
    status = OK
    # in this form neither NaN nor infinity passes
    known = sine >= _LEAST_SINE and _LEAST_SPEED <= speed <= _MOST_SPEED
    if not (known and max(abs(x), abs(y), abs(z)) <= _MOST_SPIN):
        status = OUT_OF_BOUNDS
    elif not angle_turned(sine, spin) <= MOST_TURNED:
        status = TURNS_TOO_OFTEN
    return status, impact_condition(cosine, sine, speed, spin, numerics)


@inline_kernel
def wall_condition(alpha1, speed, spin, numerics):
    """Status of an impact in the frame of the wall, and its condition.

    Parameters
    ----------
    alpha1, speed : float
        Impact angle [rad] and speed [m/s].
    spin : tuple of three floats
        Angular velocity before the impact times a / V.
    numerics : tuple of two floats
        Resolution of contacts and tolerance of flights.
    """
    status = OK
    if not (math.isfinite(alpha1) and math.isfinite(speed) and is_finite(spin)):
        status = NOT_FINITE
    elif not 0.0 < alpha1 <= 0.5 * math.pi * (1.0 + _ROUNDING):
        status = NOT_APPROACHING
    elif speed <= 0.0:
        status = SPEED_NOT_POSITIVE
    if status != OK:
        return status, impact_condition(0.0, 1.0, 1.0, (0.0, 0.0, 0.0), numerics)
    cosine, sine = cosine_and_sine(min(alpha1, 0.5 * math.pi))
    return _checked(speed, cosine, sine, spin, numerics)


@inline_kernel
def lab_condition(velocity, normal, half_size, wall_velocity, omega, keys, numerics):
    """Status of an impact in the lab frame, and its condition.

    Parameters
    ----------
    velocity, wall_velocity : tuple of three floats
        m/s.
    normal : tuple of three floats
        Into the gas, of any length but zero.
    half_size : float
        m.
    omega : tuple of three floats
        Angular velocity before the impact, rad/s.
    keys : tuple of three int
        Seed, index and hit: they choose the wall axis x at normal impact.
    numerics : tuple of two floats
    """
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
    e_x = tangent(relative, e_y, *keys)
    scale = half_size / speed
    spin = (
        scale * dot(omega, e_x),
        scale * dot(omega, e_y),
        scale * dot(omega, cross(e_x, e_y)),
    )
    sine = min(approach / speed, 1.0)
    return _checked(speed, math.sqrt(dot(along, along)) / speed, sine, spin, numerics)


@no_refcount_kernel
def wall_conditions(alpha1, speed, spin, numerics, keys, values, start):
    """Conditions of impacts in the frame of the wall.

    Parameters
    ----------
    alpha1, speed : (n,) or (1,) float64
    spin : (n, 3) or (1, 3) float64
    numerics : tuple of two floats
    keys : ParticleKeys
        Not needed here.
    values : (m, 8) float64
        Output: those of the rows from ``start`` on.
    start : int

    Returns
    -------
    tuple of two int
        First bad row, or -1; its code.
    """
    for k in range(values.shape[0]):
        row = start + k
        status, condition = wall_condition(
            item(alpha1, row), item(speed, row), vector(spin, row), numerics
        )
        if status != OK:
            return row, status
        put_condition(condition, values, k)
    return -1, OK


@no_refcount_kernel
def lab_conditions(
    velocity, normal, half_size, wall_velocity, omega, numerics, keys, values, start
):
    """Conditions of impacts in the lab frame, from arrays; results as of `wall_conditions`."""
    for k in range(values.shape[0]):
        row = start + k
        status, condition = lab_condition(
            vector(velocity, row),
            vector(normal, row),
            item(half_size, row),
            vector(wall_velocity, row),
            vector(omega, row),
            (keys.seed, item(keys.particle, row), item(keys.hit, row)),
            numerics,
        )
        if status != OK:
            return row, status
        put_condition(condition, values, k)
    return -1, OK


@no_refcount_kernel
def states_to_lab(velocity, normal, half_size, wall_velocity, keys, states, start):
    """Replace the states of the rows from ``start`` on by velocities and angular velocities."""
    for k in range(states.shape[0]):
        row = start + k
        to_lab(
            vector(velocity, row),
            vector(normal, row),
            item(half_size, row),
            vector(wall_velocity, row),
            keys.seed,
            item(keys.particle, row),
            item(keys.hit, row),
            states[k],
        )
