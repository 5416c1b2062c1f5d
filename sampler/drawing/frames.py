"""Between the lab frame and the frame of the impact.

The wall frame has y along the wall normal into the gas, x along the tangential part of the
velocity relative to the wall, and z = x cross y. At exactly normal impact there is no
tangential part and the law is symmetric about y, so the direction of x is drawn uniformly; a spin
before the impact is seen from there.
"""

import math

import numpy as np
from numpy.typing import NDArray

from sampler.compilation.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.argument_types import check_omega, output_of
from sampler.drawing.batch import (
    draw_states,
    fill_words,
    local_conditions,
    local_states,
    local_words,
)
from sampler.drawing.block import BLOCK, item
from sampler.drawing.condition_status import status_of
from sampler.drawing.kernel import draw
from sampler.drawing.philox import philox_block, uniform
from sampler.drawing.row_counts import NO_ROWS, counted, extrapolates
from sampler.drawing.spin_draw import spin_status
from sampler.drawing.spin_view import spin_law_of
from sampler.drawing.vectors import Vector, combine, cross, dot, is_finite, unit, vector
from sampler.errors import (
    HALF_SIZE_NOT_POSITIVE,
    NORMAL_NOT_USABLE,
    NOT_FINITE,
    OK,
    SPEED_NOT_POSITIVE,
)
from sampler.formats.bounds import TableArrays

#: Tangential over total speed below which an impact counts as normal: the direction of what is
#: left is rounding noise.
NORMAL_IMPACT = 1e-12

#: Least half-size [m]: below, the spin of a fast particle leaves the range of numbers.
LEAST_HALF_SIZE = 1e-30

#: Least speed [m/s] relative to the wall: below, the square of a component is no number any more.
LEAST_SPEED = 1e-150

#: Block of the keys' random words that gives the azimuth at normal impact.
AZIMUTH_BLOCK = 2

check_out = output_of("out")


@inline_kernel
def perpendicular(e_y: Vector, azimuth: float) -> Vector:
    """Return a unit vector perpendicular to the unit vector e_y, at an angle (rad) about it.

    Azimuth 0 lies in the plane of e_y and the coordinate axis furthest from it.
    """
    x, y, z = abs(e_y[0]), abs(e_y[1]), abs(e_y[2])
    if x <= y and x <= z:
        axis = (1.0, 0.0, 0.0)
    elif y <= z:
        axis = (0.0, 1.0, 0.0)
    else:
        axis = (0.0, 0.0, 1.0)
    zero = unit(combine(1.0, axis, -dot(axis, e_y), e_y))
    return combine(math.cos(azimuth), zero, math.sin(azimuth), cross(e_y, zero))


@inline_kernel
def along_wall(relative: Vector, e_y: Vector) -> Vector:
    """Return the unit vector e_x along the tangential part of a velocity that has one.

    The projection is done twice: near normal impact the first one loses digits, and e_x must be
    perpendicular to e_y to rounding.
    """
    e_x = unit(combine(1.0, relative, -dot(relative, e_y), e_y))
    return unit(combine(1.0, e_x, -dot(e_x, e_y), e_y))


@inline_kernel
def impact_status(velocity: Vector, normal: Vector, half_size: float, wall_velocity: Vector) -> int:
    """Negative code for numbers from which no impact can be made, else `OK`."""
    finite = is_finite(velocity) and is_finite(wall_velocity)
    if not (finite and is_finite(normal) and math.isfinite(half_size)):
        return NOT_FINITE
    if normal[0] == 0.0 and normal[1] == 0.0 and normal[2] == 0.0:
        return NORMAL_NOT_USABLE
    if half_size < LEAST_HALF_SIZE:
        return HALF_SIZE_NOT_POSITIVE
    return OK


@inline_kernel
def impact_angle(relative: Vector, e_y: Vector) -> tuple[float, float]:
    """Impact angle from the wall (rad; not positive if receding) and its tangential speed."""
    approach = -dot(relative, e_y)
    along = combine(1.0, relative, approach, e_y)
    tangential = math.sqrt(dot(along, along))
    return math.atan2(approach, tangential), tangential


