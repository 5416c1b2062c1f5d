"""The arithmetic of the steps of a draw, written for one draw and without branches.

`sampler.drawing.block` takes any number of draws through these functions side by side.
"""

import math

import numpy as np

from sampler.compilation.jit import inline_kernel, no_refcount_inline_kernel

_CORNER_SHIFT = np.uint32(12)
_CORNER_UNIT = 2.0**-20
_HALF = np.uint32(16)
_LOW_HALF = np.uint32(0xFFFF)


@no_refcount_inline_kernel
def locate(value, axis):
    """Step 1: lower node (int32) and weight of the upper one; outside values go to the end.

    On an axis of one node that node is the lower one, with weight 0 for the upper one.
    """
    table = axis.coordinate
    position = (min(max(value, axis.first), axis.last) - axis.origin) * axis.scale
    position = min(max(position, 0.0), table.size - 1.0)
    k = min(np.int32(position), np.int32(table.size - 2))
    below = table[np.uint64(k)]
    x = below + (position - k) * (table[np.uint64(k) + np.uint64(1)] - below)
    offset = np.int32(axis.offset)
    lower = max(min(np.int32(np.int32(x) - offset), np.int32(axis.nodes - 2)), np.int32(0))
    # the ends of an axis are nodes, but their coordinate is rounded
    return lower, min(max(x - (lower + offset), 0.0), 1.0 if axis.nodes > 1 else 0.0)


@inline_kernel
def corner_weights(t, r):
    """Bilinear weights of the four nodes of a cell, in the order of `TableArrays.quantiles`."""
    return (1.0 - t) * (1.0 - r), (1.0 - t) * r, t * (1.0 - r), t * r


@inline_kernel
def choose_corner(word, weights):
    """Step 2: corner of the cell, each with its weight, from the upper 20 bits of a word."""
    c = (np.float64(np.int32(word >> _CORNER_SHIFT)) + 0.5) * _CORNER_UNIT
    w0, w1, w2, _ = weights
    upper_alpha = c >= w0 + w1
    return upper_alpha, c >= (w0 + w1 + w2 if upper_alpha else w0)


@inline_kernel
def choose_column(word, n_components):
    """Step 3: column of the alias table, and 16 bits of the fraction within it.

    They are the integer part of word * n / 2**32 and what follows it, worked out in 32 bits.
    """
    n = np.uint32(n_components)
    low = np.uint32(np.uint32(np.uint32(word & _LOW_HALF) * n) >> _HALF)
    product = np.uint32(np.uint32(np.uint32(word >> _HALF) * n) + low)
    return np.int32(product >> _HALF), np.int32(product & _LOW_HALF)


@inline_kernel
def choose_component(column, fraction, entry):
    """Step 3: mixture component by the alias method, from the entry of the column."""
    stays = fraction < np.int32(np.uint32(entry) >> _HALF)
    return column if stays else np.int32(np.uint32(entry) & _LOW_HALF)


@no_refcount_inline_kernel
def fill_works(values, width):
    """Turn the last channel into the two works, in place, while the others are still channels.

    Parameters
    ----------
    values : float64 array, shape (10 * width,)
        As for `channels_to_state`.
    width : int
    """
    for r in range(width):
        v, u_hat = values[np.uint64(r)], values[np.uint64(width + r)]
        w_hat, energy_hat = values[np.uint64(3 * width + r)], values[np.uint64(6 * width + r)]
        rest = (1.0 - v) * (1.0 + v) * ((1.0 - u_hat) * (1.0 + u_hat))
        lost = rest * ((1.0 - w_hat) * (1.0 + w_hat)) * (1.0 - energy_hat)
        normal_hat = values[np.uint64(8 * width + r)]
        square = normal_hat * normal_hat
        values[np.uint64(8 * width + r)] = square * square * lost
        others = (1.0 - normal_hat) * (1.0 + normal_hat) * (1.0 + square)
        values[np.uint64(9 * width + r)] = others * lost


@no_refcount_inline_kernel
def channels_to_state(values, width):
    """Turn channels into the variables of a state, in place; those left out are 0 before and after.

    All but the works, which `fill_works` has made before.

    Parameters
    ----------
    values : float64 array, shape (10 * width,)
        Number k of draw r at k * width + r: on entry channels in the order of
        `sampler.formats.channels.CHANNELS`, on return variables in that of `VARIABLES`.
    width : int
    """
    for r in range(width):
        v, u_hat = values[np.uint64(r)], values[np.uint64(width + r)]
        omega_z, w_hat = values[np.uint64(2 * width + r)], values[np.uint64(3 * width + r)]
        omega_x, omega_y = values[np.uint64(4 * width + r)], values[np.uint64(5 * width + r)]
        # products of (1 - x)(1 + x) cannot become negative by rounding; 1 - v^2 - u^2 could
        rest = (1.0 - v) * (1.0 + v)
        values[np.uint64(r)] = u_hat * math.sqrt(rest)
        values[np.uint64(width + r)] = v
        rest *= (1.0 - u_hat) * (1.0 + u_hat)
        values[np.uint64(2 * width + r)] = w_hat * math.sqrt(rest)
        values[np.uint64(3 * width + r)] = omega_x
        values[np.uint64(4 * width + r)] = omega_y
        values[np.uint64(5 * width + r)] = omega_z
        values[np.uint64(6 * width + r)] *= rest * ((1.0 - w_hat) * (1.0 + w_hat))
        values[np.uint64(7 * width + r)] = math.floor(values[np.uint64(7 * width + r)])
