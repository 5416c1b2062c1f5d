"""The draw: a few random words and a look-up, in constant time.

The law stored at a node (alpha1, V) is a Gaussian-mixture copula with tabulated marginals:

1. the condition becomes a fractional node index on each axis (linear look-up, equal steps);
2. one of the four nodes around it is chosen with the bilinear weights; the dependence between
   the channels is taken from it alone;
3. a mixture component j is chosen by the alias method, in one multiplication and one read; it
   belongs to one class of rebounds, of which everything that follows is taken;
4. z = mean_j + L_j n with standard normals n, reflected in the impact plane with probability p_j;
5. x = sum over the four nodes of weight times the quantile that belongs there to the variate z of
   the channel.

Conditions, weights and states are in double precision; what lies between random words and
quantiles, steps 4 and 5, is in single precision, which moves a state by less than the 16 bits of a
stored quantile do.

These are the steps of one draw. `sampler.drawing.batch` takes many draws through them side by side.

Sources: Walker, ACM Trans. Math. Softw. 3 (1977) for aliases; Tewari, Giering & Raghunathan,
ICDM workshops (2011) for mixture copulas; Salmon et al., SC'11 for the random words.
"""

import math

import numpy as np
from numba import types

from sampler.compilation.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.intrinsics import local_array, mean_of_corners, mix_rows
from sampler.drawing.normal import normal_of_word
from sampler.drawing.philox import philox_block
from sampler.drawing.states import channels_to_state
from sampler.errors import CLAMPED, NOT_APPROACHING, NOT_FINITE, OK, SPEED_NOT_POSITIVE
from sampler.formats.channels import CHANNELS, END_MIRRORED, FIRST_MIRRORED
from sampler.formats.fixed_point import MIXTURE_SCALE
from sampler.formats.table_arrays import LANES, ROUNDING

#: Most random words that one draw consumes: all of blocks 0 and 1 of its keys, which make six
#: normals, and two words of block 2 for scenes with further channels.
MOST_WORDS = 10

N_VALUES = len(CHANNELS)
_HALF_PI = 0.5 * math.pi
#: Unit of the stored means and factors, a power of two: exact.
UNIT = np.float32(1.0 / MIXTURE_SCALE)
ZERO = np.float32(0.0)
#: Bits of word 1 that decide on reflection; the others choose the node.
REFLECTION_BITS = np.uint32(MIXTURE_SCALE - 1)
_CORNER_SHIFT = np.uint32(12)
CORNER_UNIT = 2.0**-20
_LOW = np.uint64(0xFFFFFFFF)
_HALF_WORD = np.uint64(32)
_HALF = np.uint32(16)
_LOW_HALF = np.uint32(0xFFFF)

#: An array for the channels of one draw.
local_values = local_array(types.float64, N_VALUES)

#: Arrays for its rows, for units without and with reflection, for weights of the four nodes.
local_singles = local_array(types.float32, LANES)
local_entries = local_array(types.int32, LANES)
local_units = local_array(types.float32, 2 * LANES)
local_corners = local_array(types.float32, 4)


@inline_kernel
def condition_status(alpha1, speed):
    """Negative code if no rebound can have this angle (rad) and speed (m/s), else `OK`."""
    if not (math.isfinite(alpha1) and math.isfinite(speed)):
        return NOT_FINITE
    if alpha1 <= 0.0 or alpha1 > _HALF_PI + ROUNDING:
        return NOT_APPROACHING
    if speed <= 0.0:
        return SPEED_NOT_POSITIVE
    return OK


@no_refcount_inline_kernel
def is_outside(value, axis):
    """Whether a value lies off the axis by more than the rounding of a unit conversion."""
    return value < axis.low or value > axis.high


@no_refcount_inline_kernel
def status_of(arrays, alpha1, speed):
    """`OK`, `CLAMPED` or the negative code of a condition."""
    alpha, velocity = arrays.alpha, arrays.speed
    # true for what is most common, false for NaN
    inside = alpha.low <= alpha1 <= alpha.high and velocity.low <= speed <= velocity.high
    if inside:
        return OK
    status = condition_status(alpha1, speed)
    return CLAMPED if status == OK else status


