"""Mixture of experts fitted by expectation-maximisation.

An expert is a linear regression of the outcomes' normal scores x on the features phi of a
condition, with a covariance of its own:

    p(x | phi) = sum_g G_g(phi) sum_s E_gs(phi) N(x; A_gs phi, C_gs),

where G and E, the gates, are softmax functions of linear logits. Regressions and covariances follow
from sums of products, weighted by the shares of an expert in the rebounds. The gates take a damped
Newton step in each iteration, each with its own block of the second derivatives, which are found
only now and then.
"""

import math
from dataclasses import dataclass

import numpy as np
from sampler.compilation.side_by_side import go_on

from sampler.formats.bounds import N_OUTCOMES
from tablegen.fitting.expectation import (
    Single,
    add_densities,
    add_products,
    find_curvatures,
    find_shares,
    softmax,
)
from tablegen.model.float_array import FloatArray

#: Rows of a block: what is worked out of it fits into the cache.
_BLOCK = 512

#: Shares of an expert in a rebound, and curvatures, below which they are left out of sums.
_LEAST_SHARE, _LEAST_CURVATURE = 1e-3, 1e-4

#: Share of the rebounds that the first iterations look at, and those that derivatives take.
_FIRST_PART, _CURVATURE_PART = 0.5, 0.25

#: Iterations on part of the rebounds, on all of them, and from one curvature to the next.
_FIRST, _LAST, _CURVATURES_EVERY = 14, 4, 3

#: Regularisation. Features of a regression count as if so much a rebound, and so many rebounds
#: more, had said zero; so many rebounds of such a variance are added to each covariance; each
#: variance has at least the ridge.
_PULL, _PULL_ROWS = 1e-3, 3.0
_PRIOR_ROWS, _PRIOR_VARIANCE, _RIDGE = 0.5, 0.05, 1e-4

#: Share of a Newton step that is taken, its largest length, and the pull of logits to zero.
_STEP, _LONGEST, _LOGIT_PULL = 0.7, 2.0, 1e-2

#: Rows and iterations of the clusters with which a fit begins.
_CLUSTER_ROWS, _CLUSTER_ITERATIONS = 30_000, 6


@dataclass
class Experts:
    """Experts of g groups, k in all, on f features.

    Attributes
    ----------
    group_gate : (g, f) float64
    gate : (k, f) float64
    mean : (k, 6, f) float64
    factor : (k, 6, 6) float64
        Lower triangular.
    """

    group_gate: FloatArray
    gate: FloatArray
    mean: FloatArray
    factor: FloatArray


@dataclass
class _Sums:
    """What an iteration finds."""

    products: FloatArray
    by_group: FloatArray
    by_expert: FloatArray
    likelihood: float = 0.0


def fit_experts(
    phi: FloatArray,
    inputs: FloatArray,
    scores: FloatArray,
    groups: int,
    experts: int,
    rng: np.random.Generator,
) -> tuple[Experts, float]:
    """Fit a mixture of experts.

    Parameters
    ----------
    phi : (n, f) float64
        Features of the conditions in random order; the first is 1.
    inputs : (n, m) float64
        What the features are made of; experts begin as clusters of it and the scores.
    scores : (n, 6) float64
        Normal scores of the outcomes.
    groups, experts : int
        Number of groups, and of experts in each.
    rng : numpy Generator
        Chooses where the experts begin.

    Returns
    -------
    tuple (Experts, mean log-likelihood before the last step)
    """
    vectors = np.ascontiguousarray(np.hstack([phi, scores]), dtype=np.float32)
    features = phi.shape[1]
    points = np.ascontiguousarray(np.hstack([inputs, scores]), dtype=np.float32)
    fitted, products = _start(vectors, points, (groups, experts), rng)
    _regress(fitted, products)
    curvatures = None
    part = vectors[: max(math.ceil(_FIRST_PART * len(phi)), min(len(phi), 1000))]
    likelihood = 0.0
    for number in range(_FIRST + _LAST):
        rows = part if number < _FIRST else vectors
        sums = _expectation(fitted, rows, features)
        if curvatures is None or number % _CURVATURES_EVERY == 0 or number == _FIRST:
            few = rows[: math.ceil(_CURVATURE_PART * len(rows))]
            curvatures = _curvatures(fitted, few, features, len(rows) / len(few))
        _regress(fitted, sums.products)
        _move_gates(fitted, sums, curvatures, len(rows))
        likelihood = sums.likelihood / len(rows)
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


