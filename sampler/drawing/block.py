"""The steps of a draw, for one draw alone or for a block of draws side by side.

Every step is made for a number of draws, its width, by a function of that name, and goes through
`sampler.drawing.steps` in loops without branches. The compiler turns them into vector instructions,
or dissolves them where the width is one. What a step reads at scattered places has been prefetched
by the step before.

An array of several numbers a draw has number k of draw r at ``k * width + r``; variates, fractions
and entries have that of row k at ``r * LANES + k``, weights that of corner c at ``4 r + c``.
"""

import numpy as np
from numba import types
from tablegen.fitting.fixed_point import MIXTURE_SCALE

from sampler.compilation.jit import no_refcount_inline_kernel
from sampler.drawing.intrinsics import local_array, mean_of_corners, prefetch
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
from sampler.formats.bounds import LANES
from sampler.formats.channels import END_MIRRORED, FIRST_MIRRORED, VARIABLES

#: Draws side by side in a batch.
BLOCK = 32

#: Most random words that a draw consumes: words 0 to 7 and, for further channels, words 9 and 10.
MOST_WORDS = 10

#: Numbers of a draw: its variables, and before them its channels, which are fewer.
N_VALUES = len(VARIABLES)
#: Unit of the stored means and factors, a power of two: exact.
_UNIT = np.float32(1.0 / MIXTURE_SCALE)
_ZERO = np.float32(0.0)
#: Bits of word 1 that decide on reflection; the others choose the node.
_REFLECTION_BITS = np.uint32(MIXTURE_SCALE - 1)
_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)

_local_row = local_array(types.float32, LANES)
_local_units = local_array(types.float32, 2 * LANES)


@no_refcount_inline_kernel
def item(values, k):
    """Element k of an array, or the only element of an array of one."""
    return values[np.uint64(k)] if values.size > 1 else values[0]


def word_filler(width):
    """Make the function that writes the random words of as many draws."""
    local_longs = local_array(types.uint64, width)

    @no_refcount_inline_kernel
    def fill_words(n_channels, seed, index, hit, first, count, words):
        """Write the words for the keys from row `first` on; spare draws repeat the last of them.

        As many blocks of words are made as the channels need.
        """
        c0, c1, c2, c3 = local_longs(), local_longs(), local_longs(), local_longs()
        key0, key1 = np.uint64(seed) & _LOW, np.uint64(seed) >> _HALF
        for block in range(1 if n_channels <= 2 else (2 if n_channels <= 6 else 3)):
            for n in range(width):
                r, k = np.uint64(n), first + min(n, count - 1)
                c0[r], c1[r] = item(index, k), item(index, k) >> _HALF
                c2[r], c3[r] = item(hit, k), np.uint64(block)
            for number in range(ROUNDS):
                for n in range(width):
                    r = np.uint64(n)
                    c0[r], c1[r], c2[r], c3[r] = philox_round(
                        number, key0, key1, c0[r], c1[r], c2[r], c3[r]
                    )
            base = 4 * block * width
            for n in range(width):
                r = np.uint64(n)
                if block == 2:  # words 8 and 11 belong to no channel
                    words[np.uint64(base + n)] = np.uint32(c1[r])
                    words[np.uint64(base + width + n)] = np.uint32(c2[r])
                else:
                    words[np.uint64(base + n)] = np.uint32(c0[r])
                    words[np.uint64(base + width + n)] = np.uint32(c1[r])
                    words[np.uint64(base + 2 * width + n)] = np.uint32(c2[r])
                    words[np.uint64(base + 3 * width + n)] = np.uint32(c3[r])

    return fill_words


