"""Kernels of the expectation steps of `tablegen.fitting.experts` and `tablegen.fitting.mixture`.

Experts are in groups, so the same step is taken twice: with the experts of a group, and with the
groups. The share of choice k in a rebound is the probability that this choice made it,

    share_k = P_k N_k / sum over all choices of P N,

where P is the probability of the gate, and N the density of the choice at the outcomes of the
rebound. The density of a group is the sum of P N over its experts, and the share of an expert in a
rebound is its share in the group times that of the group. The gradient of the log-likelihood with
respect to the logit of a choice is its share minus P; for an expert it is this number times the
share of the group (Jordan and Jacobs, Neural Computation 6 (1994) 181-214).

All numbers are without units. Arrays over n rebounds have single precision, and sums over rebounds
have double. The rebounds are the last axis, (k, n): loops over them then have neither a sum nor a
maximum, and run in vector registers.
"""

import numpy as np
from numpy.typing import NDArray

from tablegen.model.jit import inline_kernel, kernel
from tablegen.model.tile_products import TILE_COLUMNS, TILE_ROWS, write_tile

Single = NDArray[np.float32]

_F = np.float32
_HALF, _ONE, _ZERO = _F(0.5), _F(1.0), _F(0.0)

#: Power of two to which smaller densities, relative to the largest one of a rebound, are raised.
#: Products of two such numbers are not subnormal: processors take a hundred cycles for each number
#: that is.
_LEAST_POWER = _F(-60.0)
#: The same for probabilities of gates. They are larger, so that the expert with the largest density
#: counts, whatever its gates are.
_LEAST_GATE = _F(-30.0)
#: Smaller shares become 0.
_LEAST_SHARE = _F(2.0**-60)
_LOG2_E = _F(1.4426950408889634)
#: Taylor coefficients of 2**x = exp(x ln 2) on [-1/2, 1/2]; the relative error is below 3e-7.
_C1, _C2, _C3 = _F(0.6931471805599453), _F(0.2402265069591007), _F(0.05550410866482158)
_C4, _C5, _C6 = _F(0.009618129107628477), _F(0.0013333558146428443), _F(0.00015403530393381608)
_EXPONENT_BIAS, _EXPONENT_SHIFT = np.int32(127), np.uint32(23)


@inline_kernel
def exponential(x: np.float32, least: np.float32) -> np.float32:
    """Return the exponential of a float32 that is not positive, or 2**least if it is smaller."""
    y = max(x * _LOG2_E, least)
    n = np.int32(y - _HALF)
    r = y - _F(n)
    p = _ONE + r * (_C1 + r * (_C2 + r * (_C3 + r * (_C4 + r * (_C5 + r * _C6)))))
    bits = np.uint32(n + _EXPONENT_BIAS) << _EXPONENT_SHIFT
    return p * np.uint32(bits).view(np.float32)


@kernel
def softmax(logits: Single) -> Single:
    """Turn the logits of k choices, (k, n), into probabilities, in place.

    Returns the logarithms, (n,), of the sums of the exponentials of the logits.
    """
    count = logits.shape[1]
    top, total = np.empty(count, np.float32), np.zeros(count, np.float32)
    top[:] = logits[0]
    for k in range(1, logits.shape[0]):
        row = logits[k]
        for i in range(count):
            top[i] = max(top[i], row[i])
    for k in range(logits.shape[0]):
        row = logits[k]
        for i in range(count):
            row[i] = exponential(row[i] - top[i], _LEAST_GATE)
            total[i] += row[i]
    for i in range(count):
        top[i] += np.log(total[i])
        total[i] = _ONE / total[i]
    for k in range(logits.shape[0]):
        row = logits[k]
        for i in range(count):
            row[i] *= total[i]
    return top


