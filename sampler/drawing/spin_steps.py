"""The arithmetic of the steps of a draw from the spin law, for one draw.

1. The condition: the effective speed V_e, the spin over it, and the mirror image with
   sigma_x >= 0, which stands for both (rebounds know no left and right).
2. The leaf of the shape's tree of conditions.
3. In the leaf, the features: 1, the inputs less the leaf's middle, the products of two conditions.
4. A group of experts, then an expert of it, each with a weight that is the exponential of a linear
   form of the features.
5. Six normal scores: the expert's mean, linear in the features, and its factor times six normals.
6. A bounded monotone function of each score, whose quantiles the leaf has.
7. From the outcomes to the state.

Conditions and states are in double precision, steps 3 to 6 in single precision without fused
operations, so that an expert is chosen by the same bits in every language.
"""

import math

import numpy as np
from numba import types

from sampler.compilation.jit import no_refcount_inline_kernel
from sampler.drawing.intrinsics import local_array, row_summer, single_bits, single_of_bits
from sampler.formats.bounds import (
    EXPERT_STRIDE,
    FACTOR_UNIT,
    GATE_UNIT,
    GROUP_SIZE,
    INERTIA,
    LANES,
    MEAN_UNIT,
    N_CONDITIONS,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_OUTCOMES,
    SCORE_MAX,
)

_F = np.float32
_ZERO, _HALF, _ONE = _F(0.0), _F(0.5), _F(1.0)
_GATE_UNIT, _MEAN_UNIT, _FACTOR_UNIT = (
    _F(1.0 / GATE_UNIT),
    _F(1.0 / MEAN_UNIT),
    _F(1.0 / FACTOR_UNIT),
)
_SCORE_MAX, _PER_SQUARE = _F(SCORE_MAX), _F(1.0 / SCORE_MAX**2)

#: Below 2**-126 a weight counts for nothing, and single precision has other rules.
_LEAST_POWER = _F(-126.0)
_LOG2_E = _F(1.4426950408889634)
#: 2**x on [-1/2, 1/2]: Taylor coefficients of exp(x ln 2), relative error below 3e-7.
_C1, _C2, _C3 = _F(0.6931471805599453), _F(0.2402265069591007), _F(0.05550410866482158)
_C4, _C5, _C6 = _F(0.009618129107628477), _F(0.0013333558146428443), _F(0.00015403530393381608)

#: Where rounding leads to the first knot, or beyond: above it, so that v stays positive.
_LEAST_POSITION = _F(2.0**-20)

#: log2((1 + s) / (1 - s)) on |s| < 0.172: Taylor coefficients, absolute error below 1e-8.
_L1, _L3, _L5 = _F(2.8853900817779268), _F(0.9617966939259757), _F(0.5770780163555854)
_L7, _L9 = _F(0.41219858311113243), _F(0.3205988979753252)
_ROOT_HALF, _MANTISSA = np.uint32(0x3F3504F3), np.uint32(0x7FFFFF)

_UNIFORM_SHIFT, _UNIFORM_UNIT = np.uint32(8), _F(2.0**-24)
_EXPONENT_BIAS, _EXPONENT_SHIFT = np.int32(127), np.uint32(23)
_MEANS = N_FEATURES * N_OUTCOMES


@no_refcount_inline_kernel
def effective_factor(sx, sy, sz):
    """Step 1: V_e over V, of a spin times a/V."""
    return math.sqrt(1.0 + INERTIA * (sx * sx + sy * sy + sz * sz))


@no_refcount_inline_kernel
def power_of_two(y):
    """2**y of a float32 that is not positive, at least 2**-126; no library's."""
    y = max(y, _LEAST_POWER)
    n = np.int32(y - _HALF)
    r = y - _F(n)
    p = _ONE + r * (_C1 + r * (_C2 + r * (_C3 + r * (_C4 + r * (_C5 + r * _C6)))))
    return p * single_of_bits(np.uint32(np.uint32(n + _EXPONENT_BIAS) << _EXPONENT_SHIFT))


@no_refcount_inline_kernel
def exponential(x):
    """Exponential of a float32 that is not positive."""
    return power_of_two(x * _LOG2_E)


