"""The draw: eight random words and a look-up, in constant time.

The law stored at a node (alpha1, V) is a Gaussian-mixture copula with tabulated marginals:

1. the condition becomes a fractional node index on each axis (linear look-up, equal steps);
2. one of the four nodes around it is chosen with the bilinear weights; the dependence between
   the channels is taken from it alone;
3. a mixture component j is chosen by the alias method, in one multiplication and one read; it
   belongs to one class of rebounds, of which everything that follows is taken;
4. z = mean_j + L_j n with six standard normals n;
5. a monotone map sends each variate z to the normal score s of its channel (the mixture's own
   marginal is not normal, so the map starts from it);
6. x = sum over the four nodes of weight times quantile function at s.

Sources: Walker, ACM Trans. Math. Softw. 3 (1977) for aliases; Tewari, Giering & Raghunathan,
ICDM workshops (2011) for mixture copulas; Salmon et al., SC'11 for the random words.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.channels import FIRST_MIRRORED, channels_to_state
from sampler.encoding import MIXTURE_SCALE
from sampler.jit import borrowing_inline_kernel, borrowing_kernel, inline_kernel
from sampler.normal import normal_quantile
from sampler.philox import philox_block, uniform

#: Status codes: zero is fine, positive is a warning, negative an error with nothing written.
OK = 0
CLAMPED = 1
NOT_FINITE = -1
NOT_APPROACHING = -2
SPEED_NOT_POSITIVE = -3
NORMAL_NOT_USABLE = -4
HALF_SIZE_NOT_POSITIVE = -5

#: Random words that one draw consumes: blocks 0 and 1 of its keys.
WORDS_PER_DRAW = 8

N_CHANNELS = 6
_HALF_PI = 0.5 * math.pi
#: Rounding of a unit conversion: an excess below this, relative, is no excess.
_SLACK = 1e-12
#: Unit of the stored means and factors, a power of two: exact.
_MIXTURE_UNIT = 1.0 / MIXTURE_SCALE
_ONE = np.uint32(1)
_LOW = np.uint64(0xFFFFFFFF)
_HALF_WORD = np.uint64(32)


class Axis(NamedTuple):
    """One axis of the node grid, for look-up in constant time.

    Attributes
    ----------
    first, last : float
        Ends of the axis, rad or m/s.
    scale : float
        Steps of the coordinate table per rad or m/s; 0 on an axis of one node.
    coordinate : float64 array, shape (n_grid,)
        Fractional node index at equal steps from `first` to `last`.
    """

    first: float
    last: float
    scale: float
    coordinate: NDArray[np.float64]


class TableArrays(NamedTuple):
    """What the kernels need of a table; may be passed to any ``@numba.njit`` function.

    Attributes
    ----------
    alpha, speed : Axis
        Axes of the node grid: impact angle in rad, impact speed in m/s.
    score_max, score_scale : float
        Knots of the quantile functions: last normal score, knots per unit score.
    variate_max, variate_scale : float
        Knots of the score maps: last variate, knots per unit variate.
    mirror : bool
        Whether draws are reflected in the impact plane at random.
    quantiles : float32 array, shape (n_alpha * n_speed * n_classes * 6, n_knots)
        One row for each channel of each class at each node, as they lie in the file.
    scores : float32 array, shape (n_alpha * n_speed * n_classes * 6, n_map)
    first_of_class : uint16 array, shape (n_alpha, n_speed, n_classes)
    alias_probability : float32 array, shape (n_alpha, n_speed, n_components)
    alias_index : uint16 array, shape (n_alpha, n_speed, n_components)
    mean : int16 array, shape (n_alpha, n_speed, n_components, 6)
        In units of 1/4096, as the factors.
    cholesky : int16 array, shape (n_alpha, n_speed, n_components, 21)
        Lower-triangular factors, rows packed: L00, L10, L11, L20, ...
    """

    alpha: Axis
    speed: Axis
    score_max: float
    score_scale: float
    variate_max: float
    variate_scale: float
    mirror: bool
    quantiles: NDArray[np.float32]
    scores: NDArray[np.float32]
    first_of_class: NDArray[np.uint16]
    alias_probability: NDArray[np.float32]
    alias_index: NDArray[np.uint16]
    mean: NDArray[np.int16]
    cholesky: NDArray[np.int16]


@inline_kernel
def condition_status(alpha1, speed):
    """Negative code if no rebound can have this angle (rad) and speed (m/s), else `OK`."""
    if not (math.isfinite(alpha1) and math.isfinite(speed)):
        return NOT_FINITE
    if alpha1 <= 0.0 or alpha1 > _HALF_PI + _SLACK:
        return NOT_APPROACHING
    if speed <= 0.0:
        return SPEED_NOT_POSITIVE
    return OK


@borrowing_inline_kernel
def is_outside(value, axis):
    """Whether a value lies off the axis by more than the rounding of a unit conversion."""
    return value < axis.first * (1.0 - _SLACK) or value > axis.last * (1.0 + _SLACK)


@borrowing_inline_kernel
def _locate(value, axis, n_nodes):
    """Lower node, upper node and weight of the upper one; outside values go to the end."""
    table = axis.coordinate
    position = (min(max(value, axis.first), axis.last) - axis.first) * axis.scale
    position = min(position, table.size - 1.0)
    k = min(int(position), table.size - 2)
    x = table[k] + (position - k) * (table[k + 1] - table[k])
    # On an axis of one node both neighbours are that node, with x = 0.
    lower = max(min(int(x), n_nodes - 2), 0)
    return lower, min(lower + 1, n_nodes - 1), min(x - lower, 1.0)


@inline_kernel
def _choose_corner(word, t_alpha, t_speed):
    """Corner of the cell, each with its bilinear weight, from the upper 31 bits of a word.

    One uniform number serves both axes: given the outcome of the first choice, its rescaled
    remainder is uniform again.
    """
    c = (np.float64(word >> _ONE) + 0.5) * 2.0**-31
    upper_alpha = c < t_alpha
    c = c / t_alpha if upper_alpha else (c - t_alpha) / (1.0 - t_alpha)
    return upper_alpha, c < t_speed


@borrowing_inline_kernel
def _choose_component(arrays, i, j, word):
    """Mixture component by the alias method.

    The high half of word * n picks the column, the low half is the fraction within it.
    """
    product = np.uint64(word) * np.uint64(arrays.alias_index.shape[2])
    column = np.int64(product >> _HALF_WORD)
    if uniform(np.uint32(product & _LOW)) >= arrays.alias_probability[i, j, column]:
        column = np.int64(arrays.alias_index[i, j, column])
    return column


@borrowing_inline_kernel
def _class_of(arrays, i, j, component):
    """Class of rebounds that a component belongs to."""
    kind = 0
    for k in range(1, arrays.first_of_class.shape[2]):
        if component >= arrays.first_of_class[i, j, k]:
            kind = k
    return kind


@borrowing_inline_kernel
def _fill_normals(words, state):
    """Write one standard normal for each word."""
    for k in range(N_CHANNELS):
        state[k] = normal_quantile(uniform(words[k]))


@borrowing_inline_kernel
def _mix(arrays, i, j, component, sign, state):
    """Replace standard normals n by variates mean + L n, in place; the mirrored ones signed."""
    for row in range(N_CHANNELS - 1, -1, -1):
        # From the last row upwards, so that each row still finds the normals it needs.
        z = np.float64(arrays.mean[i, j, component, row])
        first = row * (row + 1) // 2
        for column in range(row + 1):
            z += np.float64(arrays.cholesky[i, j, component, first + column]) * state[column]
        z *= _MIXTURE_UNIT
        state[row] = sign * z if row >= FIRST_MIRRORED else z


@borrowing_inline_kernel
def _first_row(arrays, i, j, kind):
    """Row of the first channel of a class at a node, among all rows of knots."""
    n_speed, n_classes = arrays.first_of_class.shape[1:]
    return ((i * n_speed + j) * n_classes + kind) * N_CHANNELS


@borrowing_inline_kernel
def _score(arrays, row, variate):
    """Map a variate to its normal score by one node's map; constant beyond the last knots."""
    last = arrays.scores.shape[1] - 1
    position = (variate + arrays.variate_max) * arrays.variate_scale
    position = min(max(position, 0.0), np.float64(last))
    k = min(int(position), last - 1)
    low = np.float64(arrays.scores[row, k])
    high = np.float64(arrays.scores[row, k + 1])
    return low + (position - k) * (high - low)