def record_chooser(width):
    """Make the function that takes steps 1 to 3 of as many draws."""
    local_integers, local_reals = local_array(types.int32, width), local_array(types.float64, width)

    @no_refcount_inline_kernel
    def choose_records(arrays, words, alpha1, speed, weights, records, functions):
        """Write corner weights, record of the component and first function of its class."""
        lower_alpha, lower_speed, node = local_integers(), local_integers(), local_integers()
        column, fraction, kind = local_integers(), local_integers(), local_integers()
        entry, t, s = local_integers(), local_reals(), local_reals()
        speeds, n_components = np.int32(arrays.speed.nodes), np.int32(arrays.n_components)
        last_alpha, last_speed = np.int32(arrays.alpha.nodes - 1), np.int32(speeds - 1)
        for n in range(width):
            r = np.uint64(n)
            lower_alpha[r], t[r] = locate(alpha1[r], arrays.alpha)
        for n in range(width):
            r = np.uint64(n)
            lower_speed[r], s[r] = locate(speed[r], arrays.speed)
        for n in range(width):
            r = np.uint64(n)
            w00, w01, w10, w11 = corner_weights(t[r], s[r])
            weights[np.uint64(4 * n)] = np.float32(w00)
            weights[np.uint64(4 * n + 1)] = np.float32(w01)
            weights[np.uint64(4 * n + 2)] = np.float32(w10)
            weights[np.uint64(4 * n + 3)] = np.float32(w11)
            up_alpha, up_speed = choose_corner(words[np.uint64(width + n)], (w00, w01, w10, w11))
            i = min(np.int32(lower_alpha[r] + np.int32(up_alpha)), last_alpha)
            j = min(np.int32(lower_speed[r] + np.int32(up_speed)), last_speed)
            node[r] = i * speeds + j
            column[r], fraction[r] = choose_column(words[r], n_components)
        for n in range(width):
            r = np.uint64(n)
            prefetch(arrays.alias, np.int64(node[r] * n_components + column[r]))
        for n in range(width):
            r = np.uint64(n)
            entry[r] = np.int32(arrays.alias[np.uint64(node[r] * n_components + column[r])])
            kind[r] = 0
        for n in range(width):
            r = np.uint64(n)
            column[r] = choose_component(column[r], fraction[r], entry[r])
        for c in range(1, arrays.n_classes):
            for n in range(width):
                r = np.uint64(n)
                first = np.int32(arrays.first_of_class[np.uint64(node[r] * arrays.n_classes + c)])
                kind[r] = np.int32(c) if column[r] >= first else kind[r]
        cells, n_classes = np.int32(max(arrays.speed.nodes - 1, 1)), np.int32(arrays.n_classes)
        for n in range(width):
            r = np.uint64(n)
            records[r] = (node[r] * n_components + column[r]) * np.int32(arrays.stride)
            cell = lower_alpha[r] * cells + lower_speed[r]
            functions[r] = (cell * n_classes + kind[r]) * np.int32(arrays.n_marginals)
        for n in range(width):
            prefetch(arrays.components, np.int64(records[np.uint64(n)]))

    return choose_records


def mixer(width):
    """Make the function that takes step 4 of as many draws."""
    local_normals = local_array(types.float32, LANES * width)

    @no_refcount_inline_kernel
    def mix(arrays, words, records, variates):
        """Write the variates mean + L n of all rows, reflected or not."""
        normals, units, z = local_normals(), _local_units(), _local_row()
        n_channels = len(arrays.channels)
        for number in range(n_channels * width):
            word = words[np.uint64(2 * width + number)]
            normals[np.uint64(number)] = normal_of_word(arrays.normals, word)
        for row in range(LANES):
            units[np.uint64(row)] = units[np.uint64(LANES + row)] = _UNIT
        for row in range(n_channels):
            if FIRST_MIRRORED <= arrays.channels[row] < END_MIRRORED:
                units[np.uint64(LANES + row)] = -_UNIT
        for n in range(width):
            record = np.int64(records[np.uint64(n)])
            bits = np.int32(words[np.uint64(width + n)] & _REFLECTION_BITS)
            turn = LANES if bits < np.int32(arrays.components[np.uint64(record)]) else 0
            for row in range(LANES):
                z[np.uint64(row)] = np.float32(arrays.components[np.uint64(record + 1 + row)])
            for column in range(n_channels):
                normal = normals[np.uint64(column * width + n)]
                # the columns of L, from the diagonal down, follow each other
                start = 1 + n_channels * (column + 1) - column * (column + 1) // 2
                for row in range(LANES):
                    factor = np.float32(arrays.components[np.uint64(record + start + row)])
                    z[np.uint64(row)] += factor * (normal if row >= column else _ZERO)
            for row in range(LANES):
                k = np.uint64(n * LANES + row)
                variates[k] = z[np.uint64(row)] * units[np.uint64(turn + row)]

    return mix