@no_refcount_inline_kernel
def logarithm_to_two(x):
    """Logarithm to the base 2 of a positive normal float32; no library's."""
    bits = single_bits(x)
    # the exponent and mantissa of a number in [1 / sqrt(2), sqrt(2))
    shifted = np.uint32(bits - _ROOT_HALF)
    exponent = np.int32(shifted) >> np.int32(23)
    mantissa = single_of_bits(np.uint32((shifted & _MANTISSA) + _ROOT_HALF))
    s = (mantissa - _ONE) / (mantissa + _ONE)
    q = s * s
    return _F(exponent) + s * (_L1 + q * (_L3 + q * (_L5 + q * (_L7 + q * _L9))))


@no_refcount_inline_kernel
def speed_coordinate(spin, effective):
    """Step 1: exp(-k V_e^n), from V_e over its largest value."""
    ratio = logarithm_to_two(_F(effective / spin.speed_last))
    power = power_of_two(min(_F(spin.speed_exponent) * ratio, _ZERO))
    return np.float64(exponential(-_F(spin.speed_scale) * power))


@no_refcount_inline_kernel
def fill_conditions(spin, alpha1, speed, sx, sy, sz, inputs, at):
    """Step 1: write the five conditions and the squared spin; give V_e / V and the sign.

    Parameters
    ----------
    spin : SpinArrays
    alpha1, speed : float
        In rad and m/s; moved to the nearest that the law has.
    sx, sy, sz : float
        Spin times a/V.
    inputs : float64 array
        From `at` on the five conditions, then the square of sigma.
    at : int

    Returns
    -------
    tuple of two float
        V_e / V; -1 if the mirror image was taken, else 1.
    """
    factor = effective_factor(sx, sy, sz)
    turn = -1.0 if sx < 0.0 else 1.0
    tx, ty, tz = turn * sx / factor, turn * sy / factor, sz / factor
    angle = min(max(alpha1, spin.alpha_first), spin.alpha_last)
    effective = min(max(speed * factor, spin.speed_first), spin.speed_last)
    inputs[np.uint64(at)] = math.sqrt(angle)
    inputs[np.uint64(at + 1)] = speed_coordinate(spin, effective)
    inputs[np.uint64(at + 2)] = tx
    inputs[np.uint64(at + 3)] = ty
    inputs[np.uint64(at + 4)] = tz
    inputs[np.uint64(at + 5)] = tx * tx + ty * ty + tz * tz
    return factor, turn


@no_refcount_inline_kernel
def find_leaf(spin, shape, inputs, at):
    """Step 2: leaf of the conditions, from `at` on, in the tree of a shape, a row of the law."""
    node = np.int64(spin.roots[np.uint64(shape)])
    while node >= 0:
        value = inputs[np.uint64(at + np.int64(spin.node_axis[np.uint64(node)]))]
        second = np.int64(value >= spin.node_cut[np.uint64(node)])
        node = np.int64(spin.node_child[np.uint64(2 * node + second)])
    return -1 - node


@no_refcount_inline_kernel
def fill_features(spin, leaf, inputs, at, b_over_a, c_over_b, features, first):
    """Step 3: write the features, from `first` on, of conditions, from `at` on, and ratios."""
    base = np.int64(leaf * (2 * N_INPUTS))
    features[np.uint64(first)] = _ONE
    for k in range(N_INPUTS):
        x = inputs[np.uint64(at + min(k, N_CONDITIONS - 1))]
        if k >= N_CONDITIONS:
            x = b_over_a if k == N_CONDITIONS else c_over_b
        place = np.uint64(base + k)
        distance = _F(x) - spin.inputs[place]
        features[np.uint64(first + 1 + k)] = distance * spin.inputs[place + np.uint64(N_INPUTS)]
    number = first + 1 + N_INPUTS
    for i in range(N_CONDITIONS):
        for j in range(i, N_CONDITIONS):
            product = features[np.uint64(first + 1 + i)] * features[np.uint64(first + 1 + j)]
            features[np.uint64(number)] = product - (_HALF if i == j else _ZERO)
            number += 1


