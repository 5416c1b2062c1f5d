"""The steps of a draw, each for a block of draws side by side.

Every step is a loop over arrays of `BLOCK` numbers without branches, which the compiler turns into
vector instructions; where a draw reads many neighbours, its channels go side by side instead. What
a step reads at scattered places was asked for by the step before. The arithmetic of a draw is that
of `sampler.drawing.kernel`, number by number.

An array of several numbers a draw has number k of draw r at ``k * BLOCK + r``; variates, fractions
and entries have that of row k at ``r * LANES + k``, weights that of corner c at ``4 r + c``.
"""

import math

import numpy as np
from numba import types

from sampler.compilation.jit import no_refcount_inline_kernel
from sampler.drawing.intrinsics import local_array, mean_of_corners, mix_rows, prefetch
from sampler.drawing.kernel import (
    CORNER_UNIT,
    LANES,
    N_VALUES,
    REFLECTION_BITS,
    UNIT,
    ZERO,
    local_units,
)
from sampler.drawing.normal import piece_of_word
from sampler.formats.channels import END_MIRRORED, FIRST_MIRRORED

#: Draws of a block.
BLOCK = 32

_LOW = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
_M0, _M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_W0, _W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)

_local_longs = local_array(types.uint64, BLOCK)
_local_integers = local_array(types.int32, BLOCK)
_local_reals = local_array(types.float64, BLOCK)
_local_singles = local_array(types.float32, BLOCK)
_local_cubics = local_array(types.float32, 4 * BLOCK)
local_words = local_array(types.uint32, 12 * BLOCK)
local_conditions = local_array(types.float64, BLOCK)
local_nodes = local_array(types.int32, BLOCK)
local_weights = local_array(types.float32, 4 * BLOCK)
local_values = local_array(types.float64, N_VALUES * BLOCK)
local_normals = local_array(types.float32, N_VALUES * BLOCK)
local_fractions = local_array(types.float32, LANES * BLOCK)
local_entries = local_array(types.int32, LANES * BLOCK)


@no_refcount_inline_kernel
def fill_words(n_channels, seed, index, hit, first, count, words):
    """Write the random words of a block, as `sampler.drawing.philox`; spare lanes repeat the last.

    Words lie in the lower halves of 64 bits, so that products need no rearrangement.
    """
    c0, c1, c2, c3 = _local_longs(), _local_longs(), _local_longs(), _local_longs()
    blocks = 1 if n_channels <= 2 else (2 if n_channels <= 6 else 3)
    for block in range(blocks):
        for r in range(BLOCK):
            k = np.uint64(first + min(r, count - 1))
            i = index[k] if index.size > 1 else index[0]
            at = np.uint64(r)
            c0[at], c1[at] = i, i >> _HALF
            c2[at] = hit[k] if hit.size > 1 else hit[0]
            c3[at] = np.uint64(block)
        key0, key1 = seed & _LOW, seed >> _HALF
        for _ in range(10):
            for n in range(BLOCK):
                at = np.uint64(n)
                p0, p1 = (c0[at] & _LOW) * _M0, (c2[at] & _LOW) * _M1
                c0[at] = (p1 >> _HALF) ^ c1[at] ^ key0
                c1[at] = p1
                c2[at] = (p0 >> _HALF) ^ c3[at] ^ key1
                c3[at] = p0
            key0, key1 = (key0 + _W0) & _LOW, (key1 + _W1) & _LOW
        base = 4 * block * BLOCK
        for n in range(BLOCK):
            at = np.uint64(n)
            words[np.uint64(base + n)] = np.uint32(c0[at])
            words[np.uint64(base + BLOCK + n)] = np.uint32(c1[at])
            words[np.uint64(base + 2 * BLOCK + n)] = np.uint32(c2[at])
            words[np.uint64(base + 3 * BLOCK + n)] = np.uint32(c3[at])


@no_refcount_inline_kernel
def locate_block(axis, values, nodes, weights):
    """Take step 1: lower node, and weight of the upper one."""
    table = axis.coordinate
    end = table.size - 1.0
    last = np.int32(table.size - 2)
    offset, top = np.int32(axis.offset), np.int32(axis.nodes - 2)
    most = 1.0 if axis.nodes > 1 else 0.0
    for n in range(BLOCK):
        r = np.uint64(n)
        position = (min(max(values[r], axis.first), axis.last) - axis.origin) * axis.scale
        position = min(max(position, 0.0), end)
        k = min(np.int32(position), last)
        below = table[np.uint64(k)]
        x = below + (position - k) * (table[np.uint64(k) + np.uint64(1)] - below)
        lower = max(min(np.int32(np.int32(x) - offset), top), np.int32(0))
        nodes[r] = lower
        weights[r] = min(max(x - (lower + offset), 0.0), most)


