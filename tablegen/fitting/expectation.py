"""Kernels of the fit of experts: the expectation step of `tablegen.fitting.experts`.

The share of expert s of group g in a rebound is the probability that this expert made it,

    share_gs = G_g E_gs N_gs / sum over all experts of G E N,

where the gates G and E are probabilities of a group, and of an expert given its group, and N is the
normal density of the expert at the outcomes of the rebound. With the sum over a group of its
shares, share_g, the gradients of the log-likelihood with respect to the logits of the gates are
share_g - G_g and share_gs - share_g E_gs (Jordan and Jacobs, Neural Computation 6 (1994) 181-214).

All numbers are without units. Arrays over n rebounds have single precision, and sums over rebounds
have double. The rebounds are the last axis, (k, n): loops over them then have neither a sum nor a
maximum, and run in vector registers. The k experts of g groups are numbered group by group.
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
#: Least sum of densities times gates, by which shares are divided.
_LEAST_SUM = _F(1e-30)
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
def softmax(logits: NDArray[np.float32]) -> None:
    """Turn the logits of g gates with k choices each, (g, k, n), into probabilities, in place."""
    count = logits.shape[2]
    top, total = np.empty(count, np.float32), np.empty(count, np.float32)
    for g in range(logits.shape[0]):
        top[:] = logits[g, 0]
        for k in range(1, logits.shape[1]):
            row = logits[g, k]
            for i in range(count):
                top[i] = max(top[i], row[i])
        total[:] = _ZERO
        for k in range(logits.shape[1]):
            row = logits[g, k]
            for i in range(count):
                row[i] = exponential(row[i] - top[i], _LEAST_GATE)
                total[i] += row[i]
        for i in range(count):
            total[i] = _ONE / total[i]
        for k in range(logits.shape[1]):
            row = logits[g, k]
            for i in range(count):
                row[i] *= total[i]


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
def find_shares(
    log_density: Single, group: Single, expert: Single, by_group: Single, by_expert: Single
) -> float:
    """Find the shares of the experts in each rebound, and the gradients of the gates.

    Parameters
    ----------
    log_density : (k, n) float32
        Overwritten with the shares. No share is subnormal.
    group, expert : (g, n) and (k, n) float32
        Probabilities of the groups, and of the experts given their group.
    by_group, by_expert : (g, n) and (k, n) float32
        Output: gradients of the log-likelihood with respect to the logits of both gates.

    Returns
    -------
    float
        Log-likelihood of all rebounds.
    """
    groups, (count, size) = group.shape[0], log_density.shape
    group_size, likelihood = count // groups, 0.0
    top, total = np.empty(size, np.float32), np.zeros(size, np.float32)
    top[:] = log_density[0]
    for k in range(1, count):
        share = log_density[k]
        for i in range(size):
            top[i] = max(top[i], share[i])
    for g in range(groups):
        group_part, group_prior = by_group[g], group[g]
        group_part[:] = _ZERO
        for k in range(g * group_size, (g + 1) * group_size):
            share, prior = log_density[k], expert[k]
            for i in range(size):
                value = exponential(share[i] - top[i], _LEAST_POWER) * prior[i]
                share[i] = value if value > _LEAST_SHARE else _ZERO
                group_part[i] += share[i]
        for i in range(size):
            group_part[i] *= group_prior[i]
            total[i] += group_part[i]
    for i in range(size):
        total[i] = max(total[i], _LEAST_SUM)
        likelihood += top[i] + np.log(total[i])
        total[i] = _ONE / total[i]
    for g in range(groups):
        group_part, group_prior = by_group[g], group[g]
        for i in range(size):
            value = group_part[i] * total[i]
            group_part[i] = value if value > _LEAST_SHARE else _ZERO
            top[i] = group_prior[i] * total[i]
        for k in range(g * group_size, (g + 1) * group_size):
            share, prior, out = log_density[k], expert[k], by_expert[k]
            for i in range(size):
                value = share[i] * top[i]
                share[i] = value if value > _LEAST_SHARE else _ZERO
                out[i] = value - group_part[i] * prior[i]
        for i in range(size):
            group_part[i] -= group_prior[i]
    return likelihood


@kernel
def find_curvatures(
    share: Single, group: Single, expert: Single, by_group: Single, by_expert: Single
) -> None:
    """Find the curvatures of the gates in each rebound.

    They are G (1 - G) for a group and share_g E (1 - E) for an expert: minus the second derivatives
    of the expected log-likelihood with respect to the logit itself.

    Parameters
    ----------
    share, group, expert : (k, n), (g, n) and (k, n) float32
        Arrays of `find_shares` after its call.
    by_group, by_expert : (g, n) and (k, n) float32
        The gradients of `find_shares`; overwritten with the curvatures.
    """
    groups, (count, size) = group.shape[0], share.shape
    group_size = count // groups
    for g in range(groups):
        for i in range(size):
            by_group[g, i] += group[g, i]
        group_part = by_group[g]
        for k in range(g * group_size, (g + 1) * group_size):
            for i in range(size):
                by_expert[k, i] = group_part[i] * expert[k, i] * (_ONE - expert[k, i])
        for i in range(size):
            group_part[i] = group[g, i] * (_ONE - group[g, i])


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
    left_width = -(-width // TILE_ROWS) * TILE_ROWS
    right_width = -(-width // TILE_COLUMNS) * TILE_COLUMNS
    left = np.zeros((count, left_width), dtype=np.float32)
    right = np.zeros((count, right_width), dtype=np.float32)
    sums = np.empty((left_width, right_width), dtype=np.float32)
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
            w, vector = expert_weight[i], vectors[i]
            left_row, right_row = left[j], right[j]
            for a in range(width):
                left_row[a] = w * vector[a]
                right_row[a] = vector[a]
        for a in range(0, width, TILE_ROWS):
            # tiles that lie below the diagonal are left out
            for b in range(a // TILE_COLUMNS * TILE_COLUMNS, width, TILE_COLUMNS):
                write_tile(left, right, selected, a, b, sums)
        out = products[k]
        for a in range(width):
            for b in range(a, width):
                out[a, b] += sums[a, b]