def chooser(count):
    """Make the function that chooses one of `count` by their weights."""
    local_weights = local_array(types.float32, count)
    sum_rows = row_summer(N_FEATURES, count, count)

    @no_refcount_inline_kernel
    def choose(gates, base, features, first, word):
        """Step 4: number below `count`, by its weight, from the upper 24 bits of a word.

        Parameters
        ----------
        gates : int16 array
            At `base` the coefficients of the first feature, `count` side by side, and so on.
        base : int
        features : float32 array
            From `first` on.
        first : int
        word : uint32
        """
        weights = local_weights()
        sum_rows(gates, base, features, first, weights, 0)
        most = weights[0]
        for k in range(1, count):
            most = max(most, weights[np.uint64(k)])
        for k in range(count):
            i = np.uint64(k)
            weights[i] = exponential((weights[i] - most) * _GATE_UNIT)
        for k in range(1, count):
            weights[np.uint64(k)] += weights[np.uint64(k - 1)]
        share = (_F(np.int32(word >> _UNIFORM_SHIFT)) + _HALF) * _UNIFORM_UNIT
        share *= weights[np.uint64(count - 1)]
        chosen = np.int32(0)
        for k in range(count - 1):
            chosen += np.int32(share >= weights[np.uint64(k)])
        return np.int64(chosen)

    return choose


choose_group, choose_of_group = chooser(N_GROUPS), chooser(GROUP_SIZE)
_sum_means = row_summer(N_FEATURES, LANES, N_OUTCOMES)


@no_refcount_inline_kernel
def fill_scores(experts, record, features, first, normals, scores, place):
    """Step 5: write the scores, six and two that mean nothing, from `place` on.

    Features begin at `first`; normal k of the draw is at ``normals[k]``.
    """
    base = np.int64(record * EXPERT_STRIDE)
    _sum_means(experts, base, features, first, scores, place)
    for row in range(LANES):
        scores[np.uint64(place + row)] *= _MEAN_UNIT
    for column in range(N_OUTCOMES):
        normal = normals[np.uint64(column)] * _FACTOR_UNIT
        start = base + (_MEANS + column * N_OUTCOMES - column * (column + 1) // 2)
        for row in range(LANES):
            factor = _F(experts[np.uint64(start + row)])
            scores[np.uint64(place + row)] += factor * (normal if row >= column else _ZERO)


@no_refcount_inline_kernel
def place_among_knots(spin, score):
    """Step 6: knot below the bounded score, and the fraction from it to the next."""
    scale = _F(spin.n_knots - 1) / (_SCORE_MAX + _SCORE_MAX)
    bounded = score / np.sqrt(_ONE + score * score * _PER_SQUARE)
    position = max((bounded + _SCORE_MAX) * scale, _LEAST_POSITION)
    knot = min(np.int32(position), np.int32(spin.n_knots - 2))
    return knot, min(position - _F(knot), _ONE)


@no_refcount_inline_kernel
def outcome_at(spin, function, entry, rest):
    """Step 6: quantile of a function, between its knot at `entry` and the next."""
    low = _F(spin.quantiles[np.uint64(entry)])
    high = _F(spin.quantiles[np.uint64(entry + 1)])
    least, step = spin.spans[np.uint64(2 * function)], spin.spans[np.uint64(2 * function + 1)]
    return least + step * (low + rest * (high - low))


@no_refcount_inline_kernel
def fill_state(outcomes, at, factor, turn, state, place):
    """Step 7: write u, v, w over V and omega_x, omega_y, omega_z times a/V, from `place` on.

    The speed is below V_e whatever the outcomes are, which is all that the energy allows.
    """
    p, q = np.float64(outcomes[np.uint64(at)]), np.float64(outcomes[np.uint64(at + 1)])
    r = np.float64(outcomes[np.uint64(at + 2)])
    scale = factor / math.sqrt(1.0 + (p * p + q * q + r * r))
    state[np.uint64(place)] = p * scale
    state[np.uint64(place + 1)] = q * scale
    state[np.uint64(place + 2)] = turn * r * scale
    state[np.uint64(place + 3)] = turn * factor * np.float64(outcomes[np.uint64(at + 3)])
    state[np.uint64(place + 4)] = turn * factor * np.float64(outcomes[np.uint64(at + 4)])
    state[np.uint64(place + 5)] = factor * np.float64(outcomes[np.uint64(at + 5)])
