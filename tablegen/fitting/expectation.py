"""Kernels of the fit of experts: shares of the experts in each rebound, and weighted sums.

Arrays with one row for each of n rebounds have single precision, and sums have double. Experts are
numbered group by group: k experts in g groups.
"""

import numpy as np
from numpy.typing import NDArray

from tablegen.model.jit import inline_kernel, kernel

Single = NDArray[np.float32]

_F = np.float32
_HALF, _ONE, _ZERO = _F(0.5), _F(1.0), _F(0.0)

#: Below 2**-60 a weight counts for nothing. Products of two weights are then normal numbers:
#: processors take a hundred cycles for each that is not.
_LEAST_POWER = _F(-60.0)
_LOG2_E = _F(1.4426950408889634)
#: 2**x on [-1/2, 1/2]: Taylor coefficients of exp(x ln 2), relative error below 3e-7.
_C1, _C2, _C3 = _F(0.6931471805599453), _F(0.2402265069591007), _F(0.05550410866482158)
_C4, _C5, _C6 = _F(0.009618129107628477), _F(0.0013333558146428443), _F(0.00015403530393381608)
_EXPONENT_BIAS, _EXPONENT_SHIFT = np.int32(127), np.uint32(23)


@inline_kernel
def exponential(x: np.float32) -> np.float32:
    """Return the exponential of a float32 that is not positive, or 2**-60 if it is smaller."""
    y = max(x * _LOG2_E, _LEAST_POWER)
    n = np.int32(y - _HALF)
    r = y - _F(n)
    p = _ONE + r * (_C1 + r * (_C2 + r * (_C3 + r * (_C4 + r * (_C5 + r * _C6)))))
    bits = np.uint32(n + _EXPONENT_BIAS) << _EXPONENT_SHIFT
    return p * np.uint32(bits).view(np.float32)


@kernel
def softmax(logits: Single) -> None:
    """Turn logits (n, k) into probabilities, in place."""
    for i in range(logits.shape[0]):
        row = logits[i]
        top = row[0]
        for k in range(row.size):
            top = max(top, row[k])
        total = _ZERO
        for k in range(row.size):
            row[k] = exponential(row[k] - top)
        for k in range(row.size):
            total += row[k]
        scale = _ONE / total
        for k in range(row.size):
            row[k] *= scale


@kernel
def add_densities(white: Single, constant: Single, log_density: Single) -> None:
    """Compute logarithms of densities (n, k) from whitened outcomes (n, d * k).

    Whitened outcomes, (x - mean) / factor, begin with the first components of all experts.
    """
    count = constant.size
    for i in range(white.shape[0]):
        row, out = white[i], log_density[i]
        for k in range(count):
            out[k] = constant[k]
        for j in range(0, row.size, count):
            part = row[j : j + count]
            for k in range(count):
                out[k] -= _HALF * part[k] * part[k]


@kernel
def find_shares(
    log_density: Single, group: Single, expert: Single, by_group: Single, by_expert: Single
) -> float:
    """Find the shares of the experts in each rebound, and the gradients of the gates.

    Parameters
    ----------
    log_density : (n, k) float32
        Overwritten with the shares.
    group, expert : (n, g) and (n, k) float32
        Probabilities of the groups, and of the experts given their group.
    by_group, by_expert : (n, g) and (n, k) float32
        Output: gradients of the log-likelihood, which is returned, with respect to the logits.
    """
    groups, count = group.shape[1], expert.shape[1]
    each, likelihood = count // groups, 0.0
    for i in range(log_density.shape[0]):
        share, prior = log_density[i], expert[i]
        top = share[0]
        for k in range(count):
            top = max(top, share[k])
        for k in range(count):
            share[k] = exponential(share[k] - top) * prior[k]
        total = _ZERO
        for g in range(groups):
            part = _ZERO
            for k in range(g * each, (g + 1) * each):
                part += share[k]
            by_group[i, g] = part * group[i, g]
            total += by_group[i, g]
        total = max(total, np.float32(1e-30))
        likelihood += top + np.log(total)
        scale = _ONE / total
        for g in range(groups):
            part = by_group[i, g] * scale
            factor = group[i, g] * scale
            by_group[i, g] = part - group[i, g]
            for k in range(g * each, (g + 1) * each):
                share[k] *= factor
                by_expert[i, k] = share[k] - part * prior[k]
    return likelihood


@kernel
def find_curvatures(
    share: Single, group: Single, expert: Single, by_group: Single, by_expert: Single
) -> None:
    """Find diagonal second derivatives of minus the log-likelihood with respect to the logits.

    The parameters are those of `find_shares` after its call; ``by_group`` and ``by_expert`` are
    overwritten.
    """
    groups, count = group.shape[1], expert.shape[1]
    each = count // groups
    for i in range(share.shape[0]):
        for g in range(groups):
            part = _ZERO
            for k in range(g * each, (g + 1) * each):
                part += share[i, k]
            by_group[i, g] = group[i, g] * (_ONE - group[i, g])
            for k in range(g * each, (g + 1) * each):
                by_expert[i, k] = part * expert[i, k] * (_ONE - expert[i, k])


@kernel
def add_products(
    weight: Single, vectors: Single, least: float, products: NDArray[np.float64]
) -> None:
    """Add sums of v_i v_j, i <= j, with each column of weights to products (k, d (d + 1) / 2).

    Weights (n, k) below the least are left out; vectors are (n, d).
    """
    size = products.shape[1]
    one = np.empty(size, dtype=np.float32)
    for i in range(weight.shape[0]):
        place = 0
        for a in range(vectors.shape[1]):
            v = vectors[i, a]
            for b in range(a, vectors.shape[1]):
                one[place] = v * vectors[i, b]
                place += 1
        for k in range(weight.shape[1]):
            w = weight[i, k]
            if w >= least:
                row = products[k]
                for m in range(size):
                    row[m] += w * one[m]