@borrowing_inline_kernel
def _knot_value(quantiles, row, k, f):
    """Quantile function of one node between knots k and k + 1."""
    low = np.float64(quantiles[row, k])
    return low + f * (np.float64(quantiles[row, k + 1]) - low)


@borrowing_inline_kernel
def _quantile(arrays, rows, t, r, channel, score):
    """Quantile at a normal score, averaged over the four nodes with the bilinear weights."""
    q = arrays.quantiles
    last = q.shape[1] - 1
    position = min(max((score + arrays.score_max) * arrays.score_scale, 0.0), np.float64(last))
    k = min(int(position), last - 1)
    f = position - k
    lower = (1.0 - r) * _knot_value(q, rows[0] + channel, k, f)
    lower += r * _knot_value(q, rows[1] + channel, k, f)
    upper = (1.0 - r) * _knot_value(q, rows[2] + channel, k, f)
    upper += r * _knot_value(q, rows[3] + channel, k, f)
    return (1.0 - t) * lower + t * upper


@borrowing_inline_kernel
def _fill_channels(arrays, cell_alpha, cell_speed, own, kind, state):
    """Replace variates of a class by channels, in place; `own` is the class' row of the maps."""
    i0, i1, t = cell_alpha
    j0, j1, r = cell_speed
    rows = (
        _first_row(arrays, i0, j0, kind),
        _first_row(arrays, i0, j1, kind),
        _first_row(arrays, i1, j0, kind),
        _first_row(arrays, i1, j1, kind),
    )
    for channel in range(N_CHANNELS):
        score = _score(arrays, own + channel, state[channel])
        state[channel] = _quantile(arrays, rows, t, r, channel, score)


