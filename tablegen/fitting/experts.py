"""Mixture of experts fitted by expectation-maximisation.

An expert is a linear regression of the outcomes' normal scores x on the features phi of a
condition, with a covariance of its own:

    p(x | phi) = sum_g G_g(phi) sum_s E_gs(phi) N(x; A_gs phi, C_gs),

where G and E, the gates, are softmax functions of linear logits. Regressions and covariances follow
from sums of products, weighted by the shares of an expert in the rebounds. The gates take a damped
Newton step in each iteration. Each gate has its own block of second derivatives, which are computed
again every few iterations.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tablegen.fitting.expectation import (
    Single,
    add_densities,
    add_products,
    find_curvatures,
    find_shares,
    softmax,
)
from tablegen.model.float_array import FloatArray

#: Rows of a block: its shares fit into the cache.
_BLOCK = 512

#: Smaller shares of an expert in a rebound, and smaller curvatures, are left out of sums.
_LEAST_SHARE, _LEAST_CURVATURE = np.float32(1e-3), np.float32(1e-4)

#: Part of the rebounds in the first iterations, and part of those in second derivatives.
_FIRST_PART, _CURVATURE_PART = 0.25, 0.25

#: Iterations on part of the rebounds, on all of them, and between second derivatives.
_FIRST, _LAST, _CURVATURES_EVERY = 10, 3, 3

#: Last iterations in which gates stay, so that no step can lose likelihood unseen.
_SETTLED = 1

#: Regularisation. The diagonal of the normal equations grows by _PULL for each rebound and by
#: _PULL_ROWS in all. Each covariance gets _PRIOR_ROWS rebounds of variance _PRIOR_VARIANCE, and
#: each variance gets _RIDGE.
_PULL, _PULL_ROWS = 1e-3, 3.0
_PRIOR_ROWS, _PRIOR_VARIANCE, _RIDGE = 0.5, 0.05, 1e-4

#: Damping of a Newton step until one loses likelihood, its largest component, and the pull of
#: logits to zero.
_STEP, _LONGEST, _LOGIT_PULL = 0.7, 2.0, 1e-2

#: Rows and iterations of the clusters with which a fit begins.
_CLUSTER_ROWS, _CLUSTER_ITERATIONS = 30_000, 6


class Weight(NamedTuple):
    """Quadratic forms by which errors of the coefficients of each gate and mean count."""

    group: FloatArray  # (g, f, f)
    gate: FloatArray  # (k, f, f)
    mean: FloatArray  # (k, f, f)


@dataclass
class Experts:
    """Experts of g groups, k in all, of o outcomes on f features; factors are lower triangular."""

    group_gate: FloatArray  # (g, f)
    gate: FloatArray  # (k, f)
    mean: FloatArray  # (k, o, f)
    factor: FloatArray  # (k, o, o)
    weight: Weight

    @property
    def outcomes(self) -> int:
        """Number o of outcomes."""
        return self.factor.shape[1]


@dataclass
class Sums:
    """Sums over rebounds: products by expert, gradients of both gates, and log-likelihood."""

    products: FloatArray
    by_group: FloatArray
    by_expert: FloatArray
    likelihood: float = 0.0


class _Block(NamedTuple):
    """Rebounds of a block: shares, probabilities and gradients, (g, n) or (k, n)."""

    vectors: Single
    features: Single
    share: Single
    group: Single
    expert: Single
    by_group: Single
    by_expert: Single
    likelihood: float


def fit_experts(
    phi: FloatArray | Single,
    inputs: FloatArray,
    scores: FloatArray,
    groups: int,
    experts: int,
    rng: np.random.Generator,
) -> tuple[Experts, float]:
    """Fit a mixture of experts to features phi (n, f) and scores (n, o), in random order.

    The first feature is 1. Experts, the same number in each group, begin as random clusters of
    inputs (n, m) and scores. Also returns the mean log-likelihood before the last step.
    """
    vectors, points = (
        np.concatenate([columns, scores], axis=1, dtype=np.float32) for columns in (phi, inputs)
    )
    fitted = _start(vectors, points, (groups, experts, scores.shape[1]), rng)
    part = vectors[: max(math.ceil(_FIRST_PART * len(phi)), min(len(phi), 1000))]
    likelihood, damping = -math.inf, _STEP
    best: tuple[Experts, Sums] | None = None
    for number in range(_FIRST + _LAST):
        rows = part if number < _FIRST else vectors
        sums = expectation(fitted, rows)
        if best and number != _FIRST and sums.likelihood < likelihood * len(rows):
            # the step of the gates was too long: go back, and take half of it
            damping *= 0.5
            fitted, sums = replace(best[0]), best[1]
        else:
            likelihood, best = sums.likelihood / len(rows), (replace(fitted), sums)
        if number % _CURVATURES_EVERY == 0 or number == _FIRST:
            few = rows[: math.ceil(_CURVATURE_PART * len(rows))]
            fitted.weight = _curvatures(fitted, few, len(rows) / len(few))
        _regress(fitted, sums.products)
        if number < _FIRST + _LAST - _SETTLED:
            _move_gates(fitted, sums, len(rows), damping)
    return fitted, likelihood


def _clusters(points: Single, count: int, rng: np.random.Generator) -> Single:
    """Centres of clusters, (count, d), by Lloyd's algorithm."""
    centres = points[rng.choice(len(points), count, replace=len(points) < count)].copy()
    for _ in range(_CLUSTER_ITERATIONS):
        labels = _nearest(points, centres)
        sizes = np.bincount(labels, minlength=count)
        for k in range(points.shape[1]):
            sums = np.bincount(labels, points[:, k], minlength=count)
            centres[:, k] = np.where(sizes > 0, sums / np.maximum(sizes, 1), centres[:, k])
    return centres