@kernel
def write_log_densities(white: Single, constant: Single, log_density: Single) -> None:
    """Compute the logarithms of the densities of k experts, constant - |white|^2 / 2.

    Parameters
    ----------
    white : (d k, n) float32
        Whitened outcomes, factor^-1 (x - mean): the first outcome by all experts, then the second.
    constant : (k,) float32
    log_density : (k, n) float32
        Output.
    """
    count = constant.size
    for k in range(count):
        out = log_density[k]
        out[:] = constant[k]
        for j in range(k, white.shape[0], count):
            group_part = white[j]
            for i in range(out.size):
                out[i] -= _HALF * group_part[i] * group_part[i]


@kernel
def find_shares(log_density: Single, probability: Single) -> Single:
    """Find the shares of k choices in each rebound.

    Parameters
    ----------
    log_density : (k, n) float32
        Overwritten with the shares. No share is subnormal.
    probability : (k, n) float32
        Probabilities of the choices.

    Returns
    -------
    (n,) float32
        Logarithm of the density of all choices together.
    """
    count = log_density.shape[1]
    top, total = np.empty(count, np.float32), np.zeros(count, np.float32)
    top[:] = log_density[0]
    for k in range(1, log_density.shape[0]):
        share = log_density[k]
        for i in range(count):
            top[i] = max(top[i], share[i])
    for k in range(log_density.shape[0]):
        share, prior = log_density[k], probability[k]
        for i in range(count):
            share[i] = exponential(share[i] - top[i], _LEAST_POWER) * prior[i]
            total[i] += share[i]
    for i in range(count):
        top[i] += np.log(total[i])
        total[i] = _ONE / total[i]
    for k in range(log_density.shape[0]):
        share = log_density[k]
        for i in range(count):
            value = share[i] * total[i]
            share[i] = value if value > _LEAST_SHARE else _ZERO
    return top


@kernel
def weigh_shares(share: Single, probability: Single, group: Single, gradient: Single) -> None:
    """Multiply the shares of k experts in their group by the share of the group.

    Parameters
    ----------
    share : (k, n) float32
        Overwritten with the products. No product is subnormal.
    probability : (k, n) float32
        Probabilities of the experts, given their group.
    group : (n,) float32
        Shares of the group.
    gradient : (k, n) float32
        Output: gradients of the log-likelihood with respect to the logits of the experts.
    """
    for k in range(share.shape[0]):
        row, prior, out = share[k], probability[k], gradient[k]
        for i in range(group.size):
            value = row[i] * group[i]
            row[i] = value if value > _LEAST_SHARE else _ZERO
            out[i] = row[i] - group[i] * prior[i]


@kernel
def add_products(
    weight: Single, vectors: Single, least: np.float32, products: NDArray[np.float64]
) -> None:
    """Add weighted sums of the products v_i v_j, i <= j, for each row of weights.

    Parameters
    ----------
    weight : (k, n) float32
    vectors : (n, d) float32
    least : float32
        Smaller weights are left out.
    products : (k, d, d) float64
        Increased in its upper triangles.
    """
    count, width = vectors.shape
    # the tiles are whole, so vectors get zeros at their end
    rows_width = -(-width // TILE_ROWS) * TILE_ROWS
    columns_width = -(-width // TILE_COLUMNS) * TILE_COLUMNS
    scaled = np.zeros((count, max(rows_width, columns_width)), dtype=np.float32)
    sums = np.empty((rows_width, columns_width), dtype=np.float32)
    rows = np.empty(count, dtype=np.int32)
    for k in range(weight.shape[0]):
        expert_weight = weight[k]
        selected = 0
        for i in range(count):
            rows[selected] = i
            selected += expert_weight[i] >= least
        if selected == 0:
            continue
        for j in range(selected):
            i = rows[j]
            root, vector, row = np.sqrt(expert_weight[i]), vectors[i], scaled[j]
            for a in range(width):
                row[a] = root * vector[a]
        for a in range(0, width, TILE_ROWS):
            # tiles that lie below the diagonal are left out
            for b in range(a // TILE_COLUMNS * TILE_COLUMNS, width, TILE_COLUMNS):
                write_tile(scaled, scaled, selected, a, b, sums)
        out = products[k]
        for a in range(width):
            for b in range(a, width):
                out[a, b] += sums[a, b]