@borrowing_kernel
def draw_from_words(arrays, alpha1, speed, w0, w1, w2, w3, w4, w5, w6, w7, state):
    """One rebound from eight given random words; `draw` says what the rest means.

    Kept apart from the generator so that every branch can be tested with scripted words.

    Parameters
    ----------
    arrays : TableArrays
    alpha1, speed : float
        Impact angle from the wall in rad, impact speed in m/s.
    w0, ..., w7 : uint32
        w0: component; w1: reflection (lowest bit) and corner; w2 to w7: normals.
    state : float64 array, shape (6,), written

    Returns
    -------
    int
        `OK`, `CLAMPED` or a negative code.
    """
    status = condition_status(alpha1, speed)
    if status != OK:
        return status
    if is_outside(alpha1, arrays.alpha) or is_outside(speed, arrays.speed):
        status = CLAMPED
    cell_alpha = _locate(alpha1, arrays.alpha, arrays.first_of_class.shape[0])
    cell_speed = _locate(speed, arrays.speed, arrays.first_of_class.shape[1])
    upper_alpha, upper_speed = _choose_corner(w1, cell_alpha[2], cell_speed[2])
    i = cell_alpha[1] if upper_alpha else cell_alpha[0]
    j = cell_speed[1] if upper_speed else cell_speed[0]
    sign = -1.0 if arrays.mirror and (w1 & _ONE) == _ONE else 1.0
    # Chosen before the normals are made, which takes as long as fetching it from memory.
    component = _choose_component(arrays, i, j, w0)
    kind = _class_of(arrays, i, j, component)
    # The caller's array serves as scratch: normals, variates and channels in turn.
    _fill_normals((w2, w3, w4, w5, w6, w7), state)
    _mix(arrays, i, j, component, sign, state)
    own = _first_row(arrays, i, j, kind)
    _fill_channels(arrays, cell_alpha, cell_speed, own, kind, state)
    channels_to_state(state)
    return status


@borrowing_kernel
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
        tangential velocity before impact, y into the gas.

    Returns
    -------
    int
        `OK` (0); `CLAMPED` (1) if the condition lay outside the table and the nearest one on
        its edge was used; else, with nothing written, `NOT_FINITE` (-1), `NOT_APPROACHING`
        (-2: alpha1 outside (0, pi/2]) or `SPEED_NOT_POSITIVE` (-3).
    """
    w0, w1, w2, w3 = philox_block(seed, index, hit, 0)
    w4, w5, w6, w7 = philox_block(seed, index, hit, 1)
    return draw_from_words(arrays, alpha1, speed, w0, w1, w2, w3, w4, w5, w6, w7, state)


@borrowing_inline_kernel
def item(values, k):
    """Element k of an array, or the only element of an array of one."""
    return values[k] if values.size > 1 else values[0]


@borrowing_kernel
def draw_batch(arrays, alpha1, speed, seed, index, hit, states, start, stop):
    """Draw the states of the rows from start to stop; ends at the first error.

    Parameters
    ----------
    arrays : TableArrays
    alpha1, speed : float64 arrays, shape (n,) or (1,)
    seed : uint64
    index : uint64 array, shape (n,) or (1,)
    hit : uint32 array, shape (n,) or (1,)
    states : float64 array, shape (n, 6), rows start to stop written
    start, stop : int

    Returns
    -------
    tuple of four int
        First row with an error (-1: none) and its code; first clamped row (-1: none) and the
        number of clamped rows.
    """
    first_clamped = -1
    clamped = 0
    for k in range(start, stop):
        keys = (seed, item(index, k), item(hit, k))
        status = draw(arrays, item(alpha1, k), item(speed, k), *keys, states[k])
        if status < OK:
            return k, status, first_clamped, clamped
        if status == CLAMPED:
            clamped += 1
            if first_clamped < 0:
                first_clamped = k
    return -1, OK, first_clamped, clamped
