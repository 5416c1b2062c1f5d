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

Two or three groups of eight have a share in a rebound. So every few iterations all groups are
computed in each rebound, with the second derivatives, and in the iterations between only the groups
that had a share. EXPERIMENTS.md ("Time of a fit") has the measurements behind the constants.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tablegen.fitting.expectation import (
    Single,
    add_products,
    find_shares,
    softmax,
    weigh_shares,
    write_log_densities,
)
from tablegen.model.float_array import FloatArray

#: Rows of a block: the shares of a group fit into the cache.
_BLOCK = 512

#: A group with a smaller share in a rebound is left out there until all groups are computed again.
_LEAST_GROUP_SHARE = np.float32(1e-3)

#: Log-density of a group that is left out.
_LEFT_OUT = np.float32(-1e30)

#: Smaller shares of an expert in a rebound are left out of sums, and so are smaller curvatures.
_LEAST_SHARE, _LEAST_CURVATURE = np.float32(1e-3), np.float32(1e-4)

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


@dataclass
class Sums:
    """Sums over rebounds."""

    #: (g, n): groups that have a share in each rebound.
    near: NDArray[np.bool_]
    #: (k, f + o, f + o): products of features and scores, weighted by the shares of each expert.
    products: FloatArray
    #: (g, f) and (k, f): gradients of the log-likelihood with respect to both gates.
    by_group: FloatArray
    by_expert: FloatArray
    #: (g, f, f) and (k, f, f): minus the second derivatives with respect to each gate alone, in the
    #: upper triangles, over the first ``curved`` rebounds.
    group_curvature: FloatArray
    expert_curvature: FloatArray
    curved: int = 0
    #: Log-likelihood.
    likelihood: float = 0.0


def fit_experts(
    vectors: Single,
    input_count: int,
    outcome_count: int,
    groups: int,
    experts: int,
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
    rng : numpy.random.Generator
        Chooses the points at which clusters begin.

    Returns
    -------
    fitted : Experts
    likelihood : float
        Mean log-likelihood before the last step.
    """
    fitted = _initial_experts(vectors, input_count, outcome_count, (groups, experts), rng)
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
        near = np.pad(near, ((0, 0), (0, new)), constant_values=True)
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
    sizes: tuple[int, int],
    rng: np.random.Generator,
) -> Experts:
    """Make one expert for each cluster of inputs and scores."""
    groups, experts = sizes
    count, width = groups * experts, vectors.shape[1]
    features = width - outcome_count

    def points(rows: slice) -> Single:
        block = vectors[rows]
        return np.concatenate([block[:, 1 : 1 + input_count], block[:, features:]], axis=1)

    centres = _clusters(points(slice(_CLUSTER_ROWS)), count, rng)
    centres = centres[_order_by_group(centres, groups)]
    products = np.zeros((count, width, width))
    for rows in _slices(vectors, 8 * _BLOCK):
        labels = _nearest_centres(points(rows), centres)
        share = (labels == np.arange(count)[:, None]).astype(np.float32)
        add_products(share, vectors[rows], np.float32(0.5), products)
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


def _slices(rows: Single, size: int = _BLOCK) -> list[slice]:
    return [slice(start, start + size) for start in range(0, len(rows), size)]


class _Coefficients(NamedTuple):
    """Coefficients in single precision that are multiplied with rebounds, group by group."""

    #: (g, f): gate of the groups.
    group_gate: Single
    #: (g, k / g, f): gates of the experts.
    gate: Single
    #: (g, o k / g, f + o): matrices that map features and scores to factor^-1 (x - mean).
    white: Single
    #: (g, k / g): logarithms of the densities of experts at their means.
    constant: Single


def _single_coefficients(fitted: Experts) -> _Coefficients:
    groups, features = fitted.group_gate.shape
    outcomes, width = fitted.outcomes, features + fitted.outcomes
    inverse = np.linalg.inv(fitted.factor)
    linear = np.concatenate([-inverse @ fitted.mean, inverse], axis=2)
    white = linear.reshape(groups, -1, outcomes, width).swapaxes(1, 2).reshape(groups, -1, width)
    diagonal = np.einsum("kii->ki", fitted.factor)
    constant = -np.sum(np.log(diagonal), axis=1) - 0.5 * outcomes * math.log(2.0 * math.pi)
    return _Coefficients(
        fitted.group_gate.astype(np.float32),
        fitted.gate.reshape(groups, -1, features).astype(np.float32),
        white.astype(np.float32),
        constant.reshape(groups, -1).astype(np.float32),
    )


class _Group(NamedTuple):
    """Experts of a group, in the m rebounds of a block in which the group is computed."""

    #: (m,): numbers of these rebounds in the block.
    rows: NDArray[np.int64]
    #: (m, f + o)
    vectors: Single
    #: (k / g, m): probabilities of the experts, and their shares in the group.
    expert: Single
    share: Single
    #: (m,): logarithms of the densities of the group.
    log_density: Single


def _evaluate_group(
    coefficients: _Coefficients, number: int, block: Single, near: NDArray[np.bool_]
) -> _Group:
    """Compute a group in those rebounds of a block in which it is near, (n,)."""
    gate, constant = coefficients.gate[number], coefficients.constant[number]
    rows = np.flatnonzero(near)
    vectors = block[rows]
    expert = gate @ vectors[:, : gate.shape[1]].T
    softmax(expert)
    share = np.empty_like(expert)
    write_log_densities(coefficients.white[number] @ vectors.T, constant, share)
    return _Group(rows, vectors, expert, share, find_shares(share, expert))


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
    sums = Sums(
        near.copy(),
        np.zeros((count, width, width)),
        np.zeros_like(fitted.group_gate),
        np.zeros_like(fitted.gate),
        np.zeros((groups, features, features)),
        np.zeros((count, features, features)),
    )
    coefficients = _single_coefficients(fitted)
    for rows in _slices(vectors):
        _add_block(coefficients, vectors[rows], sums.near[:, rows], rows.start < curved, sums)
    return sums


def _add_block(
    coefficients: _Coefficients,
    block: Single,
    near: NDArray[np.bool_],
    is_curved: bool,
    sums: Sums,
) -> None:
    """Add the rebounds of a block to sums, and forget the groups that have no share in them."""
    groups, each, features = coefficients.gate.shape
    parts = [_evaluate_group(coefficients, g, block, near[g]) for g in range(groups)]
    phi = np.ascontiguousarray(block[:, :features])
    probability = coefficients.group_gate @ phi.T
    softmax(probability)
    share = np.full_like(probability, _LEFT_OUT)
    for g, part in enumerate(parts):
        share[g, part.rows] = part.log_density
    sums.likelihood += float(find_shares(share, probability).sum(dtype=np.float64))
    near &= share > _LEAST_GROUP_SHARE
    sums.by_group += (share - probability) @ phi
    if is_curved:
        sums.curved += len(block)
        add_products(probability - probability**2, phi, _LEAST_CURVATURE, sums.group_curvature)
    for g, part in enumerate(parts):
        experts, group_share = slice(g * each, (g + 1) * each), share[g, part.rows]
        gradient = np.empty_like(part.share)
        weigh_shares(part.share, part.expert, group_share, gradient)
        add_products(part.share, part.vectors, _LEAST_SHARE, sums.products[experts])
        sums.by_expert[experts] += gradient @ part.vectors[:, :features]
        if is_curved:
            curvature = group_share * (part.expert - part.expert**2)
            add_products(
                curvature, phi[part.rows], _LEAST_CURVATURE, sums.expert_curvature[experts]
            )


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