@no_refcount_inline_kernel
def choose_block(arrays, alpha_nodes, t, speed_nodes, s, words, weights, records, functions):
    """Take steps 2 and 3: corner weights, record of the component, functions of its class."""
    node, column = _local_integers(), _local_integers()
    fraction, entry, kind = _local_integers(), _local_integers(), _local_integers()
    speeds, n_components = np.int32(arrays.speed.nodes), np.int32(arrays.n_components)
    last_alpha, last_speed = np.int32(arrays.alpha.nodes - 1), np.int32(speeds - 1)
    for n in range(BLOCK):
        r = np.uint64(n)
        w0, w1 = (1.0 - t[r]) * (1.0 - s[r]), (1.0 - t[r]) * s[r]
        w2 = t[r] * (1.0 - s[r])
        weights[np.uint64(4 * n)] = np.float32(w0)
        weights[np.uint64(4 * n + 1)] = np.float32(w1)
        weights[np.uint64(4 * n + 2)] = np.float32(w2)
        weights[np.uint64(4 * n + 3)] = np.float32(t[r] * s[r])
        w = words[np.uint64(BLOCK + n)]
        place = (np.float64(np.int32(w >> np.uint32(12))) + 0.5) * CORNER_UNIT
        upper_alpha = place >= w0 + w1
        upper_speed = place >= (w0 + w1 + w2 if upper_alpha else w0)
        i = min(np.int32(alpha_nodes[r] + np.int32(upper_alpha)), last_alpha)
        j = min(np.int32(speed_nodes[r] + np.int32(upper_speed)), last_speed)
        node[r] = i * speeds + j
        # the whole part of w n / 2^32, and 16 bits of the rest, in 32 bits
        w = words[r]
        k = np.uint32(n_components)
        high = np.uint32(np.uint32(w >> np.uint32(16)) * k)
        product = np.uint32(
            high + np.uint32(np.uint32(np.uint32(w & np.uint32(0xFFFF)) * k) >> np.uint32(16))
        )
        column[r] = np.int32(product >> np.uint32(16))
        fraction[r] = np.int32(product & np.uint32(0xFFFF))
    for n in range(BLOCK):
        r = np.uint64(n)
        prefetch(arrays.alias, np.int64(node[r] * n_components + column[r]))
    for n in range(BLOCK):
        r = np.uint64(n)
        entry[r] = np.int32(arrays.alias[np.uint64(node[r] * n_components + column[r])])
        kind[r] = 0
    for n in range(BLOCK):
        r = np.uint64(n)
        e = np.uint32(entry[r])
        stays = fraction[r] < np.int32(e >> np.uint32(16))
        column[r] = column[r] if stays else np.int32(e & np.uint32(0xFFFF))
    for c in range(1, arrays.n_classes):
        for n in range(BLOCK):
            r = np.uint64(n)
            first = np.int32(arrays.first_of_class[np.uint64(node[r] * arrays.n_classes + c)])
            kind[r] = np.int32(c) if column[r] >= first else kind[r]
    cells = np.int32(max(arrays.speed.nodes - 1, 1))
    for n in range(BLOCK):
        r = np.uint64(n)
        records[r] = (node[r] * n_components + column[r]) * np.int32(arrays.stride)
        cell = alpha_nodes[r] * cells + speed_nodes[r]
        functions[r] = (cell * np.int32(arrays.n_classes) + kind[r]) * np.int32(arrays.n_marginals)
    for n in range(BLOCK):
        prefetch(arrays.components, np.int64(records[np.uint64(n)]))


@no_refcount_inline_kernel
def fill_normals(table, words, first_word, normals, first):
    """Turn words into the normals of a row; see `sampler.drawing.normal.normal_of_word`."""
    rows, t, sign, cubic = _local_integers(), _local_singles(), _local_singles(), _local_cubics()
    for n in range(BLOCK):
        r = np.uint64(n)
        rows[r], t[r], sign[r] = piece_of_word(words[np.uint64(first_word + n)])
    for n in range(BLOCK):
        r = np.uint64(n)
        row = np.uint64(rows[r])
        cubic[r] = table[row, 0]
        cubic[np.uint64(BLOCK + n)] = table[row, 1]
        cubic[np.uint64(2 * BLOCK + n)] = table[row, 2]
        cubic[np.uint64(3 * BLOCK + n)] = table[row, 3]
    for n in range(BLOCK):
        r = np.uint64(n)
        x = cubic[np.uint64(2 * BLOCK + n)] + t[r] * cubic[np.uint64(3 * BLOCK + n)]
        x = cubic[r] + t[r] * (cubic[np.uint64(BLOCK + n)] + t[r] * x)
        normals[np.uint64(first + n)] = sign[r] * x


