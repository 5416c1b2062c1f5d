"""The error of a method of sampling rebound states, with what chance leaves of it.

A method gives several independent batches. Each is compared with the same large direct reference;
the error is the mean over the batches, and its confidence interval comes from a bootstrap over
them. Direct batches, compared with the reference in the same manner, are the noise floor: no method
can be seen to be better than that.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tablegen.accuracy.metrics import DISTANCES, Reference
from tablegen.config.metric_table import METRICS
from tablegen.model.float_array import FloatArray

#: Draws a batch: number of states and seed to (n, 6) states.
Draw = Callable[[int, int], FloatArray]

#: Directions of the sliced Wasserstein distance.
_DIRECTIONS = 32

_RESAMPLES = 2000
_LEVEL = 0.95


@dataclass(frozen=True)
class BatchMean:
    """Mean over batches and its 95 % confidence interval."""

    mean: float
    low: float
    high: float
    values: tuple[float, ...]


def batch_mean(values: Sequence[float]) -> BatchMean:
    """Mean of some batches with a percentile interval of bootstrapped means.

    Parameters
    ----------
    values : sequence of float
        One number a batch.

    Returns
    -------
    BatchMean
        The interval has no width where there is one batch.
    """
    array = np.asarray(values, dtype=np.float64)
    picks = np.random.default_rng(len(array)).integers(len(array), size=(_RESAMPLES, len(array)))
    means = array[picks].mean(axis=1)
    tail = 0.5 * (1.0 - _LEVEL)
    low, high = np.quantile(means, (tail, 1.0 - tail))
    return BatchMean(float(array.mean()), float(low), float(high), tuple(array.tolist()))


def batch_seed(seed: int, *purpose: int) -> int:
    """Give the seed of one purpose, independent of all others."""
    return int(np.random.SeedSequence([seed, *purpose]).generate_state(1, np.uint64)[0])


def forbidden_share(state: FloatArray) -> float:
    """Share of states that no rebound can have: v <= 0, or translational energy above 1."""
    energy = np.square(state[:, :3]).sum(axis=1)
    return float(np.mean((state[:, 1] <= 0.0) | (energy > 1.0)))


def batch_errors(
    draw: Draw, reference: Reference, size: int, classified: int, batch: int, seed: int
) -> dict[str, float]:
    """Errors of one batch.

    Parameters
    ----------
    draw : callable
    reference : Reference
    size : int
        States in the batch.
    classified : int
        States a side of the classifier; none if 0.
    batch : int
        Number of the batch.
    seed : int
        Of the draw.

    Returns
    -------
    dict
        The `METRICS`, without those of a classifier where nothing is classified, and
        ``forbidden``.
    """
    state = draw(size, seed)
    few = min(classified, size)
    # a classifier sees other states of the reference in every batch
    start = batch * few % (len(reference.states) - few + 1)
    found = {"forbidden": forbidden_share(state)}
    for name, metric in METRICS.items():
        if not metric.learned:
            distance = DISTANCES[name](state, reference, _DIRECTIONS, 0)
        elif classified:
            part = reference.states[start : start + few]
            distance = DISTANCES[name](state[:few], part, _DIRECTIONS, batch)
        else:
            continue
        found[name] = float(np.max(distance))
    return found


def gathered(batches: Sequence[dict[str, float]]) -> dict[str, BatchMean]:
    """Estimates of every metric from the errors of the batches."""
    return {
        name: batch_mean([batch[name] for batch in batches])
        for name in (*METRICS, "forbidden")
        if name in batches[0]
    }