@inline_kernel
def impact(
    velocity: Vector, normal: Vector, half_size: float, wall_velocity: Vector
) -> tuple[int, float, float]:
    """Condition of an impact: status, angle (rad) and speed (m/s)."""
    status = impact_status(velocity, normal, half_size, wall_velocity)
    relative = combine(1.0, velocity, -1.0, wall_velocity)
    speed = math.sqrt(dot(relative, relative))
    if status == OK and speed < LEAST_SPEED:
        status = SPEED_NOT_POSITIVE
    if status != OK:
        return status, 0.0, 0.0
    return status, impact_angle(relative, unit(normal))[0], speed


@inline_kernel
def tangent(relative: Vector, e_y: Vector, seed: int, index: int, hit: int) -> Vector:
    """Return the unit vector e_x along the tangential velocity.

    At normal impact, where there is none, its azimuth is drawn, uniform in [0, 2 pi).
    """
    along = combine(1.0, relative, -dot(relative, e_y), e_y)
    if math.sqrt(dot(along, along)) > NORMAL_IMPACT * math.sqrt(dot(relative, relative)):
        return along_wall(relative, e_y)
    word = philox_block(seed, index, hit, AZIMUTH_BLOCK)[0]
    return perpendicular(e_y, 2.0 * math.pi * uniform(word))


@no_refcount_inline_kernel
def to_lab(
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Vector,
    seed: int,
    index: int,
    hit: int,
    out: NDArray[np.float64],
) -> None:
    """Replace a state by velocity (m/s) and angular velocity (rad/s) in the lab frame, in place."""
    relative = combine(1.0, velocity, -1.0, wall_velocity)
    speed = math.sqrt(dot(relative, relative))
    e_y = unit(normal)
    e_x = tangent(relative, e_y, seed, index, hit)
    e_z = cross(e_x, e_y)
    for part in range(2):
        scale = speed if part == 0 else speed / half_size
        plane = combine(out[3 * part], e_x, out[3 * part + 1], e_y)
        turned = combine(scale, plane, scale * out[3 * part + 2], e_z)
        for axis in range(3):
            out[3 * part + axis] = turned[axis]
    for axis in range(3):
        out[axis] += wall_velocity[axis]


@no_refcount_inline_kernel
def spin_of(
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Vector,
    omega: Vector,
    seed: int,
    index: int,
    hit: int,
) -> Vector:
    """Return the spin times a/V in the frame of the wall, of an angular velocity (rad/s)."""
    relative = combine(1.0, velocity, -1.0, wall_velocity)
    e_y = unit(normal)
    e_x = tangent(relative, e_y, seed, index, hit)
    scale = half_size / math.sqrt(dot(relative, relative))
    e_z = cross(e_x, e_y)
    return scale * dot(omega, e_x), scale * dot(omega, e_y), scale * dot(omega, e_z)


@no_refcount_inline_kernel
def spinning_impact(
    arrays: TableArrays,
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Vector,
    omega: Vector,
    seed: int,
    index: int,
    hit: int,
) -> tuple[int, float, float, Vector]:
    """Condition of an impact with a spin: status, angle (rad), speed (m/s), spin times a/V."""
    spin = (0.0, 0.0, 0.0)
    status, alpha1, speed = impact(velocity, normal, half_size, wall_velocity)
    if status == OK and not is_finite(omega):
        status = NOT_FINITE
    if status == OK:
        spin = spin_of(velocity, normal, half_size, wall_velocity, omega, seed, index, hit)
        status = spin_status(spin_law_of(arrays), alpha1, speed, spin[0], spin[1], spin[2])
    return status, alpha1, speed, spin