@no_refcount_inline_kernel
def mix_block(arrays, records, functions, words, normals, fractions, entries):
    """Take step 4: normals to fractions between knots; asks for the quantiles there."""
    n_channels = len(arrays.channels)
    units, knots = local_units(), local_entries()
    for row in range(LANES):
        units[np.uint64(row)] = units[np.uint64(LANES + row)] = UNIT
    for row in range(n_channels):
        if FIRST_MIRRORED <= arrays.channels[row] < END_MIRRORED:
            units[np.uint64(LANES + row)] = -UNIT
    for n in range(BLOCK):
        record = np.int64(records[np.uint64(n)])
        limit = np.int32(words[np.uint64(BLOCK + n)] & REFLECTION_BITS)
        turn = LANES if limit < np.int32(arrays.components[np.uint64(record)]) else 0
        mix_rows(
            arrays.components,
            record,
            arrays.channels,
            normals,
            n,
            BLOCK,
            units,
            turn,
            fractions,
            n * LANES,
        )
    last, last_but_one = np.float32(arrays.n_knots - 1), np.int32(arrays.n_knots - 2)
    most, scale = np.float32(arrays.variate_max), np.float32(arrays.variate_scale)
    for n in range(BLOCK * LANES):
        k = np.uint64(n)
        position = min(max((fractions[k] + most) * scale, ZERO), last)
        knot = min(np.int32(position), last_but_one)
        fractions[k] = position - np.float32(knot)
        knots[k] = knot
    for n in range(BLOCK):
        for row in range(n_channels):
            k = np.uint64(n * LANES + row)
            # a channel without quantiles reads those of another, to no end
            function = functions[np.uint64(n)] + np.int32(max(arrays.marginals[row], 0))
            entry = (function * np.int32(arrays.n_knots) + knots[k]) * np.int32(4)
            entries[k] = entry
            prefetch(arrays.quantiles, np.int64(entry))


@no_refcount_inline_kernel
def quantile_block(arrays, functions, weights, entries, fractions, result):
    """Take step 5: channel k of draw r is number ``k * BLOCK + r`` of `result`."""
    means = local_fractions()
    for n in range(BLOCK):
        mean_of_corners(
            arrays.quantiles, arrays.channels, entries, fractions, weights, np.int64(n), means
        )
    for k in range(N_VALUES * BLOCK):
        result[np.uint64(k)] = 0.0
    for row in range(len(arrays.channels)):
        marginal = np.int32(arrays.marginals[row])
        if marginal >= 0:
            first = arrays.channels[row] * BLOCK
            for n in range(BLOCK):
                span = np.uint64(np.int32(2) * (functions[np.uint64(n)] + marginal))
                least, step = arrays.spans[span], arrays.spans[span + np.uint64(1)]
                mean = np.float64(means[np.uint64(n * LANES + row)])
                result[np.uint64(first + n)] = least + step * mean


@no_refcount_inline_kernel
def states_of_block(channels):
    """Turn channels into components, in place; see `sampler.drawing.states.channels_to_state`."""
    for n in range(BLOCK):
        v, u_hat = channels[np.uint64(n)], channels[np.uint64(BLOCK + n)]
        omega_z, w_hat = channels[np.uint64(2 * BLOCK + n)], channels[np.uint64(3 * BLOCK + n)]
        omega_x = channels[np.uint64(4 * BLOCK + n)]
        omega_y = channels[np.uint64(5 * BLOCK + n)]
        rest = (1.0 - v) * (1.0 + v)
        channels[np.uint64(n)] = u_hat * math.sqrt(rest)
        channels[np.uint64(BLOCK + n)] = v
        rest *= (1.0 - u_hat) * (1.0 + u_hat)
        channels[np.uint64(2 * BLOCK + n)] = w_hat * math.sqrt(rest)
        channels[np.uint64(3 * BLOCK + n)] = omega_x
        channels[np.uint64(4 * BLOCK + n)] = omega_y
        channels[np.uint64(5 * BLOCK + n)] = omega_z
        channels[np.uint64(6 * BLOCK + n)] *= rest * ((1.0 - w_hat) * (1.0 + w_hat))
        channels[np.uint64(7 * BLOCK + n)] = math.floor(channels[np.uint64(7 * BLOCK + n)])


@no_refcount_inline_kernel
def draw_block(arrays, words, alpha1, speed, states):
    """Take all steps for the conditions of a block; `states` gets component k of draw r."""
    n_channels = len(arrays.channels)
    alpha_nodes, speed_nodes = local_nodes(), local_nodes()
    t, s, weights = _local_reals(), _local_reals(), local_weights()
    records, functions = local_nodes(), local_nodes()
    normals, fractions, entries = local_normals(), local_fractions(), local_entries()
    locate_block(arrays.alpha, alpha1, alpha_nodes, t)
    locate_block(arrays.speed, speed, speed_nodes, s)
    choose_block(arrays, alpha_nodes, t, speed_nodes, s, words, weights, records, functions)
    for row in range(n_channels):
        # words 8 and 11 belong to no channel: the azimuth of a normal impact is made of word 8
        word = (2 + row if row < 6 else 3 + row) * BLOCK
        fill_normals(arrays.normals, words, word, normals, row * BLOCK)
    mix_block(arrays, records, functions, words, normals, fractions, entries)
    quantile_block(arrays, functions, weights, entries, fractions, states)
    states_of_block(states)
