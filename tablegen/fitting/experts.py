"""Fit a mixture of experts to rebounds by expectation-maximisation (EM).

An expert is a linear regression of the normal scores x of outcomes on the features phi of a
condition, with a covariance of its own. The experts are in groups:

    p(x | phi) = sum_g G_g(phi) sum_s E_gs(phi) N(x; A_gs phi, C_gs).

The gates G and E are softmax functions of linear logits: G is the probability of a group, and E
that of an expert in its group (Jordan and Jacobs, Neural Computation 6 (1994) 181-214). A draw
evaluates the logits of the groups and of the experts of one group, not those of all experts.

In each iteration the regressions and covariances follow from sums of products over rebounds,
weighted by the share of the expert in each rebound (`tablegen.fitting.expectation`). The gates take
a damped Newton step. The second derivatives are those of each gate alone.

The slowest rebounds of a condition decide where grains come to rest, but a mixture that is fitted
by its likelihood loses what is rare. So a class of slow rebounds is made by a group of its own,
which makes no other ones: its probability is that of the group, and no expert has to reach it by
its tail (EXPERIMENTS.md, "Slow classes, and three numbers of the spin").

Two or three groups of eight have a share in a rebound. So every few iterations all groups are
computed in each rebound, with the second derivatives, and in the iterations between only the groups
that had a share. EXPERIMENTS.md ("Time of a fit") has the measurements behind the constants.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tablegen.fitting.expectation import Coefficients, Single, Sums, add_block, add_products
from tablegen.model.float_array import FloatArray

#: Rows of a block: the shares of a group fit into the cache.
_BLOCK = 512

#: Share of the rebounds in first iterations, and share of these again in second derivatives.
_FIRST_SHARE, _CURVATURE_SHARE = 0.25, 0.25

#: Iterations on a share of the rebounds, and iterations on all of them. All groups and second
#: derivatives are computed in each _ALL_GROUPS_EVERY-th of the first iterations, and where the last
#: ones begin.
_FIRST_ITERATIONS, _LAST_ITERATIONS, _ALL_GROUPS_EVERY = 10, 3, 3

#: Last iterations in which the gates do not move: no later iteration would notice if a step lost
#: likelihood.
_ITERATIONS_WITH_FIXED_GATES = 1

#: Regularisation. The diagonal of the normal equations of an expert grows by _PULL for each rebound
#: and by _PULL_ROWS once. Its covariance gets _PRIOR_ROWS more rebounds of variance
#: _PRIOR_VARIANCE, and each variance grows by _RIDGE.
_PULL, _PULL_ROWS = 1e-3, 3.0
_PRIOR_ROWS, _PRIOR_VARIANCE, _RIDGE = 0.5, 0.05, 1e-4

#: Factor of a Newton step, which is halved when a step loses likelihood; the largest change of a
#: coefficient before this factor; and the pull of coefficients to zero.
_FIRST_DAMPING, _LARGEST_STEP, _LOGIT_PULL = 0.7, 2.0, 1e-2

#: Rebounds and iterations of the search for the clusters with which experts begin.
_CLUSTER_ROWS, _CLUSTER_ITERATIONS = 30_000, 6


class Weight(NamedTuple):
    """Quadratic forms of the errors of coefficients: what an error costs in log-likelihood."""

    #: (g, f, f): coefficients of the gate of each group.
    group: FloatArray
    #: (k, f, f): coefficients of the gate of each expert.
    gate: FloatArray
    #: (k, f, f): coefficients of the mean of each expert.
    mean: FloatArray


@dataclass
class Experts:
    """Mixture of k experts in g groups, for o outcomes and f features."""

    #: (g, f): coefficients of the logits of groups.
    group_gate: FloatArray
    #: (k, f): coefficients of the logits of experts in their groups.
    gate: FloatArray
    #: (k, o, f): coefficients of means.
    mean: FloatArray
    #: (k, o, o): lower triangular factors of covariances.
    factor: FloatArray
    weight: Weight

    @property
    def outcomes(self) -> int:
        """Number o of outcomes."""
        return self.factor.shape[1]


def fit_experts(
    vectors: Single,
    input_count: int,
    outcome_count: int,
    groups: int,
    experts: int,
    slow: NDArray[np.int64],
    rng: np.random.Generator,
) -> tuple[Experts, float]:
    """Fit a mixture of experts to rebounds in random order.

    Parameters
    ----------
    vectors : (n, f + o) float32
        Features, then normal scores of the outcomes. The features are 1, the standardised inputs,
        and products of them.
    input_count, outcome_count : int
        Numbers of inputs and of outcomes. The experts begin as clusters of both together.
    groups, experts : int
        Number of groups, and of experts in each group.
    slow : (n,) int64
        Class of each rebound. Group k - 1 makes the rebounds of class k alone, and the groups after
        the last class make those of class 0. A single group makes all rebounds.
    rng : numpy.random.Generator
        Chooses the points at which clusters begin.

    Returns
    -------
    fitted : Experts
    likelihood : float
        Mean log-likelihood before the last step.
    """
    classes = min(int(slow.max()), groups - 1)
    slow = np.where(slow > classes, 0, slow)
    made = np.minimum(np.arange(groups) + 1, classes + 1) % (classes + 1)
    allowed = slow == made[:, None]
    fitted = _initial_experts(vectors, input_count, outcome_count, experts, allowed, classes, rng)
    part = vectors[: max(math.ceil(_FIRST_SHARE * len(vectors)), min(len(vectors), 1000))]
    likelihood, damping = -math.inf, _FIRST_DAMPING
    best: tuple[Experts, Sums] | None = None
    near = np.empty((groups, 0), dtype=bool)
    for number in range(_FIRST_ITERATIONS + _LAST_ITERATIONS):
        rows = part if number < _FIRST_ITERATIONS else vectors
        if number < _FIRST_ITERATIONS and number % _ALL_GROUPS_EVERY == 0:
            near = near[:, :0]
        # all groups are computed in rebounds that are new
        new = len(rows) - near.shape[1]
        near = np.concatenate([near, allowed[:, near.shape[1] : len(rows)]], axis=1)
        curved = math.ceil(_CURVATURE_SHARE * len(rows)) if new else 0
        sums = expectation(fitted, rows, near, curved)
        near = sums.near
        if best and number != _FIRST_ITERATIONS and sums.likelihood < likelihood * len(rows):
            # The last step of the gates was too long: go back to the state before it, and take a
            # step that is half as long.
            damping *= 0.5
            fitted, sums = replace(best[0]), best[1]
        else:
            likelihood, best = sums.likelihood / len(rows), (replace(fitted), sums)
        if sums.curved:
            scale = len(rows) / sums.curved
            group, gate = sums.group_curvature * scale, sums.expert_curvature * scale
            fitted.weight = Weight(_symmetric(group), _symmetric(gate), fitted.weight.mean)
        _regress(fitted, sums.products)
        if number < _FIRST_ITERATIONS + _LAST_ITERATIONS - _ITERATIONS_WITH_FIXED_GATES:
            _move_gates(fitted, sums, len(rows), damping)
    return fitted, likelihood


def _clusters(points: Single, count: int, rng: np.random.Generator) -> Single:
    """Find the centres of clusters, (count, d), by Lloyd's algorithm."""
    centres = points[rng.choice(len(points), count, replace=len(points) < count)].copy()
    for _ in range(_CLUSTER_ITERATIONS):
        labels = _nearest_centres(points, centres)
        sizes = np.bincount(labels, minlength=count)
        for k in range(points.shape[1]):
            sums = np.bincount(labels, points[:, k], minlength=count)
            centres[:, k] = np.where(sizes > 0, sums / np.maximum(sizes, 1), centres[:, k])
    return centres


