"""Distances between two samples of rebound states.

No single number tells whether two laws are the same. The Kolmogorov-Smirnov distance sees each
variable alone; the sliced Wasserstein distance, the correlations and a classifier see how variables
depend on each other. The judged sample comes first, the reference second. `DISTANCES` holds the
function of each of `tablegen.config.metric_table.METRICS`.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.metrics import roc_auc_score
from threadpoolctl import threadpool_limits

from tablegen.model.float_array import FloatArray

#: Trees of the classifier.
TREES = 150

#: Directions of the sliced Wasserstein distance.
DIRECTIONS = 64

#: Difference, in units of V or V/a, that counts as none: no flow code sees a thousandth of the
#: impact. Else a law that gives 6e-17 and a table that gives 0 would be as far apart as can be.
RESOLUTION = 1e-3

#: Spread (largest minus smallest value) up to which a variable counts as constant: rounding of
#: variables of order one.
CONSTANT_SPREAD = 1e-12


def at_resolution(values: FloatArray, key: int) -> FloatArray:
    """Blur states (n, d) by normal noise of a key, whose standard deviation is `RESOLUTION`.

    The noise is independent of the states. If both sides have such noise, laws that differ by much
    less look alike, and no distance between laws grows.
    """
    return values + RESOLUTION * np.random.default_rng(key).standard_normal(values.shape)


def varies(values: FloatArray) -> NDArray[np.bool_]:
    """Tell which variables (d,) of a sample (n, d) spread by more than rounding."""
    return np.ptp(values, axis=0) > CONSTANT_SPREAD


def ks_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute the Kolmogorov-Smirnov distances of the variables of two samples (., d), (d,)."""
    gaps = (largest_gap(x, y) for x, y in zip(a.T, b.T, strict=True))
    return np.array([abs(gap) for _, gap in gaps])


def sliced_wasserstein(
    a: FloatArray, b: FloatArray, directions: int = DIRECTIONS, seed: int = 0
) -> float:
    """Compute the sliced Wasserstein-1 distance of states (n, d) and (m, d).

    Both samples are standardised with the second's means and standard deviations and projected
    on random unit directions; the Wasserstein-1 distances of the projections, in standard
    deviations, are averaged. A variable that is constant in the second is centred but not scaled.
    Source: Bonneel, Rabin, Peyre, Pfister, "Sliced and Radon Wasserstein barycenters of measures",
    J. Math. Imaging Vis. 51 (2015).
    """
    at_a, at_b, width = _quantile_pieces(len(a), len(b))
    mean, scale = b.mean(axis=0), np.where(varies(b), b.std(axis=0), 1.0)
    (a, b), total = ((x - mean) / scale for x in (a, b)), 0.0
    for direction in unit_directions(directions, a.shape[1], seed):
        # on the line the distance is the area between the two quantile functions
        gap = np.sort(a @ direction)[at_a] - np.sort(b @ direction)[at_b]
        total += float(np.abs(gap) @ width)
    return total / directions


def correlation_error(a: FloatArray, b: FloatArray) -> float:
    """Compute the largest difference of a Pearson correlation between two samples, in [0, 2]."""
    return float(np.abs(correlations(a) - correlations(b)).max())


def classifier_auc(a: FloatArray, b: FloatArray, seed: int = 0) -> float:
    """Measure how well gradient-boosted trees tell samples (n, d) and (m, d) apart.

    A classifier of 150 trees with at most 63 leaves learns on a random half of each sample; the
    area under its ROC curve is taken on the other halves. It is 0.5 if the samples cannot be told
    apart, up to noise of about 0.6/sqrt(n) for n = m, and 1 if they always can.
    Source: Lopez-Paz and Oquab, "Revisiting classifier two-sample tests", ICLR 2017.
    """
    rng = np.random.default_rng(seed)
    of_a, of_b = classifier_scores(rng.permutation(a), rng.permutation(b), seed)
    return float(roc_auc_score(_labels(of_a, of_b), np.concatenate((of_a, of_b))))


def classifier_scores(
    a: FloatArray, b: FloatArray, seed: int, trained: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """Score how likely a classifier thinks each state is of the first sample.

    It learns from the first states of each sample, ``trained`` or half of them, and scores the
    others.
    """
    split_a, split_b = trained or len(a) // 2, trained or len(b) // 2
    train_a, train_b, test_a, test_b = a[:split_a], b[:split_b], a[split_a:], b[split_b:]
    model = HistGradientBoostingClassifier(
        max_iter=TREES, max_leaf_nodes=63, early_stopping=False, random_state=seed % 2**32
    )
    # its threads wait for each other by spinning: on a busy machine two were forty times slower
    # than one, with the same result
    with threadpool_limits(limits=1, user_api="openmp"):
        model.fit(np.concatenate((train_a, train_b)), _labels(train_a, train_b))
        score = model.predict_proba(np.concatenate((test_a, test_b)))[:, 1]
    return score[: len(test_a)], score[len(test_a) :]


def largest_gap(a: FloatArray, b: FloatArray) -> tuple[float, float]:
    """Find the value where two distribution functions differ most, and their difference there."""
    a, b = np.sort(a), np.sort(b)
    points = np.concatenate((a, b))
    below_a = np.searchsorted(a, points, side="right") / a.size
    below_b = np.searchsorted(b, points, side="right") / b.size
    worst = int(np.abs(below_a - below_b).argmax())
    return float(points[worst]), float(below_a[worst] - below_b[worst])


@lru_cache(maxsize=4)
def _quantile_pieces(n: int, m: int) -> tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]:
    """Divide (0, 1) into pieces on which the quantile functions of n and m values are constant.

    Returns the positions of each piece among the sorted values, and its width. Levels are counted
    in units of 1/(n m) to avoid rounding.
    """
    ends = np.union1d(np.arange(1, n + 1) * m, np.arange(1, m + 1) * n)
    starts = np.concatenate(([0], ends[:-1]))
    return starts // m, starts // n, (ends - starts) / (n * m)


def unit_directions(count: int, dimension: int, seed: int) -> FloatArray:
    """Draw directions uniform on the unit sphere, shape (count, dimension)."""
    normal = np.random.default_rng(seed).standard_normal((count, dimension))
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def standardised(values: FloatArray) -> FloatArray:
    """Standardise values (n, d) with their own moments; 0 where a variable is constant."""
    moving = varies(values)
    centred = np.where(moving, values - values.mean(axis=0), 0.0)
    return centred / np.where(moving, centred.std(axis=0), 1.0)


def correlations(values: FloatArray) -> FloatArray:
    """Compute the correlation matrix (d, d) of values (n, d); 0 for constant variables."""
    scaled = standardised(values)
    return scaled.T @ scaled / len(values)


def _labels(ones: FloatArray, zeros: FloatArray) -> NDArray[np.int64]:
    """Give the class of each row of two stacked samples."""
    return np.repeat(np.array([1, 0]), [len(ones), len(zeros)])


#: Function of each metric, of a sample, a reference, a number of directions and a seed: an array of
#: shape (d,) where it has a number for each variable.
DISTANCES: Mapping[str, Callable[[FloatArray, FloatArray, int, int], FloatArray | float]] = {
    "ks": lambda a, b, directions, seed: ks_distances(a, b),
    "sliced_wasserstein": sliced_wasserstein,
    "correlation_error": lambda a, b, directions, seed: correlation_error(a, b),
    "auc": lambda a, b, directions, seed: classifier_auc(a, b, seed),
}
