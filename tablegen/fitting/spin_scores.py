"""Draw scores from the rounded experts of a leaf, as a draw from a table does.

``sampler/c/src/experts.h`` is the same draw in C. This copy in numpy exists because the quantiles
of a leaf are made from such scores before there is a file that C could read.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

from sampler.formats.bounds import (
    FACTOR_UNIT,
    GATE_UNIT,
    GROUP_SIZE,
    MEAN_UNIT,
    OUTCOMES,
    SCORE_MAX,
    SLOW_TAIL,
)


class StoredExperts(NamedTuple):
    """Experts of a leaf as a file stores them: 8 groups of 8, for 7 outcomes, or 8 with works."""

    #: (59, 8): logits of the groups.
    group_gate: NDArray[np.int16]
    #: (8, 59, 8): logits of the experts of each group.
    gate: NDArray[np.int16]
    #: (64, 59, outcomes)
    mean: NDArray[np.int16]
    #: (64, 28 or 36): lower triangles, row by row.
    factor: NDArray[np.int16]


def bounded_scores(
    stored: StoredExperts, features: NDArray[np.float32], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Draw a bounded score of each outcome, (n, outcomes), at features (n, 59).

    A score x of an expert is bounded by x / sqrt(1 + x^2 / SCORE_MAX^2).
    """
    outcomes = stored.mean.shape[-1]
    scores = rng.standard_normal((len(features), outcomes), dtype=np.float32)
    uniform = rng.random((len(features), 2), dtype=np.float32)
    groups = _choose(features, stored.group_gate, uniform[:, 0])
    slowest, p_v = groups == 0, OUTCOMES.index("p_v")
    scores[slowest, p_v] = _slowest_normals(scores[slowest, p_v])
    for group in range(len(stored.gate)):
        rows = np.flatnonzero(groups == group)
        experts = _choose(features[rows], stored.gate[group], uniform[rows, 1])
        for expert in np.unique(experts):
            expert_rows, number = rows[experts == expert], group * GROUP_SIZE + expert
            factor = np.zeros((outcomes, outcomes), dtype=np.float32)
            factor[np.tril_indices(outcomes)] = stored.factor[number] / np.float32(FACTOR_UNIT)
            mean = stored.mean[number] / np.float32(MEAN_UNIT)
            scores[expert_rows] = features[expert_rows] @ mean + scores[expert_rows] @ factor.T
    return np.asarray(scores / np.sqrt(1.0 + scores**2 / np.float32(SCORE_MAX**2)))


def _slowest_normals(normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Convert normal numbers to those of p_v of the slowest rebounds (`SLOW_TAIL`)."""
    shift, square, factor, core = SLOW_TAIL
    x = normals - np.float32(1.0)
    above = np.sqrt(x * x + np.float32(core)) - x
    return np.asarray(
        np.float32(shift) - np.sqrt(np.float32(square) + np.float32(factor) * above * above)
    )


def _choose(
    features: NDArray[np.float32], gate: NDArray[np.int16], uniform: NDArray[np.float32]
) -> NDArray[np.intp]:
    """Choose a group or an expert for each row of features, by a gate and uniform numbers (n,)."""
    shares = np.cumsum(softmax(features @ (gate / np.float32(GATE_UNIT)), axis=1), axis=1)
    return np.asarray(np.sum(uniform[:, None] * shares[:, -1:] >= shares[:, :-1], axis=1))