def _nearest_centres(points: Single, centres: Single) -> NDArray[np.int64]:
    """Find the number of the centre that is nearest to each point, (n,)."""
    squares = np.sum(centres * centres, axis=1)
    blocks = (points[rows] for rows in _slices(points, 8 * _BLOCK))
    return np.concatenate([np.argmin(squares - 2.0 * (b @ centres.T), axis=1) for b in blocks])


def _order_by_group(centres: Single, groups: int) -> NDArray[np.int64]:
    """Order centres, so that those of each of equally large groups are near each other."""
    order = np.arange(len(centres))[None]
    while len(order) < groups:
        factor = next(d for d in range(2, groups + 1) if (groups // len(order)) % d == 0)
        parts = []
        for row in order:
            axis = np.argmax(centres[row].var(axis=0))
            parts.append(row[np.argsort(centres[row, axis], kind="stable")].reshape(factor, -1))
        order = np.concatenate(parts)
    return order.ravel()


def _initial_experts(
    vectors: Single,
    input_count: int,
    outcome_count: int,
    experts: int,
    allowed: NDArray[np.bool_],
    classes: int,
    rng: np.random.Generator,
) -> Experts:
    """Make one expert for each cluster of inputs and scores of the rebounds of a class.

    ``allowed`` (g, n) tells which rebounds each group makes; the groups after ``classes`` make the
    same ones.
    """
    groups, width = len(allowed), vectors.shape[1]
    count, features = groups * experts, width - outcome_count

    def points(rows: NDArray[np.int64]) -> Single:
        block = vectors[rows]
        return np.concatenate([block[:, 1 : 1 + input_count], block[:, features:]], axis=1)

    products = np.zeros((count, width, width))
    for first, last in [*((k, k + 1) for k in range(classes)), (classes, groups)]:
        rows = np.flatnonzero(allowed[first])
        centres = _clusters(points(rows[:_CLUSTER_ROWS]), (last - first) * experts, rng)
        centres = centres[_order_by_group(centres, last - first)]
        own = products[first * experts : last * experts]
        for block in _slices(rows, 8 * _BLOCK):
            labels = _nearest_centres(points(rows[block]), centres)
            share = (labels == np.arange(len(centres))[:, None]).astype(np.float32)
            add_products(share, vectors[rows[block]], np.float32(0.5), own)
    mass = products[:, 0, 0]
    group_gate, gate = np.zeros((groups, features)), np.zeros((count, features))
    by_group = mass.reshape(groups, experts).sum(axis=1)
    group_gate[:, 0] = np.log((by_group + 1.0) / (len(vectors) + groups))
    gate[:, 0] = np.log((mass + 1.0) / np.repeat(by_group + experts, experts))
    mean = np.zeros((count, outcome_count, features))
    factor = np.repeat(np.eye(outcome_count)[None], count, axis=0)
    weight = Weight(*(np.zeros((n, features, features)) for n in (groups, count, count)))
    fitted = Experts(group_gate, gate, mean, factor, weight)
    _regress(fitted, products)
    return fitted


def _slices(rows: NDArray[Any], size: int = _BLOCK) -> list[slice]:
    return [slice(start, start + size) for start in range(0, len(rows), size)]


def _single_coefficients(fitted: Experts) -> Coefficients:
    groups, features = fitted.group_gate.shape
    outcomes, width = fitted.outcomes, features + fitted.outcomes
    inverse = np.linalg.inv(fitted.factor)
    linear = np.concatenate([-inverse @ fitted.mean, inverse], axis=2)
    white = linear.reshape(groups, -1, outcomes, width).swapaxes(1, 2).reshape(groups, -1, width)
    diagonal = np.einsum("kii->ki", fitted.factor)
    constant = -np.sum(np.log(diagonal), axis=1) - 0.5 * outcomes * math.log(2.0 * math.pi)
    return Coefficients(
        fitted.group_gate.astype(np.float32),
        fitted.gate.reshape(groups, -1, features).astype(np.float32),
        white.astype(np.float32),
        constant.reshape(groups, -1).astype(np.float32),
    )


def expectation(fitted: Experts, vectors: Single, near: NDArray[np.bool_], curved: int = 0) -> Sums:
    """Take the expectation step.

    Parameters
    ----------
    fitted : Experts
    vectors : (n, f + o) float32
        Features and scores of rebounds.
    near : (g, n) bool
        Groups that are computed in each rebound, at least one.
    curved : int, optional
        Sum second derivatives over this number of rebounds, or a few more.

    Returns
    -------
    Sums
    """
    (groups, features), count, width = fitted.group_gate.shape, len(fitted.gate), vectors.shape[1]
    starts = range(0, len(vectors), _BLOCK)
    blocks = [(start, min(start + _BLOCK, len(vectors))) for start in starts]
    sums = Sums(
        near.copy(),
        np.zeros((count, width, width)),
        np.zeros((groups, features)),
        np.zeros((count, features)),
        np.zeros((groups, features, features)),
        np.zeros((count, features, features)),
        min(math.ceil(curved / _BLOCK) * _BLOCK, len(vectors)),
    )
    coefficients = _single_coefficients(fitted)
    likelihood = sum(add_block(coefficients, vectors, start, stop, sums) for start, stop in blocks)
    return sums._replace(likelihood=likelihood)


def _symmetric(upper: FloatArray) -> FloatArray:
    """Complete symmetric matrices from their upper triangles; the lower ones are zero before."""
    return upper + np.triu(upper, 1).transpose(0, 2, 1)


def _regress(fitted: Experts, products: FloatArray) -> None:
    """Set the regressions and covariances that maximise the expected likelihood."""
    features = fitted.gate.shape[1]
    outcomes = fitted.outcomes
    moments = _symmetric(products)
    mass = np.maximum(products[:, 0, 0], 1e-9)
    inputs, cross = moments[:, :features, :features], moments[:, features:, :features]
    pull = np.eye(features)
    pull[0, 0] = 0.0
    pulled = inputs + (_PULL * mass + _PULL_ROWS)[:, None, None] * pull + 1e-6 * np.eye(features)
    mean = np.linalg.solve(pulled, cross.transpose(0, 2, 1)).transpose(0, 2, 1)
    residual = moments[:, features:, features:] - mean @ cross.transpose(0, 2, 1)
    residual += mean @ inputs @ mean.transpose(0, 2, 1) - cross @ mean.transpose(0, 2, 1)
    prior = _PRIOR_ROWS * _PRIOR_VARIANCE * np.eye(outcomes)
    covariance = (residual + prior) / (mass + _PRIOR_ROWS)[:, None, None] + _RIDGE * np.eye(
        outcomes
    )
    symmetric = 0.5 * (covariance + covariance.transpose(0, 2, 1))
    fitted.weight = fitted.weight._replace(mean=pulled)
    fitted.mean = np.asarray(mean, dtype=np.float64)
    fitted.factor = np.asarray(np.linalg.cholesky(symmetric), dtype=np.float64)


def _move_gates(fitted: Experts, sums: Sums, rows: int, damping: float) -> None:
    """Move both gates by a step; the mean of the logits of each softmax stays zero."""
    groups, count = len(fitted.group_gate), len(fitted.gate)
    top = _newton_step(fitted.group_gate, sums.by_group, fitted.weight.group, rows, damping)
    fitted.group_gate = np.subtract(top, top.mean(axis=0))
    moved = _newton_step(fitted.gate, sums.by_expert, fitted.weight.gate, rows, damping)
    parts = moved.reshape(groups, count // groups, -1)
    fitted.gate = np.subtract(parts, parts.mean(axis=1, keepdims=True)).reshape(count, -1)


def _newton_step(
    gate: FloatArray, gradient: FloatArray, curvature: FloatArray, rows: int, damping: float
) -> FloatArray:
    """Take a damped Newton step of the coefficients of a gate."""
    floor = max(1e-4 * rows / len(gate), 1.0)
    matrix = curvature + floor * np.eye(gate.shape[1])
    pulled = gradient - _LOGIT_PULL * gate
    step = np.linalg.solve(matrix, pulled[:, :, None])[:, :, 0]
    return gate + damping * np.clip(step, -_LARGEST_STEP, _LARGEST_STEP)
