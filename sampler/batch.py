"""Many draws side by side: the steps of `sampler.kernel`, each for a block of draws at a time.

A draw spends most of its time waiting for memory. Here a step asks for what the next step reads,
for all draws of the block, before any of them needs it; and the random words of a block are made
in one loop that the compiler turns into vector instructions. A state has the same bits as from
`sampler.kernel.draw`, which does the same arithmetic one draw at a time.
"""

import numpy as np
from numba import types

from sampler.intrinsics import local_array, prefetch
from sampler.jit import borrowing_inline_kernel, borrowing_kernel
from sampler.kernel import (
    CLAMPED,
    N_VALUES,
    OK,
    choose,
    corner_weights,
    find_entries,
    local_record,
    local_values,
    locate,
    mix,
    state_of,
    status_of,
)
from sampler.normal import normal_of_word
from sampler.philox import philox4x32

#: Draws of a block: enough to keep the memory busy, few enough for the first-level cache.
BLOCK = 32

#: Random words are stored by kind: word k of draw r of the block at ``k * BLOCK + r``.
_WORDS = 12

local_words = local_array(types.uint32, _WORDS * BLOCK)
_local_counters = local_array(types.uint32, 3 * BLOCK)
local_places = local_array(types.int64, 2 * BLOCK)
local_weights = local_array(types.float64, 4 * BLOCK)
local_positions = local_array(types.float64, N_VALUES * BLOCK)
local_block_entries = local_array(types.int64, N_VALUES * BLOCK)

_LOW = np.uint64(0xFFFFFFFF)
_HALF_WORD = np.uint64(32)
_ONE, _TWO, _THREE = np.uint64(1), np.uint64(2), np.uint64(3)


@borrowing_inline_kernel
def item(values, k):
    """Element k of an array, or the only element of an array of one."""
    return values[np.uint64(k)] if values.size > 1 else values[0]


@borrowing_inline_kernel
def fill_words(n_channels, seed, index, hit, first, count, words):
    """Write the random words of a block; see `sampler.philox.philox_block`."""
    counters = _local_counters()
    for r in range(BLOCK):
        # a block that is not full repeats its last draw
        k = first + min(r, count - 1)
        i = item(index, k)
        counters[r] = np.uint32(i & _LOW)
        counters[BLOCK + r] = np.uint32(i >> _HALF_WORD)
        counters[2 * BLOCK + r] = item(hit, k)
    key0, key1 = np.uint32(seed & _LOW), np.uint32(seed >> _HALF_WORD)
    blocks = 1 if n_channels <= 2 else (2 if n_channels <= 6 else 3)
    for block in range(blocks):
        for r in range(BLOCK):
            c0, c1, c2 = counters[r], counters[BLOCK + r], counters[2 * BLOCK + r]
            w0, w1, w2, w3 = philox4x32(key0, key1, c0, c1, c2, np.uint32(block))
            words[(4 * block) * BLOCK + r] = w0
            words[(4 * block + 1) * BLOCK + r] = w1
            words[(4 * block + 2) * BLOCK + r] = w2
            words[(4 * block + 3) * BLOCK + r] = w3


@borrowing_inline_kernel
def fill_normals(arrays, words, values):
    """Turn the words of a block into normals, `N_VALUES` places for each draw."""
    for row in range(len(arrays.channels)):
        # words 8 and 11 belong to no channel: the azimuth of a normal impact is made of word 8
        word = (2 + row if row < 6 else 3 + row) * BLOCK
        for r in range(BLOCK):
            values[r * N_VALUES + row] = normal_of_word(arrays.normals, words[word + r])


@borrowing_inline_kernel
def choose_one(arrays, alpha1, speed, words, r, places, weights):
    """Take steps 1 to 3 for draw r of a block; ask for the record of its component."""
    cell_alpha, cell_speed = locate(alpha1, arrays.alpha), locate(speed, arrays.speed)
    corners = corner_weights(cell_alpha[2], cell_speed[2])
    w0, w1 = words[np.uint64(r)], words[np.uint64(BLOCK + r)]
    record, functions = choose(arrays, cell_alpha, cell_speed, corners, w0, w1)
    prefetch(arrays.components, record)
    places[np.uint64(r)], places[np.uint64(BLOCK + r)] = record, functions
    for corner in range(4):
        weights[np.uint64(4 * r + corner)] = corners[corner]


@borrowing_inline_kernel
def mix_one(arrays, words, r, places, values, factors, entries):
    """Take step 4 for draw r of a block; ask for the quantiles that it will read."""
    at = r * N_VALUES
    mix(arrays, places[np.uint64(r)], words[np.uint64(BLOCK + r)], values, at, factors)
    find_entries(arrays, places[np.uint64(BLOCK + r)], values, at, entries)
    for row in range(len(arrays.channels)):
        if arrays.marginals[row] >= 0:
            prefetch(arrays.quantiles, entries[np.uint64(at + row)])


@borrowing_inline_kernel
def finish_one(arrays, r, places, weights, entries, values, result):
    """Take step 5 for draw r of a block; `result`, shape (8,), gets its components."""
    k = np.uint64(4 * r)
    corners = (weights[k], weights[k + _ONE], weights[k + _TWO], weights[k + _THREE])
    functions = places[np.uint64(BLOCK + r)]
    state_of(arrays, functions, corners, entries, values, r * N_VALUES, result)


@borrowing_kernel
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
    words, values, places = local_words(), local_positions(), local_places()
    weights, factors, result = local_weights(), local_record(), local_values()
    entries = local_block_entries()
    first_clamped = -1
    clamped = 0
    for first in range(start, stop, BLOCK):
        count = min(BLOCK, stop - first)
        fill_words(len(arrays.channels), seed, index, hit, first, count, words)
        for r in range(count):
            angle, velocity = item(alpha1, first + r), item(speed, first + r)
            status = status_of(arrays, angle, velocity)
            if status < OK:
                return first + r, status, first_clamped, clamped
            if status == CLAMPED:
                clamped += 1
                first_clamped = first + r if first_clamped < 0 else first_clamped
            choose_one(arrays, angle, velocity, words, r, places, weights)
        fill_normals(arrays, words, values)
        for r in range(count):
            mix_one(arrays, words, r, places, values, factors, entries)
        for r in range(count):
            finish_one(arrays, r, places, weights, entries, values, result)
            for column in range(len(arrays.columns)):
                component = np.uint64(arrays.columns[column])
                states[np.uint64(first + r), np.uint64(column)] = result[component]
    return -1, OK, first_clamped, clamped