@no_refcount_inline_kernel
def locate(value, axis):
    """Lower node, upper node and weight of the upper one; outside values go to the end."""
    table = axis.coordinate
    position = (min(max(value, axis.first), axis.last) - axis.origin) * axis.scale
    position = min(max(position, 0.0), table.size - 1.0)
    k = min(int(position), table.size - 2)
    below = table[np.uint64(k)]
    x = below + (position - k) * (table[np.uint64(k + 1)] - below)
    # On an axis of one node both neighbours are that node, with weight 0 for the upper one.
    lower = max(min(int(x) - axis.offset, axis.nodes - 2), 0)
    upper = min(lower + 1, axis.nodes - 1)
    # the ends of an axis are nodes, but their coordinate is rounded
    return lower, upper, min(max(x - (lower + axis.offset), 0.0), 1.0 * (upper - lower))


@inline_kernel
def corner_weights(t, r):
    """Bilinear weights of the four nodes of a cell, in the order of `TableArrays.quantiles`."""
    return (1.0 - t) * (1.0 - r), (1.0 - t) * r, t * (1.0 - r), t * r


@inline_kernel
def choose_corner(word, weights):
    """Corner of the cell, each with its bilinear weight, from the upper 20 bits of a word."""
    c = (np.float64(word >> _CORNER_SHIFT) + 0.5) * CORNER_UNIT
    w0, w1, w2, _ = weights
    upper_alpha = c >= w0 + w1
    return upper_alpha, c >= (w0 + w1 + w2 if upper_alpha else w0)


@no_refcount_inline_kernel
def choose_component(arrays, node, word):
    """Mixture component of a node by the alias method.

    The high half of word * n picks the column, the low half is the fraction within it.
    """
    product = np.uint64(word) * np.uint64(arrays.n_components)
    column = np.int64(product >> _HALF_WORD)
    entry = arrays.alias[np.uint64(node * arrays.n_components + column)]
    if (np.uint32(product & _LOW) >> _HALF) >= (entry >> _HALF):
        column = np.int64(entry & _LOW_HALF)
    return column


@no_refcount_inline_kernel
def class_of(arrays, node, component):
    """Class of rebounds that a component belongs to."""
    kind = 0
    for k in range(1, arrays.n_classes):
        if component >= arrays.first_of_class[np.uint64(node * arrays.n_classes + k)]:
            kind = k
    return kind


@no_refcount_inline_kernel
def choose(arrays, cell_alpha, cell_speed, weights, w0, w1):
    """Take steps 2 and 3.

    Returns
    -------
    tuple of two int
        First number of the component's record; first function of its class among the quantile
        functions of the cell.
    """
    i0, i1, _ = cell_alpha
    j0, j1, _ = cell_speed
    upper_alpha, upper_speed = choose_corner(w1, weights)
    node = (i1 if upper_alpha else i0) * arrays.speed.nodes + (j1 if upper_speed else j0)
    component = choose_component(arrays, node, w0)
    kind = class_of(arrays, node, component)
    record = (node * arrays.n_components + component) * arrays.stride
    cell = i0 * max(arrays.speed.nodes - 1, 1) + j0
    return record, (cell * arrays.n_classes + kind) * arrays.n_marginals


@no_refcount_inline_kernel
def mix(arrays, record, w1, words, variates):
    """Take step 4: variates mean + L n of all rows, reflected or not."""
    normals, units = local_singles(), local_units()
    for row in range(LANES):
        units[row] = units[LANES + row] = UNIT
    for row in range(len(arrays.channels)):
        normals[row] = normal_of_word(arrays.normals, words[row])
        if FIRST_MIRRORED <= arrays.channels[row] < END_MIRRORED:
            units[LANES + row] = -UNIT
    reflected = np.int32(w1 & REFLECTION_BITS) < np.int32(arrays.components[np.uint64(record)])
    turn = LANES if reflected else 0
    mix_rows(arrays.components, record, arrays.channels, normals, 0, 1, units, turn, variates, 0)


@no_refcount_inline_kernel
def find_entries(arrays, functions, variates, entries):
    """Replace variates by fractions between knots, in place, and write where step 5 reads.

    Parameters
    ----------
    functions : int
        First function of the class among the quantile functions of the cell.
    variates : float32 array, shape (8,), changed in place
    entries : int32 array, shape (8,), written
        First of the eight numbers that step 5 reads for each channel.
    """
    last = np.float32(arrays.n_knots - 1)
    most, scale = np.float32(arrays.variate_max), np.float32(arrays.variate_scale)
    for row in range(len(arrays.channels)):
        position = min(max((variates[row] + most) * scale, ZERO), last)
        k = min(int(position), arrays.n_knots - 2)
        # a channel without quantiles reads those of another, to no end
        function = functions + max(arrays.marginals[row], 0)
        entries[row] = np.int32((function * arrays.n_knots + k) * 4)
        variates[row] = position - np.float32(k)


