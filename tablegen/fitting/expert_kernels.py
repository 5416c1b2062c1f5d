"""Single-precision kernels of a leaf's experts: the steps by which a draw makes normal scores.

Operations are not fused and sums are in a fixed order, as in the C library, so that an expert is
chosen by the same bits.
"""

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import (
    FACTOR_UNIT,
    GATE_UNIT,
    GROUP_SIZE,
    MEAN_UNIT,
    N_FEATURES,
    N_GROUPS,
)
from tablegen.model.jit import inline_kernel

Single = NDArray[np.float32]

_F = np.float32
_HALF, _ONE, _TWO = _F(0.5), _F(1.0), _F(2.0)
_GATE_UNIT, _MEAN_UNIT = _F(1.0 / GATE_UNIT), _F(1.0 / MEAN_UNIT)
_FACTOR_UNIT = _F(1.0 / FACTOR_UNIT)

#: Below 2**-126 a weight counts for nothing, and single precision has other rules.
_LEAST_POWER = _F(-126.0)
_LOG2_E = _F(1.4426950408889634)
#: 2**x on [-1/2, 1/2]: Taylor coefficients of exp(x ln 2), relative error below 3e-7.
_C1, _C2, _C3 = _F(0.6931471805599453), _F(0.2402265069591007), _F(0.05550410866482158)
_C4, _C5, _C6 = _F(0.009618129107628477), _F(0.0013333558146428443), _F(0.00015403530393381608)
_EXPONENT_BIAS, _EXPONENT_SHIFT = np.int32(127), np.uint32(23)

_UNIFORM_SHIFT, _UNIFORM_UNIT = np.uint32(8), _F(2.0**-24)

#: Exponent and first three bits of a float32 number its cubic; those of 1/2 are the first.
_PIECE_SHIFT, _FIRST_PIECE = np.uint32(20), np.int32(126 * 8)
_PIECE_BITS, _MANTISSA, _ONE_BITS = np.uint32(3), np.uint32(0x7FFFFF), np.uint32(0x3F800000)
_SIGN_SHIFT, _DISTANCE = np.uint32(31), np.uint32(0x7FFFFFFF)


@inline_kernel
def exponential(x: np.float32) -> np.float32:
    """Return the exponential of a float32 that is not positive, or 2**-126 if it is smaller."""
    y = max(x * _LOG2_E, _LEAST_POWER)
    n = np.int32(y - _HALF)
    r = y - _F(n)
    p = _ONE + r * (_C1 + r * (_C2 + r * (_C3 + r * (_C4 + r * (_C5 + r * _C6)))))
    bits = np.uint32(n + _EXPONENT_BIAS) << _EXPONENT_SHIFT
    return p * np.uint32(bits).view(np.float32)


@inline_kernel
def normal_of_word(table: Single, word: np.uint32) -> np.float32:
    """Return the standard normal number of a random word, the quantile of (word + 1/2) 2**-32.

    Parameters
    ----------
    table : float32 array, shape (257, 4)
        From `sampler.formats.image.normal_table`.
    word : uint32

    Returns
    -------
    float32
        Odd in the word: w and 2**32 - 1 - w give opposite numbers.
    """
    upper = np.int32(word >> _SIGN_SHIFT)
    half = _F(np.int32((word ^ np.uint32(-upper)) & _DISTANCE)) + _HALF
    bits = np.float32(half).view(np.uint32)
    k = np.uint64(np.int32(bits >> _PIECE_SHIFT) - _FIRST_PIECE)
    place = ((bits << _PIECE_BITS) & _MANTISSA) | _ONE_BITS
    t = np.uint32(place).view(np.float32) - _ONE
    value = table[k, 0] + t * (table[k, 1] + t * (table[k, 2] + t * table[k, 3]))
    return (_ONE - _TWO * _F(upper)) * value


@inline_kernel
def _choose(
    count: int, gates: NDArray[np.int16], base: int, features: Single, first: int, word: np.uint32
) -> int:
    """Choose a number below `count`, by its weight, from the upper 24 bits of a word.

    Parameters
    ----------
    count : int
    gates : int16 array
        At `base` the coefficients of the first feature, `count` side by side, and so on.
    base : int
    features : float32 array
        From `first` on.
    first : int
    word : uint32
    """
    weights = np.zeros(count, dtype=np.float32)
    for row in range(N_FEATURES):
        for k in range(count):
            weights[k] += features[first + row] * _F(gates[base + row * count + k])
    most = weights[0]
    for k in range(1, count):
        most = max(most, weights[k])
    for k in range(count):
        weights[k] = exponential((weights[k] - most) * _GATE_UNIT)
    for k in range(1, count):
        weights[k] += weights[k - 1]
    share = (_F(np.int32(word >> _UNIFORM_SHIFT)) + _HALF) * _UNIFORM_UNIT
    share *= weights[count - 1]
    chosen = 0
    for k in range(count - 1):
        chosen += int(share >= weights[k])
    return chosen


@inline_kernel
def choose_group(
    gates: NDArray[np.int16], base: int, features: Single, first: int, word: np.uint32
) -> int:
    """Choose a group of experts; arguments as of `_choose`."""
    return _choose(N_GROUPS, gates, base, features, first, word)


@inline_kernel
def choose_of_group(
    gates: NDArray[np.int16], base: int, features: Single, first: int, word: np.uint32
) -> int:
    """Choose an expert of a group; arguments as of `_choose`."""
    return _choose(GROUP_SIZE, gates, base, features, first, word)


@inline_kernel
def fill_scores(
    experts: NDArray[np.int16],
    base: int,
    features: Single,
    first: int,
    normals: Single,
    scores: Single,
) -> None:
    """Write the scores of all outcomes: an expert's mean and its factor times normals.

    Its record begins at `base`, features at `first`; normal k of the draw is at ``normals[k]``.
    """
    outcomes = scores.shape[0]
    for k in range(outcomes):
        scores[k] = _F(0.0)
    for row in range(N_FEATURES):
        for k in range(outcomes):
            mean = _F(experts[base + row * outcomes + k])
            scores[k] += features[first + row] * mean
    for k in range(outcomes):
        scores[k] *= _MEAN_UNIT
    for column in range(outcomes):
        normal = normals[column] * _FACTOR_UNIT
        start = base + (N_FEATURES * outcomes + column * outcomes - column * (column + 1) // 2)
        for row in range(column, outcomes):
            scores[row] += _F(experts[start + row]) * normal
