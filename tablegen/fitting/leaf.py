"""Fit one leaf of the spin law: experts for the normal scores of outcomes, and quantiles.

1. The inputs of rebounds in the leaf and around it are standardised, and outcomes become normal
   scores.
2. A mixture of experts is fitted to these scores (`tablegen.fitting.experts`).
3. Its coefficients are rounded to the integers of a file (`tablegen.fitting.rounding`).
4. Scores are drawn from the rounded experts at the conditions of the rebounds in the leaf. The
   quantiles turn these scores into the outcomes of the same rebounds. So draws have the marginals
   of direct simulation over the leaf, whatever the experts and their rounding miss.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import (
    FACTOR_UNIT,
    GATE_UNIT,
    GROUP_SIZE,
    MEAN_UNIT,
    N_DIRECTIONS,
    N_EXPERTS,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    SCORE_MAX,
)
from tablegen.fitting.experts import Experts, fit_experts
from tablegen.fitting.marginals import normal_scores
from tablegen.fitting.resolution import SpinSizes
from tablegen.fitting.rounding import round_to_multiples, round_together
from tablegen.fitting.spin_coordinates import features, used_features
from tablegen.fitting.spin_scores import StoredExperts, bounded_scores
from tablegen.model.float_array import FloatArray

#: An input with a smaller standard deviation counts as constant.
_CONSTANT_DEVIATION = 2e-4

#: Coefficients are rounded to multiples of these steps, in units of the file, because numbers with
#: few digits compress. The three steps are those for the coefficients of 1, of the inputs and of
#: their products.
_GATE_STEPS, _MEAN_STEPS = (1, 8, 32), (1, 64, 128)
#: Step of the factors.
_FACTOR_STEP = 16

#: Least quantile of p_v from the second knot on, with a margin for rounding: a grain must leave the
#: wall, so a file has positive quantiles there.
_LEAST_V = 2e-9

#: Rebounds whose features are computed at a time.
_BLOCK = 10_000

#: Column of p_v among the outcomes, shares of the rebounds that are slowest and slow, and
#: regularisation of the regression that tells which these are.
_P_V, _SLOW_SHARES, _RIDGE = 1, (0.01, 0.05), 1e-3

#: Logit, in units of the file, of experts that were not fitted: e^-60 is never drawn.
_NEVER_DRAWN = 60 * GATE_UNIT


class Rebounds(NamedTuple):
    """Rebounds of n particles."""

    #: (n, 13): inputs of their conditions, and directions.
    inputs: FloatArray
    #: (n, 7), or (n, 8) with works.
    outcomes: FloatArray


class LeafArrays(NamedTuple):
    """Arrays of a leaf, as a file stores them; the names are those of the datasets."""

    centre: NDArray[np.float32]
    scale: NDArray[np.float32]
    group_gate: NDArray[np.int16]
    gate: NDArray[np.int16]
    mean: NDArray[np.int16]
    factor: NDArray[np.int16]
    quantiles: NDArray[np.float32]


def fit_leaf(
    rebounds: Rebounds, inside: NDArray[np.bool_], sizes: SpinSizes, rng: np.random.Generator
) -> LeafArrays:
    """Fit a leaf.

    Parameters
    ----------
    rebounds : Rebounds
        Rebounds in the leaf and a little beyond it, in random order.
    inside : (n,) bool
        Whether each rebound is in the leaf.
    sizes : SpinSizes
    rng : numpy.random.Generator

    Returns
    -------
    LeafArrays
    """
    inputs, outcomes = rebounds
    del rebounds  # each array goes as soon as the rebounds in the leaf are selected from it
    centre, spread = inputs.mean(axis=0), inputs.std(axis=0)
    varies = spread > _CONSTANT_DEVIATION
    scale = np.where(varies, 1.0 / np.where(varies, spread, 1.0), 0.0)
    centre[N_INPUTS:], scale[N_INPUTS:] = 0.0, 1.0  # directions are features as they are
    centre, scale = centre.astype(np.float32), scale.astype(np.float32)
    is_used = used_features(varies)
    count, used = outcomes.shape[1], int(is_used.sum())
    vectors = np.empty((len(inputs), used + count), dtype=np.float32)
    for start in range(0, len(inputs), _BLOCK):
        rows = slice(start, start + _BLOCK)
        phi = features((inputs[rows] - centre) * scale, np.float32)
        vectors[rows, :used] = phi[:, is_used]
    inputs = inputs[inside]
    for k in range(count):
        vectors[:, used + k] = normal_scores(outcomes[:, [k]])[:, 0]
    outcomes = outcomes[inside]
    slow = _slow_classes(vectors[:, :used], vectors[:, used + _P_V])
    experts, _ = fit_experts(
        vectors, int(varies[:N_INPUTS].sum()), count, sizes.groups, sizes.experts, slow, rng
    )
    del vectors
    stored = _stored_experts(experts, is_used)
    phi = features((inputs - centre) * scale, np.float32)
    scores = bounded_scores(stored, phi, rng)
    quantiles = _outcome_quantiles(scores, outcomes, sizes.knots)
    quantiles[1] = np.maximum(quantiles[1], np.float32(_LEAST_V))
    return LeafArrays(centre[:N_INPUTS], scale[:N_INPUTS], *stored, quantiles)


def _slow_classes(phi: NDArray[np.float32], score: NDArray[np.float32]) -> NDArray[np.int64]:
    """Find the classes of the rebounds with the slowest normal velocities for their conditions.

    The rebounds with the least scores of p_v relative to a quadratic regression on the inputs are
    of class 1, those with the next ones of class 2, ..., by the shares `_SLOW_SHARES`. All others
    are of class 0. Returns (n,).
    """
    form = (phi.T @ phi).astype(np.float64) + _RIDGE * len(phi) * np.eye(phi.shape[1])
    rest = score - phi @ np.linalg.solve(form, phi.T @ score).astype(np.float32)
    ends = np.quantile(rest, _SLOW_SHARES)
    return np.asarray((np.searchsorted(ends, rest) + 1) % (len(ends) + 1))


def _coefficient_steps(
    is_used: NDArray[np.bool_], steps: tuple[int, int, int]
) -> NDArray[np.int64]:
    """Find the step of each coefficient from those of 1, of the inputs and of the products.

    Directions have the step of inputs.
    """
    one, of_input, of_product = steps
    products = N_FEATURES - N_INPUTS - N_DIRECTIONS - 1
    counts = (1, N_INPUTS, products, N_DIRECTIONS)
    return np.repeat((one, of_input, of_product, of_input), counts)[is_used]


def _stored_experts(fitted: Experts, is_used: NDArray[np.bool_]) -> StoredExperts:
    """Round experts to the integers of a file, and bring them into its order.

    The coefficients of features that are constant in the leaf are zero. A file has room for more
    experts than may be fitted; the gates of spare experts let no draw choose them.
    """
    groups, group_size = len(fitted.group_gate), len(fitted.gate) // len(fitted.group_gate)
    outcomes = fitted.outcomes
    rows, columns = np.tril_indices(outcomes)
    gate_steps = _coefficient_steps(is_used, _GATE_STEPS)
    mean_steps = _coefficient_steps(is_used, _MEAN_STEPS)
    group_gate = np.zeros((N_GROUPS, N_FEATURES), dtype=np.int16)
    gate = np.zeros((N_GROUPS, GROUP_SIZE, N_FEATURES), dtype=np.int16)
    mean = np.zeros((N_GROUPS, GROUP_SIZE, outcomes, N_FEATURES), dtype=np.int16)
    factor = np.zeros((N_GROUPS, GROUP_SIZE, len(rows)), dtype=np.int16)
    group_gate[groups:, 0], gate[:, group_size:, 0] = -_NEVER_DRAWN, -_NEVER_DRAWN
    weight = fitted.weight
    integers = round_together(fitted.group_gate[:, None], weight.group, GATE_UNIT, gate_steps)
    group_gate[:groups, is_used] = integers[:, 0]
    integers = round_together(fitted.gate[:, None], weight.gate, GATE_UNIT, gate_steps)
    gate[:groups, :group_size, is_used] = integers.reshape(groups, group_size, -1)
    integers = round_together(fitted.mean, weight.mean, MEAN_UNIT, mean_steps)
    mean[:groups, :group_size, :, is_used] = integers.reshape(groups, group_size, outcomes, -1)
    integers = round_to_multiples(fitted.factor[:, rows, columns], FACTOR_UNIT, _FACTOR_STEP)
    factor[:groups, :group_size] = integers.reshape(groups, group_size, -1)
    factor[..., rows == columns] = np.maximum(factor[..., rows == columns], _FACTOR_STEP)
    return StoredExperts(
        np.ascontiguousarray(group_gate.T),
        np.ascontiguousarray(gate.transpose(0, 2, 1)),
        np.ascontiguousarray(mean.reshape(N_EXPERTS, outcomes, -1).transpose(0, 2, 1)),
        factor.reshape(N_EXPERTS, -1),
    )


def _outcome_quantiles(
    scores: NDArray[np.float32], outcomes: FloatArray, knots: int
) -> NDArray[np.float32]:
    """Find the outcomes, (7 or 8, knots), that have the same ranks as equally spaced scores."""
    score_knots = np.linspace(-SCORE_MAX, SCORE_MAX, knots)
    count = outcomes.shape[1]
    quantiles = np.empty((count, knots), dtype=np.float32)
    for k in range(count):
        probability = np.searchsorted(np.sort(scores[:, k]), score_knots) / len(scores)
        quantiles[k] = np.quantile(outcomes[:, k], probability)
    return quantiles
