"""The steps of a draw, for one draw or for a block of draws side by side.

Every step is a loop without branches over arrays of as many numbers as there are draws, which the
compiler turns into vector instructions, or into nothing for a single draw. Where a step reads at
scattered places, the step before has prefetched them.

The numbers of a block are arrays on the stack. Of several numbers a draw, number k of draw r is at
``k * width + r``; of variates, fractions and entries that of row k at ``r * LANES + k``, of weights
that of corner c at ``4 r + c``.
"""

from collections import namedtuple
from typing import Any

import numpy as np
from numba import types

from sampler.compilation.jit import no_refcount_inline_kernel
from sampler.drawing.intrinsics import local_arrays, mean_of_corners, mix_rows, prefetch
from sampler.drawing.normal import normal_of_word
from sampler.drawing.philox import ROUNDS, philox_round
from sampler.drawing.steps import (
    channels_to_state,
    choose_column,
    choose_component,
    choose_corner,
    corner_weights,
    locate,
)
from sampler.formats.channels import CHANNELS, END_MIRRORED, FIRST_MIRRORED
from sampler.formats.fixed_point import MIXTURE_SCALE
from sampler.formats.table_arrays import LANES

#: Draws side by side in a batch.
BLOCK = 32

_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)

#: Most random words that a draw consumes: words 0 to 7 and, for further channels, words 9 and 10.
MOST_WORDS = 10

N_VALUES = len(CHANNELS)
#: Unit of the stored means and factors, a power of two: exact.
_UNIT = np.float32(1.0 / MIXTURE_SCALE)
_ZERO = np.float32(0.0)
#: Bits of word 1 that decide on reflection; the others choose the node.
_REFLECTION_BITS = np.uint32(MIXTURE_SCALE - 1)

#: Type and count of the numbers of a draw.
_NUMBERS: dict[str, tuple[Any, int]] = {
    "index": (types.uint64, 1),
    "hit": (types.uint32, 1),
    "alpha1": (types.float64, 1),
    "speed": (types.float64, 1),
    # counter of the random words, and the words
    "c0": (types.uint64, 1),
    "c1": (types.uint64, 1),
    "c2": (types.uint64, 1),
    "c3": (types.uint64, 1),
    "words": (types.uint32, MOST_WORDS),
    # cell, weights of the upper nodes and of the corners
    "lower_alpha": (types.int32, 1),
    "lower_speed": (types.int32, 1),
    "t": (types.float64, 1),
    "s": (types.float64, 1),
    "weights": (types.float32, 4),
    # choice of the component
    "node": (types.int32, 1),
    "column": (types.int32, 1),
    "fraction": (types.int32, 1),
    "kind": (types.int32, 1),
    # first number of the component's record, first quantile function of its class in the cell
    "record": (types.int32, 1),
    "function": (types.int32, 1),
    "normals": (types.float32, N_VALUES),
    # variates, then fractions between knots; first of the eight numbers that step 5 reads
    "fractions": (types.float32, LANES),
    "entries": (types.int32, LANES),
    "means": (types.float32, LANES),
    "state": (types.float64, N_VALUES),
}
#: Of the table: units without and with reflection, first entry of the rows' quantile functions.
_OF_TABLE: dict[str, tuple[Any, int]] = {
    "units": (types.float32, 2 * LANES),
    "firsts": (types.int32, LANES),
}
Block = namedtuple("Block", [*_NUMBERS, *_OF_TABLE])  # type: ignore[misc]


def blocks_of(width):
    """Make a kernel function that returns a `Block` of as many draws."""
    kinds = {name: (dtype, count * width) for name, (dtype, count) in _NUMBERS.items()}
    return local_arrays(Block, kinds | _OF_TABLE)


@no_refcount_inline_kernel
def draw_block(arrays, seed, block):
    """Fill in the states of a block from its conditions, indices and hits; takes all steps."""
    fill_words(len(arrays.channels), seed, block)
    take_steps(arrays, block)


