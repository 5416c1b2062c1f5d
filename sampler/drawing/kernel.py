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

A particle that arrives spinning is drawn from the spin law, by `sampler.drawing.spin_draw`.

Conditions, weights and states are in double precision; what lies between random words and
quantiles, steps 4 and 5, is in single precision, which moves a state by less than the 16 bits of a
stored quantile do.

The arithmetic of the steps is in `sampler.drawing.steps`. `sampler.drawing.block` takes one draw
through them here, and a block of draws side by side in `sampler.drawing.batch`. All of it once more
in plain Python, as the executable specification: `tests/sampler/reference_draw.py`.

Sources: Walker, ACM Trans. Math. Softw. 3 (1977) for aliases; Tewari, Giering & Raghunathan,
ICDM workshops (2011) for mixture copulas; Salmon et al., SC'11 for the random words.
"""

import numpy as np
from numba import types

from sampler.compilation.jit import no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.argument_types import (
    check_grain,
    check_hit,
    check_index,
    check_seed,
    check_spin,
    output_of,
)
from sampler.drawing.block import MOST_WORDS, N_VALUES, state_drawer, word_filler
from sampler.drawing.condition_status import status_of
from sampler.drawing.grain import OWN_GRAIN, draw_grain
from sampler.drawing.intrinsics import local_array
from sampler.drawing.spin_draw import draw_with_spin
from sampler.drawing.spin_view import grain_law_of, serves_all, shapes_of
from sampler.errors import OK, SPIN_NOT_GIVEN

_local_index, _local_hit = local_array(types.uint64, 1), local_array(types.uint32, 1)
_local_words = local_array(types.uint32, MOST_WORDS)
_local_condition = local_array(types.float64, 1)
_local_state = local_array(types.float64, N_VALUES)
_fill_words, draw_one = word_filler(1), state_drawer(1)
_check_state = output_of("state")

_NO_SPIN = (0.0, 0.0, 0.0)


@no_refcount_inline_kernel
def _draw_without_spin(arrays, alpha1, speed, seed, index, hit, state):
    """Draw one state of a particle that arrives without spin, from the law of the nodes."""
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


@no_refcount_inline_kernel
def _draw_with_spin(arrays, alpha1, speed, spin, grain, seed, index, hit, state):
    """Draw one state from the spin law; variables that the table leaves out are 0."""
    values = _local_state()
    status = draw_with_spin(arrays, alpha1, speed, spin, grain, seed, index, hit, values)
    if status < OK:
        return status
    for k in range(min(state.size, N_VALUES)):
        state[k] = 0.0
        for column in arrays.columns:
            if column == k:
                state[k] = values[k]
    return status


@no_refcount_inline_kernel
def grain_at(arrays, seed, index, hit):
    """Grain of a particle at a hit; of a table without spin law, which refuses a spin, any."""
    if shapes_of(arrays.spin) == 0:
        return 0.0, 1.0, 1.0
    return draw_grain(grain_law_of(arrays.spin), seed, index, hit)


@no_refcount_kernel
def draw(arrays, alpha1, speed, seed, index, hit, state, spin=None, grain=None):
    """Draw one rebound state; callable from the user's own ``@numba.njit`` code.

    A pure function of its arguments: equal ones give an equal state on any thread, in any order.
    Allocates nothing.

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
        energy and the number of collisions, which draws with a spin leave out.
    spin : tuple of three float, optional
        Angular velocity before the impact times a/V, wall frame: then the rebound is drawn from the
        spin law, also where the spin is zero. None: from the law of particles without spin.
    grain : tuple of three float, optional
        Shape code, b/a and c/b, from the spin law too; for example a fresh one at each hit, from
        `sampler.grain`. None: with a spin, the particle's own, which it keeps from hit to hit.

    Returns
    -------
    int
        `OK` (0); `CLAMPED` (1) if the condition lay outside the table and the nearest one on
        its edge was used; else, with nothing written, `NOT_FINITE` (-1), `NOT_APPROACHING`
        (-2: alpha1 outside (0, pi/2]), `SPEED_NOT_POSITIVE` (-3), `NO_SPIN_LAW` (-9: a spin or a
        grain, for a table without spin law), `GRAIN_NOT_KNOWN` (-10: a grain of a shape that the
        spin law does not have, or of ratios that are none) or `SPIN_NOT_GIVEN` (-11: neither spin
        nor grain, for a table that was loaded with a population: give a spin of zeros).

    Raises
    ------
    numba.TypingError
        While the caller compiles, if a key is no integer or the state no such array.
    """
    _check_state(state)
    check_seed(seed)
    check_index(index)
    check_hit(hit)
    # the compiler leaves out the branches for what is not None
    if spin is None:
        if grain is None:
            if serves_all(arrays.spin):
                return SPIN_NOT_GIVEN
            return _draw_without_spin(arrays, alpha1, speed, seed, index, hit, state)
        check_grain(grain)
        return _draw_with_spin(arrays, alpha1, speed, _NO_SPIN, grain, seed, index, hit, state)
    check_spin(spin)
    if grain is None:
        own = grain_at(arrays, seed, index, OWN_GRAIN)
        return _draw_with_spin(arrays, alpha1, speed, spin, own, seed, index, hit, state)
    check_grain(grain)
    return _draw_with_spin(arrays, alpha1, speed, spin, grain, seed, index, hit, state)


@no_refcount_kernel
def grain(arrays, seed, index, hit):
    """Draw the grain of a particle; callable from the user's own ``@numba.njit`` code.

    Parameters
    ----------
    arrays : TableArrays
    seed, index, hit : int
        As for `draw`. With hit 0 it is the grain that the particle keeps.

    Returns
    -------
    tuple of three float
        Shape code of `sampler.formats.shape_codes`, b/a and c/b. Zeros for a table without spin
        law, which refuses them.
    """
    check_seed(seed)
    check_index(index)
    check_hit(hit)
    if shapes_of(arrays.spin) == 0:
        return 0.0, 0.0, 0.0
    return draw_grain(grain_law_of(arrays.spin), seed, index, hit)
