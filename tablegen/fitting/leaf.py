"""One leaf of the spin law: experts fitted to rebounds, rounded as stored, and quantiles."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import (
    FACTOR_UNIT,
    GATE_UNIT,
    GROUP_SIZE,
    MEAN_UNIT,
    N_EXPERTS,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    SCORE_MAX,
)
from tablegen.fitting.experts import Experts, fit_experts
from tablegen.fitting.marginals import normal_scores
from tablegen.fitting.resolution import SpinSizes
from tablegen.fitting.rounding import rounded, rounded_together
from tablegen.fitting.spin_coordinates import features, used_features
from tablegen.fitting.spin_scores import StoredExperts, bounded_scores
from tablegen.model.float_array import FloatArray

#: Standard deviation of an input below which it counts as constant.
_SAME = 2e-4

#: Rounding steps, in units of the file, which then compresses: of the coefficients of 1, of the
#: inputs and of their products, in gates and in means; and of factors.
_GATE_STEPS, _MEAN_STEPS, _FACTOR_STEP = (1, 8, 32), (1, 64, 128), 16

#: Least quantile of p_v, which a file needs from the second knot on, with a margin for rounding.
_LEAST_V = 2e-9

#: Logit, in units of the file, below that of fitted experts: e^-60 is never drawn.
_NEVER = 60 * GATE_UNIT


class Rebounds(NamedTuple):
    """Rebounds of n particles: inputs (n, 8) of their conditions, and outcomes (n, 7 or 8)."""

    inputs: FloatArray
    outcomes: FloatArray


class LeafArrays(NamedTuple):
    """A leaf as stored; the names are those of the datasets."""

    centre: NDArray[np.float32]
    scale: NDArray[np.float32]
    group_gate: NDArray[np.int16]
    gate: NDArray[np.int16]
    mean: NDArray[np.int16]
    factor: NDArray[np.int16]
    quantiles: NDArray[np.float32]


def fit_leaf(
    around: Rebounds,
    inside: Rebounds,
    sizes: SpinSizes,
    rng: np.random.Generator,
) -> LeafArrays:
    """Fit a leaf.

    Experts are fitted to rebounds in the leaf and around it, in random order. Quantiles follow from
    the outcomes of other rebounds inside it.
    """
    inputs, values = around
    centre, spread = inputs.mean(axis=0), inputs.std(axis=0)
    varies = spread > _SAME
    scale = np.where(varies, 1.0 / np.where(varies, spread, 1.0), 0.0)
    centre, scale = centre.astype(np.float32), scale.astype(np.float32)
    used = used_features(varies)
    t = (inputs - centre) * scale
    experts, _ = fit_experts(
        features(t, np.float32)[:, used],
        t[:, varies],
        normal_scores(values),
        sizes.groups,
        sizes.experts,
        rng,
    )
    stored = _stored(experts, used)
    drawn = bounded_scores(stored, features((inside.inputs - centre) * scale, np.float32), rng)
    quantiles = _quantiles(drawn, inside.outcomes, sizes.knots)
    quantiles[1] = np.maximum(quantiles[1], np.float32(_LEAST_V))
    return LeafArrays(centre, scale, *stored, quantiles)


def _steps(used: NDArray[np.bool_], steps: tuple[int, int, int]) -> NDArray[np.int64]:
    """Choose the step of each coefficient: those of 1, of the inputs and of the products."""
    return np.repeat(steps, (1, N_INPUTS, N_FEATURES - N_INPUTS - 1))[used]


def _stored(fitted: Experts, used: NDArray[np.bool_]) -> StoredExperts:
    """Experts in the integers and the order of the file.

    Constant features get zeros. Experts that were not fitted are never drawn.
    """
    groups, each = len(fitted.group_gate), len(fitted.gate) // len(fitted.group_gate)
    outcomes = fitted.outcomes
    rows, columns = np.tril_indices(outcomes)
    gate_steps, mean_steps = _steps(used, _GATE_STEPS), _steps(used, _MEAN_STEPS)
    group_gate = np.zeros((N_GROUPS, N_FEATURES), dtype=np.int16)
    gate = np.zeros((N_GROUPS, GROUP_SIZE, N_FEATURES), dtype=np.int16)
    mean = np.zeros((N_GROUPS, GROUP_SIZE, outcomes, N_FEATURES), dtype=np.int16)
    factor = np.zeros((N_GROUPS, GROUP_SIZE, len(rows)), dtype=np.int16)
    group_gate[groups:, 0], gate[:, each:, 0] = -_NEVER, -_NEVER
    weight = fitted.weight
    whole = rounded_together(fitted.group_gate[:, None], weight.group, GATE_UNIT, gate_steps)
    group_gate[:groups, used] = whole[:, 0]
    whole = rounded_together(fitted.gate[:, None], weight.gate, GATE_UNIT, gate_steps)
    gate[:groups, :each, used] = whole.reshape(groups, each, -1)
    whole = rounded_together(fitted.mean, weight.mean, MEAN_UNIT, mean_steps)
    mean[:groups, :each, :, used] = whole.reshape(groups, each, outcomes, -1)
    whole = rounded(fitted.factor[:, rows, columns], FACTOR_UNIT, _FACTOR_STEP)
    factor[:groups, :each] = whole.reshape(groups, each, -1)
    factor[..., rows == columns] = np.maximum(factor[..., rows == columns], _FACTOR_STEP)
    return StoredExperts(
        np.ascontiguousarray(group_gate.T),
        np.ascontiguousarray(gate.transpose(0, 2, 1)),
        np.ascontiguousarray(mean.reshape(N_EXPERTS, outcomes, -1).transpose(0, 2, 1)),
        factor.reshape(N_EXPERTS, -1),
    )


def _quantiles(scores: NDArray[np.float32], wanted: FloatArray, knots: int) -> NDArray[np.float32]:
    """Outcomes, (7 or 8, knots), at equal steps of the bounded score."""
    at = np.linspace(-SCORE_MAX, SCORE_MAX, knots)
    outcomes = wanted.shape[1]
    quantiles = np.empty((outcomes, knots), dtype=np.float32)
    for k in range(outcomes):
        share = np.searchsorted(np.sort(scores[:, k]), at) / len(scores)
        quantiles[k] = np.quantile(wanted[:, k], share)
    return quantiles
