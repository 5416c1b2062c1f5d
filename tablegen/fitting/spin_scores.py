"""Scores drawn from the experts of a leaf, by the kernels of a draw from a table."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import GROUP_SIZE, LANES, N_FEATURES, SCORE_MAX, expert_stride
from sampler.formats.image import expert_records, normal_table
from tablegen.fitting.expert_kernels import (
    choose_group,
    choose_of_group,
    fill_scores,
    normal_of_word,
)
from tablegen.model.float_array import FloatArray
from tablegen.model.jit import kernel


class StoredExperts(NamedTuple):
    """Experts of a leaf as stored in a file: int16, 8 groups of 16 experts.

    ``group_gate`` (23, 8), ``gate`` (8, 23, 16), ``mean`` (128, 23, 6), ``factor`` (128, 21);
    with works (128, 23, 8) and (128, 36).
    """

    group_gate: NDArray[np.int16]
    gate: NDArray[np.int16]
    mean: NDArray[np.int16]
    factor: NDArray[np.int16]


@kernel
def _draw(
    group_gates: NDArray[np.int16],
    gates: NDArray[np.int16],
    experts: NDArray[np.int16],
    stride: int,
    features: NDArray[np.float32],
    words: NDArray[np.uint32],
    table: NDArray[np.float32],
    scores: NDArray[np.float32],
) -> None:
    """Draw scores (n, k) at features (n * 23,) from words (n, k + 2), k outcomes."""
    normals = np.zeros(LANES, dtype=np.float32)
    for i in range(words.shape[0]):
        first = i * N_FEATURES
        group = choose_group(group_gates, 0, features, first, words[i, 0])
        base = group * (N_FEATURES * GROUP_SIZE)
        expert = choose_of_group(gates, base, features, first, words[i, 1])
        for k in range(scores.shape[1]):
            normals[k] = normal_of_word(table, words[i, 2 + k])
        record = (group * GROUP_SIZE + expert) * stride
        fill_scores(experts, record, features, first, normals, scores[i])


def bounded_scores(
    stored: StoredExperts, features: FloatArray, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Draw scores zeta (n, outcomes), from -6 to 6, of a leaf at features (n, 23)."""
    outcomes = stored.mean.shape[-1]
    words = rng.integers(0, 2**32, (len(features), 2 + outcomes), dtype=np.uint32)
    scores = np.empty((len(features), outcomes), dtype=np.float32)
    records: Any = expert_records(stored.mean[None], stored.factor[None])
    group_gates, gates = (
        np.ascontiguousarray(part).ravel() for part in (stored.group_gate, stored.gate)
    )
    own = features.astype(np.float32).ravel()
    stride = expert_stride(outcomes)
    _draw(group_gates, gates, records, stride, own, words, normal_table(), scores)
    bounded: NDArray[np.float32] = scores / np.sqrt(1.0 + scores**2 / np.float32(SCORE_MAX**2))
    return bounded