@no_refcount_inline_kernel
def take_steps(arrays, block):
    """Fill in the states of a block from its conditions and random words."""
    choose_records(arrays, block)
    for k in range(len(arrays.channels) * block.t.size):
        word = block.words[np.uint64(2 * block.t.size + k)]
        block.normals[np.uint64(k)] = normal_of_word(arrays.normals, word)
    mix(arrays, block)
    find_entries(arrays, block)
    fill_channels(arrays, block)
    channels_to_state(block.state)


@no_refcount_inline_kernel
def fill_words(n_channels, seed, block):
    """Write the random words of all draws, as many as the channels need."""
    width, words = block.index.size, block.words
    c0, c1, c2, c3 = block.c0, block.c1, block.c2, block.c3
    key = np.uint64(seed)
    key0, key1 = key & _LOW, key >> _HALF
    for number in range(1 if n_channels <= 2 else (2 if n_channels <= 6 else 3)):
        for n in range(width):
            r = np.uint64(n)
            c0[r], c1[r] = block.index[r], block.index[r] >> _HALF
            c2[r], c3[r] = np.uint64(block.hit[r]), np.uint64(number)
        for k in range(ROUNDS):
            for n in range(width):
                r = np.uint64(n)
                c0[r], c1[r], c2[r], c3[r] = philox_round(k, key0, key1, c0[r], c1[r], c2[r], c3[r])
        for n in range(width):
            r, first = np.uint64(n), 4 * number * width + n
            if number == 2:  # the azimuth of a normal impact is made of word 8
                words[np.uint64(first)] = np.uint32(c1[r])
                words[np.uint64(first + width)] = np.uint32(c2[r])
            else:
                words[np.uint64(first)] = np.uint32(c0[r])
                words[np.uint64(first + width)] = np.uint32(c1[r])
                words[np.uint64(first + 2 * width)] = np.uint32(c2[r])
                words[np.uint64(first + 3 * width)] = np.uint32(c3[r])


@no_refcount_inline_kernel
def choose_records(arrays, block):
    """Take steps 1 to 3: corner weights, record of the component, functions of its class."""
    width = block.t.size
    speeds, n_components = np.int32(arrays.speed.nodes), np.int32(arrays.n_components)
    last_alpha, last_speed = np.int32(arrays.alpha.nodes - 1), np.int32(speeds - 1)
    for n in range(width):
        r = np.uint64(n)
        block.lower_alpha[r], block.t[r] = locate(block.alpha1[r], arrays.alpha)
    for n in range(width):
        r = np.uint64(n)
        block.lower_speed[r], block.s[r] = locate(block.speed[r], arrays.speed)
    for n in range(width):
        r = np.uint64(n)
        weights = corner_weights(block.t[r], block.s[r])
        block.weights[np.uint64(4 * n)] = np.float32(weights[0])
        block.weights[np.uint64(4 * n + 1)] = np.float32(weights[1])
        block.weights[np.uint64(4 * n + 2)] = np.float32(weights[2])
        block.weights[np.uint64(4 * n + 3)] = np.float32(weights[3])
        upper_alpha, upper_speed = choose_corner(block.words[np.uint64(width + n)], weights)
        i = min(np.int32(block.lower_alpha[r] + np.int32(upper_alpha)), last_alpha)
        j = min(np.int32(block.lower_speed[r] + np.int32(upper_speed)), last_speed)
        block.node[r] = i * speeds + j
        block.column[r], block.fraction[r] = choose_column(block.words[r], n_components)
    for n in range(width):
        r = np.uint64(n)
        prefetch(arrays.alias, np.int64(block.node[r] * n_components + block.column[r]))
    for n in range(width):
        r = np.uint64(n)
        entry = arrays.alias[np.uint64(block.node[r] * n_components + block.column[r])]
        block.column[r] = choose_component(block.column[r], block.fraction[r], entry)
        block.kind[r] = 0
    for c in range(1, arrays.n_classes):
        for n in range(width):
            r = np.uint64(n)
            first = arrays.first_of_class[np.uint64(block.node[r] * arrays.n_classes + c)]
            block.kind[r] = np.int32(c) if block.column[r] >= np.int32(first) else block.kind[r]
    cells, n_classes = np.int32(max(arrays.speed.nodes - 1, 1)), np.int32(arrays.n_classes)
    for n in range(width):
        r = np.uint64(n)
        block.record[r] = (block.node[r] * n_components + block.column[r]) * np.int32(arrays.stride)
        cell = block.lower_alpha[r] * cells + block.lower_speed[r]
        block.function[r] = (cell * n_classes + block.kind[r]) * np.int32(arrays.n_marginals)
    for n in range(width):
        prefetch(arrays.components, np.int64(block.record[np.uint64(n)]))


