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

from sampler.compilation.jit import no_refcount_inline_kernel
from sampler.drawing.intrinsics import single_of_bits
from sampler.formats.spin_arrays import EXPERT_STRIDE
from sampler.formats.spin_bounds import (
    FACTOR_UNIT,
    GATE_UNIT,
    INERTIA,
    MEAN_UNIT,
    N_CONDITIONS,
    N_FEATURES,
    N_INPUTS,
    N_OUTCOMES,
    SCORE_MAX,
)
from sampler.formats.table_arrays import LANES

_F = np.float32
_ZERO, _HALF, _ONE = _F(0.0), _F(0.5), _F(1.0)
_GATE_UNIT, _MEAN_UNIT, _FACTOR_UNIT = _F(1.0 / GATE_UNIT), _F(1.0 / MEAN_UNIT), _F(1.0 / FACTOR_UNIT)
_SCORE_MAX, _PER_SQUARE = _F(SCORE_MAX), _F(1.0 / SCORE_MAX**2)

#: Below 2**-126 a weight counts for nothing, and single precision has other rules.
_LEAST_POWER = _F(-126.0)
_LOG2_E = _F(1.4426950408889634)
#: 2**x on [-1/2, 1/2]: Taylor coefficients of exp(x ln 2), relative error below 3e-7.
_C1, _C2, _C3 = _F(0.6931471805599453), _F(0.2402265069591007), _F(0.05550410866482158)
_C4, _C5, _C6 = _F(0.009618129107628477), _F(0.0013333558146428443), _F(0.00015403530393381608)

#: Where rounding leads to the first knot, or beyond: above it, so that v stays positive.
_LEAST_POSITION = _F(2.0**-20)

_UNIFORM_SHIFT, _UNIFORM_UNIT = np.uint32(8), _F(2.0**-24)
_EXPONENT_BIAS, _EXPONENT_SHIFT = np.int32(127), np.uint32(23)
_MEANS = N_FEATURES * N_OUTCOMES


@no_refcount_inline_kernel
def effective_factor(sx, sy, sz):
    """Step 1: V_e over V, of a spin times a/V."""
    return math.sqrt(1.0 + INERTIA * (sx * sx + sy * sy + sz * sz))


@no_refcount_inline_kernel
def fill_conditions(spin, alpha1, speed, sx, sy, sz, inputs):
    """Step 1: write the five conditions and the squared spin; give V_e / V and the sign.

    Parameters
    ----------
    spin : SpinArrays
    alpha1, speed : float
        In rad and m/s; moved to the nearest that the law has.
    sx, sy, sz : float
        Spin times a/V.
    inputs : float64 array
        Conditions at 0 to 4, the square of sigma at 5.

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
    inputs[0] = math.sqrt(angle)
    inputs[1] = math.exp(-spin.speed_coefficient * math.pow(effective, spin.speed_exponent))
    inputs[2], inputs[3], inputs[4] = tx, ty, tz
    inputs[5] = tx * tx + ty * ty + tz * tz
    return factor, turn


@no_refcount_inline_kernel
def find_leaf(spin, shape, inputs):
    """Step 2: leaf of the conditions in the tree of a shape, by its number in the law."""
    node = np.int64(spin.roots[shape])
    while node >= 0:
        value = inputs[np.int64(spin.node_axis[node])]
        second = np.int64(value >= spin.node_cut[node])
        node = np.int64(spin.node_child[2 * node + second])
    return -1 - node


@no_refcount_inline_kernel
def fill_features(spin, leaf, inputs, b_over_a, c_over_b, features):
    """Step 3: write the features of the conditions and ratios in a leaf."""
    base = np.uint64(leaf * (2 * N_INPUTS))
    features[0] = _ONE
    for k in range(N_INPUTS):
        x = inputs[k]
        if k >= N_CONDITIONS:
            x = b_over_a if k == N_CONDITIONS else c_over_b
        place = base + np.uint64(k)
        distance = _F(x) - spin.inputs[place]
        features[1 + k] = distance * spin.inputs[place + np.uint64(N_INPUTS)]
    number = 1 + N_INPUTS
    for i in range(N_CONDITIONS):
        for j in range(i, N_CONDITIONS):
            product = features[1 + i] * features[1 + j]
            features[number] = product - (_HALF if i == j else _ZERO)
            number += 1


@no_refcount_inline_kernel
def exponential(x):
    """Exponential of a float32 that is not positive, 2**-126 or more; no library's."""
    y = max(x * _LOG2_E, _LEAST_POWER)
    n = np.int32(y - _HALF)
    r = y - _F(n)
    p = _ONE + r * (_C1 + r * (_C2 + r * (_C3 + r * (_C4 + r * (_C5 + r * _C6)))))
    return p * single_of_bits(np.uint32(np.uint32(n + _EXPONENT_BIAS) << _EXPONENT_SHIFT))