def entry_finder(width):
    """Make the function that finds the knots of as many draws."""
    local_knots = local_array(types.int32, LANES * width)

    @no_refcount_inline_kernel
    def find_entries(arrays, functions, variates, entries):
        """Turn variates into fractions between knots, and write and prefetch where step 5 reads."""
        knots = local_knots()
        last, last_but_one = np.float32(arrays.n_knots - 1), np.int32(arrays.n_knots - 2)
        most, scale = np.float32(arrays.variate_max), np.float32(arrays.variate_scale)
        for n in range(width * LANES):
            k = np.uint64(n)
            position = min(max((variates[k] + most) * scale, _ZERO), last)
            knot = min(np.int32(position), last_but_one)
            variates[k] = position - np.float32(knot)
            knots[k] = knot
        for n in range(width):
            for row in range(len(arrays.channels)):
                k = np.uint64(n * LANES + row)
                # a channel without quantiles reads another channel's entry; the value is not used
                function = functions[np.uint64(n)] + np.int32(max(arrays.marginals[row], 0))
                entry = (function * np.int32(arrays.n_knots) + knots[k]) * np.int32(4)
                entries[k] = entry
                prefetch(arrays.quantiles, np.int64(entry))

    return find_entries


def channel_filler(width):
    """Make the function that takes step 5 of as many draws."""
    local_means = local_array(types.float32, LANES * width)

    @no_refcount_inline_kernel
    def fill_channels(arrays, functions, weights, entries, fractions, channels):
        """Write all channels, 0 for those that the table leaves out."""
        means = local_means()
        for n in range(width):
            mean_of_corners(
                arrays.quantiles, arrays.channels, entries, fractions, weights, np.int64(n), means
            )
        for k in range(N_VALUES * width):
            channels[np.uint64(k)] = 0.0
        for row in range(len(arrays.channels)):
            marginal = np.int32(arrays.marginals[row])
            if marginal >= 0:
                first = arrays.channels[row] * width
                for n in range(width):
                    span = np.uint64(np.int32(2) * (functions[np.uint64(n)] + marginal))
                    least, step = arrays.spans[span], arrays.spans[span + np.uint64(1)]
                    mean = np.float64(means[np.uint64(n * LANES + row)])
                    channels[np.uint64(first + n)] = least + step * mean

    return fill_channels


def state_drawer(width):
    """Make the function that takes all steps of as many draws."""
    local_integers = local_array(types.int32, width)
    local_weights = local_array(types.float32, 4 * width)
    local_variates = local_array(types.float32, LANES * width)
    local_entries = local_array(types.int32, LANES * width)
    choose_records, mix = record_chooser(width), mixer(width)
    find_entries, fill_channels = entry_finder(width), channel_filler(width)

    @no_refcount_inline_kernel
    def draw_states(arrays, words, alpha1, speed, states):
        """Make states of random words at conditions."""
        weights, records, functions = local_weights(), local_integers(), local_integers()
        variates, entries = local_variates(), local_entries()
        choose_records(arrays, words, alpha1, speed, weights, records, functions)
        mix(arrays, words, records, variates)
        find_entries(arrays, functions, variates, entries)
        fill_channels(arrays, functions, weights, entries, variates, states)
        channels_to_state(states, width)

    return draw_states
