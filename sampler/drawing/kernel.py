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

The arithmetic of the steps is in `sampler.drawing.steps`. `sampler.drawing.block` takes one draw
through them here, and a block of draws side by side in `sampler.drawing.batch`. All of it once more
in plain Python, as the executable specification: `tests/sampler/reference_draw.py`.

Sources: Walker, ACM Trans. Math. Softw. 3 (1977) for aliases; Tewari, Giering & Raghunathan,
ICDM workshops (2011) for mixture copulas; Salmon et al., SC'11 for the random words.
"""

import math

import numpy as np
from numba import types

from sampler.compilation.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.argument_types import check_hit, check_index, check_seed, output_of
from sampler.drawing.block import MOST_WORDS, N_VALUES, state_drawer, word_filler
from sampler.drawing.intrinsics import local_array
from sampler.errors import CLAMPED, NOT_APPROACHING, NOT_FINITE, OK, SPEED_NOT_POSITIVE
from sampler.formats.table_arrays import ROUNDING

_HALF_PI = 0.5 * math.pi

_local_index, _local_hit = local_array(types.uint64, 1), local_array(types.uint32, 1)
_local_words = local_array(types.uint32, MOST_WORDS)
_local_condition = local_array(types.float64, 1)
_local_state = local_array(types.float64, N_VALUES)
_fill_words, draw_one = word_filler(1), state_drawer(1)
_check_state = output_of("state")


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
        tangential velocity before impact, y into the gas. Variables that the table leaves out
        are 0. An array of shape (8,) also gets the rotational energy over the initial kinetic
        energy and the number of collisions.

    Returns
    -------
    int
        `OK` (0); `CLAMPED` (1) if the condition lay outside the table and the nearest one on
        its edge was used; else, with nothing written, `NOT_FINITE` (-1), `NOT_APPROACHING`
        (-2: alpha1 outside (0, pi/2]) or `SPEED_NOT_POSITIVE` (-3).

    Raises
    ------
    numba.TypingError
        While the caller compiles, if a key is no integer or the state no such array.
    """
    _check_state(state)
    check_seed(seed)
    check_index(index)
    check_hit(hit)
    status = status_of(arrays, alpha1, speed)
    if status < OK:
        return status
    indices, hits, words = _local_index(), _local_hit(), _local_words()
    angles, speeds, values = _local_condition(), _local_condition(), _local_state()
    indices[0], hits[0] = np.uint64(index), np.uint32(hit)
    angles[0], speeds[0] = alpha1, speed
    _fill_words(len(arrays.channels), seed, indices, hits, 0, 1, words)
    draw_one(arrays, words, angles, speeds, values)
    for k in range(min(state.size, N_VALUES)):
        state[k] = values[k]
    return status
