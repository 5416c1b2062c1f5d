"""Rebounds of many particles that arrive spinning, in the lab frame.

As the batch of `sampler.drawing.frames`, with the angular velocity before the impact, rad/s, and
grains.
"""

import numpy as np
from numpy.typing import NDArray

from sampler.compilation.jit import no_refcount_kernel
from sampler.drawing.block import BLOCK, item
from sampler.drawing.frames import spinning_impact, to_lab
from sampler.drawing.row_counts import NO_ROWS, counted, extrapolates
from sampler.drawing.spin_draw import (
    draw_spinning,
    fill_grains,
    fill_words,
    local_reals,
    local_states,
    local_vectors,
    local_words,
)
from sampler.drawing.spin_view import grain_law_of
from sampler.drawing.vectors import vector
from sampler.errors import OK
from sampler.formats.bounds import TableArrays


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
    counts = NO_ROWS
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
                return k, status, *counts
            spins[3 * n], spins[3 * n + 1], spins[3 * n + 2] = spin
            if n < count:
                counts = counted(counts, k, status, extrapolates(arrays, speeds[r]))
        fill_words(6, seed, index, hit, first, count, words)
        fill_grains(grain_law_of(arrays.spin), given, seed, index, grain_hit, first, count, grains)
        draw_spinning(arrays, words, angles, speeds, spins, grains, drawn)
        for n in range(count):
            k = first + n
            for variable in range(6):
                results[k, variable] = 0.0
            for variable in arrays.columns:
                if variable < 6:
                    results[k, variable] = drawn[np.uint64(6 * n + variable)]
            one = (vector(velocity, k), vector(normal, k), item(half_size, k))
            keys = (seed, item(index, k), item(hit, k))
            to_lab(*one, vector(wall_velocity, k), *keys, results[k])
    return -1, OK, *counts