@no_refcount_inline_kernel
def state_of(arrays, functions, weights, entries, fractions, state):
    """Take step 5 for every channel, then make the components of the state.

    Parameters
    ----------
    entries, fractions : int32 and float32 arrays, shape (8,)
        From `find_entries`.
    weights : tuple of four float
    state : float64 array, shape (8,), written
    """
    corners, means = local_corners(), local_singles()
    corners[0], corners[1] = np.float32(weights[0]), np.float32(weights[1])
    corners[2], corners[3] = np.float32(weights[2]), np.float32(weights[3])
    mean_of_corners(arrays.quantiles, arrays.channels, entries, fractions, corners, 0, means)
    for k in range(N_VALUES):
        state[k] = 0.0
    for row in range(len(arrays.channels)):
        marginal = arrays.marginals[row]
        if marginal >= 0:
            span = np.uint64(2 * (functions + marginal))
            least, step = arrays.spans[span], arrays.spans[span + np.uint64(1)]
            state[arrays.channels[row]] = least + step * np.float64(means[row])
    channels_to_state(state)


@no_refcount_kernel
def draw_from_words(arrays, alpha1, speed, w0, w1, words, state):
    """One rebound from given random words; `draw` says what the rest means.

    Kept apart from the generator so that every branch can be tested with scripted words.

    Parameters
    ----------
    arrays : TableArrays
    alpha1, speed : float
        Impact angle from the wall in rad, impact speed in m/s.
    w0, w1 : uint32
        w0: component; w1: reflection (lower 12 bits) and corner.
    words : tuple of eight uint32
        Normals; as many are used as the table has channels.
    state : float64 array, shape (6,) or more, written

    Returns
    -------
    int
        `OK`, `CLAMPED` or a negative code.
    """
    status = status_of(arrays, alpha1, speed)
    if status < OK:
        return status
    cell_alpha, cell_speed = locate(alpha1, arrays.alpha), locate(speed, arrays.speed)
    weights = corner_weights(cell_alpha[2], cell_speed[2])
    record, functions = choose(arrays, cell_alpha, cell_speed, weights, w0, w1)
    variates, entries, values = local_singles(), local_entries(), local_values()
    mix(arrays, record, w1, words, variates)
    find_entries(arrays, functions, variates, entries)
    state_of(arrays, functions, weights, entries, variates, values)
    for k in range(min(state.size, N_VALUES)):
        state[k] = values[k]
    return status


@no_refcount_kernel
def draw(arrays, alpha1, speed, seed, index, hit, state):
    """Draw one rebound state; callable from the user's own ``@numba.njit`` code.

    A pure function of its arguments: equal (arrays, alpha1, speed, seed, index, hit) give an
    equal state on any thread, in any order. Allocates nothing.

    Parameters
    ----------
    arrays : TableArrays
        ``table.arrays`` of a loaded table.
    alpha1 : float
        Impact angle in rad from the wall, in (0, pi/2].
    speed : float
        Impact speed V in m/s, > 0.
    seed, index : int
        Seed of the run and identity of the particle, read as uint64.
    hit : int
        How many walls the particle has met before, read as uint32.
    state : float64 array, shape (6,), written
        u, v, w over V and omega_x, omega_y, omega_z times a/V in the wall frame: x along the
        tangential velocity before impact, y into the gas. Components that the table leaves out
        are 0. An array of shape (8,) also gets the rotational energy over the initial kinetic
        energy and the number of collisions.

    Returns
    -------
    int
        `OK` (0); `CLAMPED` (1) if the condition lay outside the table and the nearest one on
        its edge was used; else, with nothing written, `NOT_FINITE` (-1), `NOT_APPROACHING`
        (-2: alpha1 outside (0, pi/2]) or `SPEED_NOT_POSITIVE` (-3).
    """
    n = len(arrays.channels)
    zero = np.uint32(0)
    w0, w1, w2, w3 = philox_block(seed, index, hit, 0)
    w4, w5, w6, w7 = philox_block(seed, index, hit, 1) if n > 2 else (zero, zero, zero, zero)
    _, w8, w9, _ = philox_block(seed, index, hit, 2) if n > 6 else (zero, zero, zero, zero)
    words = (w2, w3, w4, w5, w6, w7, w8, w9)
    return draw_from_words(arrays, alpha1, speed, w0, w1, words, state)