def _nearest(points: Single, centres: Single) -> NDArray[np.int64]:
    """Find the nearest centre to each point."""
    squares = np.sum(centres * centres, axis=1)
    blocks = (points[rows] for rows in _slices(points, 8 * _BLOCK))
    return np.concatenate([np.argmin(squares - 2.0 * (b @ centres.T), axis=1) for b in blocks])


def _in_groups(centres: Single, groups: int) -> NDArray[np.int64]:
    """Order of centres that puts near ones into the same of equally large groups."""
    order = np.arange(len(centres))[None]
    while len(order) < groups:
        factor = next(d for d in range(2, groups + 1) if (groups // len(order)) % d == 0)
        parts = []
        for row in order:
            axis = np.argmax(centres[row].var(axis=0))
            parts.append(row[np.argsort(centres[row, axis], kind="stable")].reshape(factor, -1))
        order = np.concatenate(parts)
    return order.ravel()


def _start(
    vectors: Single, points: Single, sizes: tuple[int, int, int], rng: np.random.Generator
) -> Experts:
    """Experts fitted to clusters of conditions and outcomes together."""
    groups, experts, outcomes = sizes
    count, width = groups * experts, vectors.shape[1]
    features = width - outcomes
    centres = _clusters(points[:_CLUSTER_ROWS], count, rng)
    centres = centres[_in_groups(centres, groups)]
    products = np.zeros((count, width, width))
    for rows in _slices(vectors, 8 * _BLOCK):
        labels = _nearest(points[rows], centres)
        share = (labels == np.arange(count)[:, None]).astype(np.float32)
        add_products(share, vectors[rows], np.float32(0.5), products)
    mass = products[:, 0, 0]
    group_gate, gate = np.zeros((groups, features)), np.zeros((count, features))
    by_group = mass.reshape(groups, experts).sum(axis=1)
    group_gate[:, 0] = np.log((by_group + 1.0) / (len(vectors) + groups))
    gate[:, 0] = np.log((mass + 1.0) / np.repeat(by_group + experts, experts))
    mean = np.zeros((count, outcomes, features))
    factor = np.repeat(np.eye(outcomes)[None], count, axis=0)
    weight = Weight(*(np.zeros((n, features, features)) for n in (groups, count, count)))
    fitted = Experts(group_gate, gate, mean, factor, weight)
    _regress(fitted, products)
    return fitted


def _slices(rows: Single, size: int = _BLOCK) -> list[slice]:
    return [slice(start, start + size) for start in range(0, len(rows), size)]


def _blocks(fitted: Experts, vectors: Single) -> Iterator[_Block]:
    """Find the shares of the experts in rebounds, block by block."""
    # matrix from vectors to whitened outcomes, and constants of the log-densities
    inverse = np.linalg.inv(fitted.factor)
    both = np.concatenate([-inverse @ fitted.mean, inverse], axis=2)
    matrix = both.transpose(1, 0, 2).reshape(-1, both.shape[2])
    white = np.ascontiguousarray(matrix, dtype=np.float32)
    diagonal = np.einsum("kii->ki", fitted.factor)
    constant = -np.sum(np.log(diagonal), axis=1) - 0.5 * fitted.outcomes * math.log(2.0 * math.pi)
    constant = constant.astype(np.float32)
    gates = fitted.group_gate.astype(np.float32), fitted.gate.astype(np.float32)
    groups = len(fitted.group_gate)
    for rows in _slices(vectors):
        block = vectors[rows]
        phi = np.ascontiguousarray(block[:, : -fitted.outcomes])
        group, expert = gates[0] @ phi.T, gates[1] @ phi.T
        softmax(group[None])
        softmax(expert.reshape(groups, -1, len(phi)))
        share, by_group, by_expert = (np.empty_like(x) for x in (expert, group, expert))
        add_densities(white @ block.T, constant, share)
        likelihood = find_shares(share, group, expert, by_group, by_expert)
        yield _Block(block, phi, share, group, expert, by_group, by_expert, likelihood)


def expectation(fitted: Experts, vectors: Single) -> Sums:
    """Take the expectation step over vectors (n, f + o) of features and scores."""
    width = vectors.shape[1]
    sums = Sums(
        np.zeros((len(fitted.gate), width, width)),
        np.zeros_like(fitted.group_gate),
        np.zeros_like(fitted.gate),
    )
    for block in _blocks(fitted, vectors):
        add_products(block.share, block.vectors, _LEAST_SHARE, sums.products)
        sums.by_group += block.by_group @ block.features
        sums.by_expert += block.by_expert @ block.features
        sums.likelihood += block.likelihood
    return sums


def _curvatures(fitted: Experts, vectors: Single, scale: float) -> Weight:
    """Sum the second derivatives of both gates, times ``scale``; the weight of means stays."""
    features = fitted.gate.shape[1]
    of_groups = np.zeros((len(fitted.group_gate), features, features))
    of_experts = np.zeros((len(fitted.gate), features, features))
    for block in _blocks(fitted, vectors):
        find_curvatures(block.share, block.group, block.expert, block.by_group, block.by_expert)
        add_products(block.by_group, block.features, _LEAST_CURVATURE, of_groups)
        add_products(block.by_expert, block.features, _LEAST_CURVATURE, of_experts)
    group, gate = (_symmetric(part * scale) for part in (of_groups, of_experts))
    return Weight(group, gate, fitted.weight.mean)


def _symmetric(upper: FloatArray) -> FloatArray:
    """Symmetric matrices from their upper triangles; nothing is below those."""
    return upper + np.triu(upper, 1).transpose(0, 2, 1)


def _regress(fitted: Experts, products: FloatArray) -> None:
    """Set regressions and covariances that maximise the expected likelihood."""
    features = fitted.gate.shape[1]
    outcomes = fitted.outcomes
    moments = _symmetric(products)
    mass = np.maximum(products[:, 0, 0], 1e-9)
    inputs, cross = moments[:, :features, :features], moments[:, features:, :features]
    pull = np.eye(features)
    pull[0, 0] = 0.0
    pulled = inputs + (_PULL * mass + _PULL_ROWS)[:, None, None] * pull + 1e-6 * np.eye(features)
    mean = np.linalg.solve(pulled, cross.transpose(0, 2, 1)).transpose(0, 2, 1)
    rest = moments[:, features:, features:] - mean @ cross.transpose(0, 2, 1)
    rest += mean @ inputs @ mean.transpose(0, 2, 1) - cross @ mean.transpose(0, 2, 1)
    prior = _PRIOR_ROWS * _PRIOR_VARIANCE * np.eye(outcomes)
    covariance = (rest + prior) / (mass + _PRIOR_ROWS)[:, None, None] + _RIDGE * np.eye(outcomes)
    symmetric = 0.5 * (covariance + covariance.transpose(0, 2, 1))
    fitted.weight = fitted.weight._replace(mean=pulled)
    fitted.mean = np.asarray(mean, dtype=np.float64)
    fitted.factor = np.asarray(np.linalg.cholesky(symmetric), dtype=np.float64)


def _move_gates(fitted: Experts, sums: Sums, rows: int, damping: float) -> None:
    """Take a step of both gates; the logits of each softmax keep a mean of zero."""
    groups, count = len(fitted.group_gate), len(fitted.gate)
    top = _stepped(fitted.group_gate, sums.by_group, fitted.weight.group, rows, damping)
    fitted.group_gate = np.subtract(top, top.mean(axis=0))
    moved = _stepped(fitted.gate, sums.by_expert, fitted.weight.gate, rows, damping)
    parts = moved.reshape(groups, count // groups, -1)
    fitted.gate = np.subtract(parts, parts.mean(axis=1, keepdims=True)).reshape(count, -1)


def _stepped(
    gate: FloatArray, gradient: FloatArray, curvature: FloatArray, rows: int, damping: float
) -> FloatArray:
    """Gate after a damped Newton step."""
    floor = max(1e-4 * rows / len(gate), 1.0)
    matrix = curvature + floor * np.eye(gate.shape[1])
    pulled = gradient - _LOGIT_PULL * gate
    step = np.linalg.solve(matrix, pulled[:, :, None])[:, :, 0]
    return gate + damping * np.clip(step, -_LONGEST, _LONGEST)
