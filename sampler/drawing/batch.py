"""Many draws: blocks of them go side by side through the steps of `sampler.drawing.block`.

A draw alone is bound by latency, of memory and of operations that depend on each other. A state
has the same bits as from `sampler.drawing.kernel.draw`, which is a block of one.
"""

import numpy as np
from numba import types

from sampler.compilation.jit import no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.block import BLOCK, MOST_WORDS, N_VALUES, item, state_drawer, word_filler
from sampler.drawing.intrinsics import local_array
from sampler.drawing.kernel import status_of
from sampler.drawing.row_counts import NO_ROWS, counted
from sampler.errors import OK

local_words = local_array(types.uint32, MOST_WORDS * BLOCK)
local_conditions = local_array(types.float64, BLOCK)
local_states = local_array(types.float64, N_VALUES * BLOCK)
fill_words, draw_states = word_filler(BLOCK), state_drawer(BLOCK)


@no_refcount_inline_kernel
def fill_conditions(arrays, alpha1, speed, first, count, angles, velocities):
    """Copy the conditions of a block; whether all lie within the table, and how many extrapolate.

    Without branches; NaN is not within.
    """
    low, high = arrays.alpha.low, arrays.alpha.high
    least, most = arrays.speed.low, arrays.speed.high
    valid_least, valid_most = arrays.valid_speed
    outside, extrapolated = np.int64(0), np.int64(0)
    for r in range(BLOCK):
        k = first + min(r, count - 1)
        angle, velocity = item(alpha1, k), item(speed, k)
        angles[np.uint64(r)], velocities[np.uint64(r)] = angle, velocity
        inside = (angle >= low) & (angle <= high) & (velocity >= least) & (velocity <= most)
        outside += np.int64(not inside)
        valid = (velocity >= valid_least) & (velocity <= valid_most) | (r >= count)
        extrapolated += np.int64(not valid)
    return outside == 0, extrapolated


@no_refcount_kernel
def draw_batch(arrays, alpha1, speed, seed, index, hit, states, start, stop):
    """Draw the states of the rows from start to stop; ends with the block of the first error.

    Parameters
    ----------
    arrays : TableArrays
    alpha1, speed : float64 arrays, shape (n,) or (1,)
    seed : uint64
    index : uint64 array, shape (n,) or (1,)
    hit : uint32 array, shape (n,) or (1,)
    states : float64 or float32 array, shape (n, n_columns), rows start to stop written
    start, stop : int

    Returns
    -------
    tuple of five int
        First row with an error (-1: none) and its code; first clamped row (-1: none); before the
        error the number of rows that were clamped, and of those that extrapolate the laws.
    """
    words, drawn = local_words(), local_states()
    angles, velocities = local_conditions(), local_conditions()
    counts = NO_ROWS
    for first in range(start, stop, BLOCK):
        count = min(BLOCK, stop - first)
        given = arrays, alpha1, speed, first, count, angles, velocities
        inside, beyond = fill_conditions(*given)
        counts = counted(counts, first, OK, beyond)
        if not inside:
            for r in range(count):
                status = status_of(arrays, angles[np.uint64(r)], velocities[np.uint64(r)])
                if status < OK:
                    return first + r, status, *counts
                counts = counted(counts, first + r, status, 0)
        fill_words(len(arrays.channels), seed, index, hit, first, count, words)
        draw_states(arrays, words, angles, velocities, drawn)
        for r in range(count):
            for column in range(len(arrays.columns)):
                component = np.uint64(arrays.columns[column] * BLOCK + r)
                states[np.uint64(first + r), np.uint64(column)] = drawn[component]
    return -1, OK, *counts
