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

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tablegen.fitting.tile_products import TILE_COLUMNS, TILE_ROWS, write_tile
from tablegen.model.jit import inline_kernel, kernel

Single = NDArray[np.float32]

#: A group with a smaller share in a rebound is left out there until all groups are computed again.
_LEAST_GROUP_SHARE = np.float32(1e-3)

#: Log-density of a group that is left out.
_LEFT_OUT = np.float32(-1e30)

#: Smaller shares of an expert in a rebound are left out of sums, and so are smaller curvatures.
_LEAST_SUMMED, _LEAST_CURVATURE = np.float32(1e-3), np.float32(1e-4)

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
def _largest(values: Single) -> Single:
    """Find the largest of k values, (k, n), in each rebound."""
    top = values[0].copy()
    for k in range(1, values.shape[0]):
        row = values[k]
        for i in range(top.size):
            top[i] = max(top[i], row[i])
    return top


@kernel
def _normalise(weight: Single, top: Single) -> Single:
    """Divide the weights of k choices, (k, n), by their sums, in place.

    Quotients that would multiply to subnormal numbers become 0. Returns the logarithms of the sums,
    plus ``top``.
    """
    total, log_total = np.zeros_like(top), np.empty_like(top)
    for k in range(weight.shape[0]):
        row = weight[k]
        for i in range(top.size):
            total[i] += row[i]
    for i in range(top.size):
        log_total[i] = top[i] + np.log(total[i])
        total[i] = _ONE / total[i]
    for k in range(weight.shape[0]):
        row = weight[k]
        for i in range(top.size):
            value = row[i] * total[i]
            row[i] = value if value > _LEAST_SHARE else _ZERO
    return log_total


@kernel
def softmax(logits: Single) -> Single:
    """Turn the logits of k choices, (k, n), into probabilities, in place.

    Returns the logarithms, (n,), of the sums of the exponentials of the logits.
    """
    top = _largest(logits)
    for k in range(logits.shape[0]):
        row = logits[k]
        for i in range(top.size):
            row[i] = exponential(row[i] - top[i], _LEAST_GATE)
    return _normalise(logits, top)


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
    top = _largest(log_density)
    for k in range(log_density.shape[0]):
        share, prior = log_density[k], probability[k]
        for i in range(top.size):
            share[i] = exponential(share[i] - top[i], _LEAST_POWER) * prior[i]
    return _normalise(log_density, top)


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


class Coefficients(NamedTuple):
    """Coefficients in single precision that are multiplied with rebounds, group by group."""

    #: (g, f): gate of the groups.
    group_gate: Single
    #: (g, k, f): gates of the k experts of each group.
    gate: Single
    #: (g, o k, f + o): matrices that map features and scores to factor^-1 (x - mean).
    white: Single
    #: (g, k): logarithms of the densities of experts at their means.
    constant: Single


class Sums(NamedTuple):
    """Sums over rebounds, for k experts in g groups."""

    #: (g, n): groups that are computed in each rebound; after the sums, those that have a share.
    near: NDArray[np.bool_]
    #: (k, f + o, f + o): products of features and scores, weighted by the shares of each expert, in
    #: the upper triangles.
    products: NDArray[np.float64]
    #: (g, f) and (k, f): gradients of the log-likelihood with respect to both gates.
    by_group: NDArray[np.float64]
    by_expert: NDArray[np.float64]
    #: (g, f, f) and (k, f, f): minus the second derivatives with respect to each gate alone, in the
    #: upper triangles, over the first ``curved`` rebounds.
    group_curvature: NDArray[np.float64]
    expert_curvature: NDArray[np.float64]
    curved: int = 0
    #: Log-likelihood.
    likelihood: float = 0.0


class _Group(NamedTuple):
    """Experts of a group, in the m rebounds of a block in which the group is computed."""

    #: (m,): numbers of these rebounds in the block.
    rows: NDArray[np.int64]
    #: (m, f + o) and (m, f): features and scores, and features.
    vectors: Single
    features: Single
    #: (k, m): probabilities of the experts, and their shares in the group.
    expert: Single
    share: Single
    #: (m,): logarithms of the densities of the group.
    log_density: Single


@kernel
def _evaluate_group(
    gate: Single, white: Single, constant: Single, block: Single, near: NDArray[np.bool_]
) -> _Group:
    """Compute a group in those rebounds of a block in which it is near, (n,)."""
    rows = np.flatnonzero(near)
    vectors = block[rows]
    features = np.ascontiguousarray(vectors[:, : gate.shape[1]])
    expert = np.dot(gate, features.T)
    softmax(expert)
    share = np.empty_like(expert)
    write_log_densities(np.dot(white, vectors.T), constant, share)
    return _Group(rows, vectors, features, expert, share, find_shares(share, expert))


@kernel
def add_block(
    coefficients: Coefficients, vectors: Single, start: int, stop: int, sums: Sums
) -> float:
    """Add rebounds to the arrays of sums, and forget the groups that have no share in them.

    Threads of Python would wait for each other between the many small steps, so one kernel takes
    all of them.

    Parameters
    ----------
    coefficients : Coefficients
    vectors : (n, f + o) float32
        Features and scores of rebounds.
    start, stop : int
        The rebounds from ``start`` to ``stop`` are added. They count for the second derivatives if
        ``stop`` is at most ``sums.curved``.
    sums : Sums
        Its arrays are increased.

    Returns
    -------
    float
        Log-likelihood of the rebounds.
    """
    groups, each, width = coefficients.gate.shape
    block, near = vectors[start:stop], sums.near[:, start:stop]
    parts = [
        _evaluate_group(
            coefficients.gate[g], coefficients.white[g], coefficients.constant[g], block, near[g]
        )
        for g in range(groups)
    ]
    features = np.ascontiguousarray(block[:, :width])
    probability = np.dot(coefficients.group_gate, features.T)
    softmax(probability)
    share = np.full(probability.shape, _LEFT_OUT)
    for g in range(groups):
        share[g][parts[g].rows] = parts[g].log_density
    likelihood = find_shares(share, probability).astype(np.float64).sum()
    sums.by_group[:] += np.dot(share - probability, features)
    is_curved = stop <= sums.curved
    if is_curved:
        curvature = probability * (_ONE - probability)
        add_products(curvature, features, _LEAST_CURVATURE, sums.group_curvature)
    for g in range(groups):
        part, first, last = parts[g], g * each, (g + 1) * each
        group_share, gradient = share[g][part.rows], np.empty_like(part.share)
        weigh_shares(part.share, part.expert, group_share, gradient)
        add_products(part.share, part.vectors, _LEAST_SUMMED, sums.products[first:last])
        sums.by_expert[first:last] += np.dot(gradient, part.features)
        if is_curved:
            curvature = group_share * (part.expert * (_ONE - part.expert))
            curved = sums.expert_curvature[first:last]
            add_products(curvature, part.features, _LEAST_CURVATURE, curved)
        for i in part.rows:
            near[g, i] = share[g, i] > _LEAST_GROUP_SHARE
    return likelihood