@no_refcount_inline_kernel
def choose(gates, base, count, features, word, weights):
    """Step 4: number below `count`, by its weight, from the upper 24 bits of a word.

    Parameters
    ----------
    gates : int16 array
        At `base` the coefficients of the first feature, `count` side by side, and so on.
    features : float32 array
    word : uint32
    weights : float32 array, shape (count or more,)
        Room to work in.
    """
    for k in range(count):
        weights[k] = _ZERO
    for f in range(N_FEATURES):
        feature, row = features[f], np.uint64(base + f * count)
        for k in range(count):
            weights[k] += feature * _F(gates[row + np.uint64(k)])
    most = weights[0]
    for k in range(1, count):
        most = max(most, weights[k])
    for k in range(count):
        weights[k] = exponential((weights[k] - most) * _GATE_UNIT)
    total = weights[0]
    for k in range(1, count):
        total += weights[k]
    share = (_F(np.int32(word >> _UNIFORM_SHIFT)) + _HALF) * _UNIFORM_UNIT * total
    chosen, below = np.int64(0), weights[0]
    for k in range(1, count):
        chosen += np.int64(share >= below)
        below += weights[k]
    return chosen


@no_refcount_inline_kernel
def fill_scores(experts, record, features, normals, scores):
    """Step 5: write the six scores, in the first of eight places."""
    base = np.uint64(record * EXPERT_STRIDE)
    for row in range(LANES):
        scores[row] = _ZERO
    for f in range(N_FEATURES):
        feature, start = features[f], base + np.uint64(f * N_OUTCOMES)
        for row in range(LANES):
            scores[row] += feature * _F(experts[start + np.uint64(row)])
    for row in range(LANES):
        scores[row] *= _MEAN_UNIT
    for column in range(N_OUTCOMES):
        normal = normals[column] * _FACTOR_UNIT
        start = base + np.uint64(_MEANS + column * N_OUTCOMES - column * (column + 1) // 2)
        for row in range(LANES):
            factor = _F(experts[start + np.uint64(row)])
            scores[row] += factor * (normal if row >= column else _ZERO)


@no_refcount_inline_kernel
def fill_outcomes(spin, leaf, scores, outcomes):
    """Step 6: write the outcomes that belong to the scores."""
    last = np.int32(spin.n_knots - 2)
    scale = _F(spin.n_knots - 1) / (_SCORE_MAX + _SCORE_MAX)
    for row in range(N_OUTCOMES):
        z = scores[row]
        bounded = z / np.sqrt(_ONE + z * z * _PER_SQUARE)
        position = max((bounded + _SCORE_MAX) * scale, _LEAST_POSITION)
        knot = min(np.int32(position), last)
        rest = min(position - _F(knot), _ONE)
        function = leaf * N_OUTCOMES + row
        entry = np.uint64(function * spin.n_knots + knot)
        low = _F(spin.quantiles[entry])
        high = _F(spin.quantiles[entry + np.uint64(1)])
        span = np.uint64(2 * function)
        steps = low + rest * (high - low)
        outcomes[row] = spin.spans[span] + spin.spans[span + np.uint64(1)] * steps


@no_refcount_inline_kernel
def fill_state(outcomes, factor, turn, state):
    """Step 7: write the state, u, v, w over V and omega_x, omega_y, omega_z times a/V.

    The speed is below V_e whatever the outcomes are, which is all that the energy allows.
    """
    p, q, r = np.float64(outcomes[0]), np.float64(outcomes[1]), np.float64(outcomes[2])
    scale = factor / math.sqrt(1.0 + (p * p + q * q + r * r))
    state[0], state[1], state[2] = p * scale, q * scale, turn * r * scale
    state[3] = turn * factor * np.float64(outcomes[3])
    state[4] = turn * factor * np.float64(outcomes[4])
    state[5] = factor * np.float64(outcomes[5])
