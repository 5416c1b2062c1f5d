"""A spin law as kernels read it: views of the array that `sampler.formats.spin_buffer` packs."""

import numpy as np
from numba import types

from sampler.compilation.jit import no_refcount_inline_kernel
from sampler.drawing.intrinsics import array_viewer
from sampler.formats.bounds import SpinArrays
from sampler.formats.grain_law import GrainLaw
from sampler.formats.spin_buffer import INTEGERS, NUMBERS

_FIRST_REAL = 8 * len(INTEGERS)
_N_REALS = NUMBERS - len(INTEGERS)

_reals, _longs = array_viewer(types.float64), array_viewer(types.int64)
_pairs, _fours = array_viewer(types.float64, 2), array_viewer(types.float64, 4)
_words, _bytes = array_viewer(types.int32), array_viewer(types.int8)
_singles = array_viewer(types.float32)
_shorts = array_viewer(types.int16)


@no_refcount_inline_kernel
def shapes_of(buffer):
    """Give the number of shapes of a spin law; 0 if there is none."""
    return buffer[0]


@no_refcount_inline_kernel
def serves_all(buffer):
    """Whether draws without a spin are from the spin law too."""
    return buffer[2] != 0


@no_refcount_inline_kernel
def _entry(buffer, number):
    """Place and length of an array."""
    at = np.uint64(NUMBERS + 2 * number)
    return buffer, buffer[at], buffer[at + np.uint64(1)]


@no_refcount_inline_kernel
def grain_law_of(buffer):
    """Give the grains of a spin law."""
    return GrainLaw(
        _longs(*_entry(buffer, 0)),
        _reals(*_entry(buffer, 1)),
        _fours(*_entry(buffer, 2)),
        _pairs(*_entry(buffer, 3)),
    )


@no_refcount_inline_kernel
def spin_law_of(arrays):
    """Give the spin law of a table: `SpinArrays`, with two numbers an entry of `ratio_range`."""
    buffer = arrays.spin
    x = _reals(buffer, _FIRST_REAL, _N_REALS)
    return SpinArrays(
        buffer[0],
        buffer[1],
        buffer[2],
        *(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9]),
        grain_law_of(buffer),
        _longs(*_entry(buffer, 4)),
        _pairs(*_entry(buffer, 5)),
        _words(*_entry(buffer, 6)),
        _bytes(*_entry(buffer, 7)),
        _reals(*_entry(buffer, 8)),
        _words(*_entry(buffer, 9)),
        _singles(*_entry(buffer, 10)),
        _shorts(*_entry(buffer, 11)),
        _shorts(*_entry(buffer, 12)),
        arrays.experts,
        _singles(*_entry(buffer, 13)),
        arrays.spin_quantiles,
    )