@no_refcount_inline_kernel
def mix(arrays, block):
    """Take step 4: variates mean + L n of all rows, reflected or not."""
    width, units = block.t.size, block.units
    for row in range(LANES):
        units[np.uint64(row)] = units[np.uint64(LANES + row)] = _UNIT
    for row in range(len(arrays.channels)):
        if FIRST_MIRRORED <= arrays.channels[row] < END_MIRRORED:
            units[np.uint64(LANES + row)] = -_UNIT
    for n in range(width):
        record = np.int64(block.record[np.uint64(n)])
        bits = np.int32(block.words[np.uint64(width + n)] & _REFLECTION_BITS)
        turn = LANES if bits < np.int32(arrays.components[np.uint64(record)]) else 0
        mix_rows(
            arrays.components,
            record,
            arrays.channels,
            block.normals,
            n,
            width,
            units,
            turn,
            block.fractions,
            n * LANES,
        )


@no_refcount_inline_kernel
def find_entries(arrays, block):
    """Turn variates into fractions between knots, and prefetch the quantiles there."""
    width, fractions, entries = block.t.size, block.fractions, block.entries
    last, last_but_one = np.float32(arrays.n_knots - 1), np.int32(arrays.n_knots - 2)
    most, scale = np.float32(arrays.variate_max), np.float32(arrays.variate_scale)
    for n in range(width * LANES):
        k = np.uint64(n)
        position = min(max((fractions[k] + most) * scale, _ZERO), last)
        entries[k] = min(np.int32(position), last_but_one)
        fractions[k] = position - np.float32(entries[k])
    n_knots, firsts = np.int32(arrays.n_knots), block.firsts
    for row in range(len(arrays.channels)):
        # a channel without quantiles reads another channel's entry; the value is not used
        firsts[np.uint64(row)] = np.int32(max(arrays.marginals[row], 0)) * n_knots
    for n in range(width):
        first = block.function[np.uint64(n)] * n_knots
        for row in range(LANES):
            k = np.uint64(n * LANES + row)
            entries[k] = (first + firsts[np.uint64(row)] + entries[k]) * np.int32(4)
    for n in range(width):
        for row in range(len(arrays.channels)):
            prefetch(arrays.quantiles, np.int64(entries[np.uint64(n * LANES + row)]))


@no_refcount_inline_kernel
def fill_channels(arrays, block):
    """Take step 5: the channels of all draws, in place of their states."""
    width = block.t.size
    for n in range(width):
        mean_of_corners(
            arrays.quantiles,
            arrays.channels,
            block.entries,
            block.fractions,
            block.weights,
            np.int64(n),
            block.means,
        )
    for k in range(N_VALUES * width):
        block.state[np.uint64(k)] = 0.0
    for row in range(len(arrays.channels)):
        marginal = np.int32(arrays.marginals[row])
        if marginal >= 0:
            first = arrays.channels[row] * width
            for n in range(width):
                span = np.uint64(np.int32(2) * (block.function[np.uint64(n)] + marginal))
                least, step = arrays.spans[span], arrays.spans[span + np.uint64(1)]
                mean = np.float64(block.means[np.uint64(n * LANES + row)])
                block.state[np.uint64(first + n)] = least + step * mean
