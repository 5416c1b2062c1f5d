"""Rebounds of many particles from rough walls, in the lab frame."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.compilation.jit import no_refcount_kernel
from sampler.drawing.block import item
from sampler.drawing.kernel import grain_at
from sampler.drawing.roughness import rough_rebound
from sampler.drawing.row_counts import NO_ROWS, counted, extrapolates
from sampler.drawing.vectors import combine, dot, vector
from sampler.errors import OK
from sampler.formats.bounds import TableArrays

#: Spins and grains of `rough_rebound_batch` for particles that arrive without spin.
WITHOUT_SPIN = (None, None, None)


@no_refcount_kernel
def rough_rebound_batch(
    arrays: TableArrays,
    velocity: NDArray[np.float64],
    normal: NDArray[np.float64],
    half_size: NDArray[np.float64],
    wall_velocity: NDArray[np.float64],
    roughness: NDArray[np.float64],
    omega: Any,
    given: Any,
    grain_hit: Any,
    seed: int,
    index: NDArray[np.uint64],
    hit: NDArray[np.uint32],
    results: NDArray[np.float64],
    start: int,
    stop: int,
) -> tuple[int, int, int, int, int]:
    """Rebounds of the rows from start to stop; ends with the first error.

    Arrays have n rows or one. `omega`, `given` and `grain_hit` are as of
    `sampler.drawing.spin_frames.spin_rebound_batch`, or `WITHOUT_SPIN`; numba compiles one kernel
    for each. `results` has shape (n, 6): velocity and angular velocity. Returns the same five
    numbers as `sampler.drawing.batch.draw_batch`.
    """
    counts = NO_ROWS
    for k in range(start, stop):
        v, wall, out = vector(velocity, k), vector(wall_velocity, k), results[k]
        impact = (v, vector(normal, k), item(half_size, k), wall, item(roughness, k))
        particle = item(index, k)
        keys = (seed, particle, item(hit, k))
        if omega is None or given is None or grain_hit is None:
            status = rough_rebound(arrays, *impact, *keys, out)
        else:
            if given.shape[0] > 0:
                grain = vector(given, k)
            else:
                grain = grain_at(arrays, seed, particle, item(grain_hit, k))
            status = rough_rebound(arrays, *impact, *keys, out, vector(omega, k), grain)
        if status < OK:
            return k, status, *counts
        relative = combine(1.0, v, -1.0, wall)
        beyond = extrapolates(arrays, math.sqrt(dot(relative, relative)))
        counts = counted(counts, k, status, beyond)
    return -1, OK, *counts
