"""Scores drawn from the experts of a leaf, as a draw from a table makes them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

from sampler.formats.bounds import FACTOR_UNIT, GATE_UNIT, GROUP_SIZE, MEAN_UNIT, SCORE_MAX


class StoredExperts(NamedTuple):
    """Experts of a leaf as stored in a file: int16, 8 groups of 16 experts.

    ``group_gate`` (30, 8), ``gate`` (8, 30, 16), ``mean`` (128, 30, 7), ``factor`` (128, 28);
    with works (128, 30, 8) and (128, 36).
    """

    group_gate: NDArray[np.int16]
    gate: NDArray[np.int16]
    mean: NDArray[np.int16]
    factor: NDArray[np.int16]


def bounded_scores(
    stored: StoredExperts, features: NDArray[np.float32], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Draw scores zeta (n, outcomes), from -6 to 6, of a leaf at features (n, 30)."""
    outcomes = stored.mean.shape[-1]
    scores = rng.standard_normal((len(features), outcomes), dtype=np.float32)
    chance = rng.random((len(features), 2), dtype=np.float32)
    groups = _chosen(features, stored.group_gate, chance[:, 0])
    for group in range(len(stored.gate)):
        rows = np.flatnonzero(groups == group)
        experts = _chosen(features[rows], stored.gate[group], chance[rows, 1])
        for expert in np.unique(experts):
            own, number = rows[experts == expert], group * GROUP_SIZE + expert
            factor = np.zeros((outcomes, outcomes), dtype=np.float32)
            factor[np.tril_indices(outcomes)] = stored.factor[number] / np.float32(FACTOR_UNIT)
            mean = stored.mean[number] / np.float32(MEAN_UNIT)
            scores[own] = features[own] @ mean + scores[own] @ factor.T
    return np.asarray(scores / np.sqrt(1.0 + scores**2 / np.float32(SCORE_MAX**2)))


def _chosen(
    features: NDArray[np.float32], gate: NDArray[np.int16], chance: NDArray[np.float32]
) -> NDArray[np.intp]:
    """Choose a number for each row of features by the weights of a gate, from uniform numbers."""
    shares = np.cumsum(softmax(features @ (gate / np.float32(GATE_UNIT)), axis=1), axis=1)
    return np.asarray(np.sum(chance[:, None] * shares[:, -1:] >= shares[:, :-1], axis=1))
