"""Rebounds in the lab frame of particles that arrive spinning.

As `sampler.drawing.frames`, with the angular velocity before the impact turned into the frame of
the wall. At exactly normal impact the direction of x along the wall is drawn, and the spin is seen
from there: the law is the same from every side.
"""

import math

import numpy as np
from numpy.typing import NDArray

from sampler.compilation.jit import no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.block import BLOCK, item
from sampler.drawing.frames import impact, tangent, to_lab
from sampler.drawing.spin_draw import (
    draw_spinning,
    fill_grains,
    fill_words,
    local_reals,
    local_states,
    local_vectors,
    local_words,
    spin_status,
)
from sampler.drawing.vectors import Vector, combine, cross, dot, is_finite, unit, vector
from sampler.errors import CLAMPED, NOT_FINITE, OK
from sampler.formats.table_arrays import TableArrays


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
        status = spin_status(arrays.spin, alpha1, speed, spin[0], spin[1], spin[2])
    return status, alpha1, speed, spin


@no_refcount_kernel
def spin_rebound_batch(
    arrays: TableArrays,
    velocity: NDArray[np.float64],
    normal: NDArray[np.float64],
    half_size: NDArray[np.float64],
    wall_velocity: NDArray[np.float64],
    omega: NDArray[np.float64],
    given: NDArray[np.float64],
    grain_hit: NDArray[np.uint32],
    seed: int,
    index: NDArray[np.uint64],
    hit: NDArray[np.uint32],
    results: NDArray[np.float64],
    start: int,
    stop: int,
) -> tuple[int, int, int, int, int]:
    """Rebounds of the rows from start to stop; ends with the block of the first error.

    Arrays have n rows or one; `omega`, (n, 3) or (1, 3), is in rad/s before the impact, and
    `given` and `grain_hit` are as of `sampler.drawing.spin_draw.spin_draw_batch`. `results` has
    shape (n, 6): velocity and angular velocity. Returns the same five numbers.
    """
    words, drawn = local_words(), local_states()
    angles, speeds, spins, grains = local_reals(), local_reals(), local_vectors(), local_vectors()
    low, high = arrays.valid_speed
    first_clamped, clamped, extrapolated = -1, 0, 0
    for first in range(start, stop, BLOCK):
        count = min(BLOCK, stop - first)
        for n in range(BLOCK):
            # a block that is not full repeats its last draw
            k, r = first + min(n, count - 1), np.uint64(n)
            one = (vector(velocity, k), vector(normal, k), item(half_size, k))
            keys = (seed, item(index, k), item(hit, k))
            status, angles[r], speeds[r], spin = spinning_impact(
                arrays, *one, vector(wall_velocity, k), vector(omega, k), *keys
            )
            if status < OK:
                return k, status, first_clamped, clamped, extrapolated
            spins[3 * n], spins[3 * n + 1], spins[3 * n + 2] = spin
            if n < count:
                extrapolated += 0 if low <= speeds[r] <= high else 1
                if status == CLAMPED:
                    clamped += 1
                    first_clamped = k if first_clamped < 0 else first_clamped
        fill_words(6, seed, index, hit, first, count, words)
        fill_grains(arrays.spin.grains, given, seed, index, grain_hit, first, count, grains)
        draw_spinning(arrays, words, angles, speeds, spins, grains, drawn)
        for n in range(count):
            k = first + n
            for variable in range(6):
                results[k, variable] = drawn[np.uint64(6 * n + variable)]
            one = (vector(velocity, k), vector(normal, k), item(half_size, k))
            keys = (seed, item(index, k), item(hit, k))
            to_lab(*one, vector(wall_velocity, k), *keys, results[k])
    return -1, OK, first_clamped, clamped, extrapolated
