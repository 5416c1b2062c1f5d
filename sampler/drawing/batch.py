"""Many draws: blocks of them go side by side through the steps of `sampler.drawing.block`.

A draw alone spends most of its time waiting for memory and for itself. A state has the same bits as
from `sampler.drawing.kernel.draw`, which does the same arithmetic one draw at a time.
"""

import numpy as np

from sampler.compilation.jit import no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.block import BLOCK, blocks_of, draw_block
from sampler.drawing.kernel import status_of
from sampler.errors import CLAMPED, OK

local_block = blocks_of(BLOCK)


@no_refcount_inline_kernel
def item(values, k):
    """Element k of an array, or the only element of an array of one."""
    return values[np.uint64(k)] if values.size > 1 else values[0]


@no_refcount_inline_kernel
def fill_keys(block, index, hit, first, count):
    """Copy the keys of a block from row `first` on; one that is not full repeats its last draw."""
    for r in range(BLOCK):
        k = first + min(r, count - 1)
        block.index[np.uint64(r)], block.hit[np.uint64(r)] = item(index, k), item(hit, k)


@no_refcount_inline_kernel
def fill_conditions(arrays, block, alpha1, speed, first, count):
    """Copy the conditions of a block; whether all of them lie within the table.

    Without branches; NaN is not within.
    """
    low, high = arrays.alpha.low, arrays.alpha.high
    least, most = arrays.speed.low, arrays.speed.high
    outside = np.int64(0)
    for r in range(BLOCK):
        k = first + min(r, count - 1)
        angle, velocity = item(alpha1, k), item(speed, k)
        block.alpha1[np.uint64(r)], block.speed[np.uint64(r)] = angle, velocity
        inside = (angle >= low) & (angle <= high) & (velocity >= least) & (velocity <= most)
        outside += np.int64(not inside)
    return outside == 0


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
    tuple of four int
        First row with an error (-1: none) and its code; first clamped row (-1: none) and the
        number of clamped rows before the error.
    """
    block = local_block()
    first_clamped = -1
    clamped = 0
    for first in range(start, stop, BLOCK):
        count = min(BLOCK, stop - first)
        if not fill_conditions(arrays, block, alpha1, speed, first, count):
            for r in range(count):
                status = status_of(arrays, block.alpha1[np.uint64(r)], block.speed[np.uint64(r)])
                if status < OK:
                    return first + r, status, first_clamped, clamped
                if status == CLAMPED:
                    clamped += 1
                    first_clamped = first + r if first_clamped < 0 else first_clamped
        fill_keys(block, index, hit, first, count)
        draw_block(arrays, seed, block)
        for r in range(count):
            for column in range(len(arrays.columns)):
                component = np.uint64(arrays.columns[column] * BLOCK + r)
                states[np.uint64(first + r), np.uint64(column)] = block.state[component]
    return -1, OK, first_clamped, clamped