@no_refcount_kernel
def rebound(
    arrays: TableArrays,
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Vector,
    seed: int,
    index: int,
    hit: int,
    out: NDArray[np.float64],
    omega: Vector | None = None,
    grain: Vector | None = None,
) -> int:
    """Rebound of one particle in the lab frame; callable from the user's own compiled code.

    Parameters
    ----------
    arrays : TableArrays
    velocity, wall_velocity : tuple of three float
        Velocities of the particle and of the wall at the contact, m/s, lab frame.
    normal : tuple of three float
        From the wall into the gas, any length but zero.
    half_size : float
        Largest half-size a of the particle, 1e-30 m or more.
    seed, index, hit : int
        Keys of the random numbers, as for `sampler.draw`.
    out : float64 array, shape (6,), written
        Velocity in m/s, then angular velocity in rad/s, lab frame.
    omega : tuple of three float, optional
        Angular velocity before the impact, rad/s, lab frame: then the rebound is drawn from the
        spin law, also where it is zero. None: from the law of particles without spin.
    grain : tuple of three float, optional
        As for `sampler.draw`.

    Returns
    -------
    int
        As `sampler.draw`; also `NORMAL_NOT_USABLE` (-4) and `HALF_SIZE_NOT_POSITIVE` (-5).

    Raises
    ------
    ValueError
        If `out` has fewer than six numbers. Wrong types are refused as by `sampler.draw`.
    """
    check_out(out)
    if out.size < 6:
        raise ValueError("out: got fewer than 6 numbers, allowed: shape (6,)")
    if omega is None:
        status, alpha1, speed = impact(velocity, normal, half_size, wall_velocity)
        if status == OK:
            status = draw(arrays, alpha1, speed, seed, index, hit, out, None, grain)
    else:
        check_omega(omega)
        whole = (arrays, velocity, normal, half_size, wall_velocity, omega, seed, index, hit)
        status, alpha1, speed, spin = spinning_impact(*whole)
        if status >= OK:
            status = draw(arrays, alpha1, speed, seed, index, hit, out, spin, grain)
    if status >= OK:
        to_lab(velocity, normal, half_size, wall_velocity, seed, index, hit, out)
    return status


@no_refcount_kernel
def rebound_batch(
    arrays: TableArrays,
    velocity: NDArray[np.float64],
    normal: NDArray[np.float64],
    half_size: NDArray[np.float64],
    wall_velocity: NDArray[np.float64],
    seed: int,
    index: NDArray[np.uint64],
    hit: NDArray[np.uint32],
    results: NDArray[np.float64],
    start: int,
    stop: int,
) -> tuple[int, int, int, int, int]:
    """Rebounds of the rows from start to stop; ends with the block of the first error.

    Arrays have n rows or one; `results` has shape (n, 6): velocity and angular velocity.
    Returns the same five numbers as `sampler.drawing.batch.draw_batch`.
    """
    words, drawn = local_words(), local_states()
    angles, velocities = local_conditions(), local_conditions()
    counts = NO_ROWS
    for first in range(start, stop, BLOCK):
        count = min(BLOCK, stop - first)
        for r in range(BLOCK):
            # a block that is not full repeats its last draw
            k = first + min(r, count - 1)
            given = (vector(velocity, k), vector(normal, k), item(half_size, k))
            status, alpha1, speed = impact(*given, vector(wall_velocity, k))
            status = status_of(arrays, alpha1, speed) if status == OK else status
            if status < OK:
                return k, status, *counts
            if r < count:
                counts = counted(counts, k, status, extrapolates(arrays, speed))
            angles[np.uint64(r)], velocities[np.uint64(r)] = alpha1, speed
        fill_words(len(arrays.channels), seed, index, hit, first, count, words)
        draw_states(arrays, words, angles, velocities, drawn)
        for r in range(count):
            k = first + r
            for variable in range(6):
                results[k, variable] = drawn[np.uint64(variable * BLOCK + r)]
            given = (vector(velocity, k), vector(normal, k), item(half_size, k))
            keys = (seed, item(index, k), item(hit, k))
            to_lab(*given, vector(wall_velocity, k), *keys, results[k])
    return -1, OK, *counts