def _nearest(points: Single, centres: Single) -> np.ndarray:
    squares = np.sum(centres * centres, axis=1)
    blocks = (points[s : s + 8 * _BLOCK] for s in range(0, len(points), 8 * _BLOCK))
    return np.concatenate([np.argmin(squares - 2.0 * (b @ centres.T), axis=1) for b in blocks])


def _in_groups(centres: Single, groups: int) -> np.ndarray:
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
    vectors: Single, points: Single, sizes: tuple[int, int], rng: np.random.Generator
) -> tuple[Experts, FloatArray]:
    """Begin with clusters of conditions and outcomes together, and their sums of products."""
    (groups, experts), width = sizes, vectors.shape[1]
    count, features = groups * experts, width - N_OUTCOMES
    centres = _clusters(points[:_CLUSTER_ROWS], count, rng)
    centres = centres[_in_groups(centres, groups)]
    products = np.zeros((count, width * (width + 1) // 2))
    for block in _blocks(vectors):
        labels = _nearest(points[block], centres)
        share = (labels[:, None] == np.arange(count)).astype(np.float32)
        add_products(share, vectors[block], 0.5, products)
    mass = products[:, 0]
    group_gate, gate = np.zeros((groups, features)), np.zeros((count, features))
    by_group = mass.reshape(groups, experts).sum(axis=1)
    group_gate[:, 0] = np.log((by_group + 1.0) / (len(vectors) + groups))
    gate[:, 0] = np.log((mass + 1.0) / np.repeat(by_group + experts, experts))
    mean = np.zeros((count, N_OUTCOMES, features))
    factor = np.repeat(np.eye(N_OUTCOMES)[None], count, axis=0)
    return Experts(group_gate, gate, mean, factor), products


def _blocks(rows: Single) -> list[slice]:
    return [slice(s, min(s + _BLOCK, len(rows))) for s in range(0, len(rows), _BLOCK)]


def _whitening(fitted: Experts) -> tuple[Single, Single]:
    """Matrix that takes vectors to whitened outcomes, and constants of the log-densities."""
    inverse = np.linalg.inv(fitted.factor)
    both = np.concatenate([-inverse @ fitted.mean, inverse], axis=2)
    matrix = both.transpose(2, 1, 0).reshape(both.shape[2], -1)
    diagonal = np.einsum("kii->ki", fitted.factor)
    constant = -np.sum(np.log(diagonal), axis=1) - 0.5 * N_OUTCOMES * math.log(2.0 * math.pi)
    return np.ascontiguousarray(matrix, dtype=np.float32), constant.astype(np.float32)


def _gates(fitted: Experts, phi: Single) -> tuple[Single, Single]:
    """Probabilities of the groups, and of the experts given their group."""
    group = phi @ fitted.group_gate.T.astype(np.float32)
    softmax(group)
    expert = phi @ fitted.gate.T.astype(np.float32)
    softmax(expert.reshape(len(phi) * len(fitted.group_gate), -1))
    return group, expert


def _shares(
    fitted: Experts, white: tuple[Single, Single], rows: Single, features: int
) -> tuple[Single, Single, Single, Single, Single, float]:
    """Shares, probabilities of groups and of experts, gradients of both, and log-likelihood."""
    phi = np.ascontiguousarray(rows[:, :features])
    group, expert = _gates(fitted, phi)
    share = np.empty_like(expert)
    add_densities(rows @ white[0], white[1], share)
    by_group, by_expert = np.empty_like(group), np.empty_like(expert)
    likelihood = find_shares(share, group, expert, by_group, by_expert)
    return share, group, expert, by_group, by_expert, likelihood


def _expectation(fitted: Experts, vectors: Single, features: int) -> _Sums:
    count, width = len(fitted.gate), vectors.shape[1]
    sums = _Sums(
        np.zeros((count, width * (width + 1) // 2)),
        np.zeros_like(fitted.group_gate),
        np.zeros_like(fitted.gate),
    )
    white = _whitening(fitted)
    for number, block in enumerate(_blocks(vectors)):
        if number % 16 == 0:
            go_on()
        rows = vectors[block]
        share, _, _, by_group, by_expert, likelihood = _shares(fitted, white, rows, features)
        add_products(share, rows, _LEAST_SHARE, sums.products)
        phi = rows[:, :features]
        sums.by_group += by_group.T @ phi
        sums.by_expert += by_expert.T @ phi
        sums.likelihood += likelihood
    return sums


def _curvatures(
    fitted: Experts, vectors: Single, features: int, scale: float
) -> tuple[FloatArray, FloatArray]:
    """Blocks (g, f, f) and (k, f, f) of the second derivatives, scaled up to all rebounds."""
    pairs = features * (features + 1) // 2
    found = np.zeros((len(fitted.group_gate), pairs)), np.zeros((len(fitted.gate), pairs))
    white = _whitening(fitted)
    for block in _blocks(vectors):
        rows = vectors[block]
        share, group, expert, by_group, by_expert, _ = _shares(fitted, white, rows, features)
        find_curvatures(share, group, expert, by_group, by_expert)
        phi = np.ascontiguousarray(rows[:, :features])
        add_products(by_group, phi, _LEAST_CURVATURE, found[0])
        add_products(by_expert, phi, _LEAST_CURVATURE, found[1])
    return _square(found[0] * scale, features), _square(found[1] * scale, features)


def _square(packed: FloatArray, size: int) -> FloatArray:
    """Symmetric matrices from their upper triangles, packed by rows."""
    i, j = np.triu_indices(size)
    whole = np.empty((len(packed), size, size))
    whole[:, i, j] = packed
    whole[:, j, i] = packed
    return whole


def _regress(fitted: Experts, products: FloatArray) -> None:
    """Regressions and covariances that maximise the expected likelihood."""
    features = fitted.gate.shape[1]
    moments = _square(products, features + N_OUTCOMES)
    mass = np.maximum(products[:, 0], 1e-9)
    inputs, cross = moments[:, :features, :features], moments[:, features:, :features]
    pull = np.eye(features)
    pull[0, 0] = 0.0
    pulled = inputs + (_PULL * mass + _PULL_ROWS)[:, None, None] * pull + 1e-6 * np.eye(features)
    mean = np.linalg.solve(pulled, cross.transpose(0, 2, 1)).transpose(0, 2, 1)
    rest = moments[:, features:, features:] - mean @ cross.transpose(0, 2, 1)
    rest += mean @ inputs @ mean.transpose(0, 2, 1) - cross @ mean.transpose(0, 2, 1)
    prior = _PRIOR_ROWS * _PRIOR_VARIANCE * np.eye(N_OUTCOMES)
    covariance = (rest + prior) / (mass + _PRIOR_ROWS)[:, None, None] + _RIDGE * np.eye(N_OUTCOMES)
    symmetric = 0.5 * (covariance + covariance.transpose(0, 2, 1))
    fitted.mean = np.asarray(mean, dtype=np.float64)
    fitted.factor = np.asarray(np.linalg.cholesky(symmetric), dtype=np.float64)


def _move_gates(
    fitted: Experts, sums: _Sums, curvatures: tuple[FloatArray, FloatArray], rows: int
) -> None:
    """Take a step of both gates, and let the logits of each softmax have a mean of zero."""
    groups, count = len(fitted.group_gate), len(fitted.gate)
    top = _stepped(fitted.group_gate, sums.by_group, curvatures[0], rows)
    fitted.group_gate = np.subtract(top, top.mean(axis=0))
    moved = _stepped(fitted.gate, sums.by_expert, curvatures[1], rows)
    parts = moved.reshape(groups, count // groups, -1)
    fitted.gate = np.subtract(parts, parts.mean(axis=1, keepdims=True)).reshape(count, -1)


def _stepped(
    gate: FloatArray, gradient: FloatArray, curvature: FloatArray, rows: int
) -> FloatArray:
    """Gate after a damped Newton step."""
    floor = max(1e-4 * rows / len(gate), 1.0)
    matrix = curvature + floor * np.eye(gate.shape[1])
    pulled = gradient - _LOGIT_PULL * gate
    step = np.linalg.solve(matrix, pulled[:, :, None])[:, :, 0]
    return gate + _STEP * np.clip(step, -_LONGEST, _LONGEST)
