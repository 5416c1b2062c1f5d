"""Distances between two samples of rebound states, each with its error.

No single number tells whether two laws are the same. The Kolmogorov-Smirnov distance sees each
variable alone; the sliced Wasserstein distance, the correlations and a classifier see how variables
depend on each other. The judged sample comes first, the reference second. `ESTIMATES` holds the
function of each of `tablegen.config.metric_table.METRICS`.

Two samples of one law differ by chance, so a distance of samples is on average above that of laws,
by at most its *noise*: the mean distance of two samples of one law. An error is the standard error
plus a third of the noise, so that the distance of the laws is rarely below three errors less.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from sklearn.ensemble import HistGradientBoostingClassifier
from threadpoolctl import threadpool_limits

from tablegen.config.metric_table import METRICS
from tablegen.model.float_array import FloatArray

#: Trees of the classifier, their leaves, and the part of its answer that each tree adds.
TREES, _LEAVES, _RATE = 60, 127, 0.15

#: Difference, in units of V or V/a, that counts as none: no flow code sees a thousandth of the
#: impact. Else a law that gives 6e-17 and a table that gives 0 would be as far apart as can be.
RESOLUTION = 1e-3

#: Spread (largest minus smallest value) up to which a variable counts as constant: rounding of
#: variables of order one.
CONSTANT_SPREAD = 1e-12

#: Noise of the largest of six Kolmogorov-Smirnov distances, times the square root of the number of
#: states; and of the largest of fifteen correlations, in standard errors.
_KS_NOISE, _CORRELATION_NOISE = 1.2, 2.0

#: Equal bins over the range of a projection, which avoid sorting: with half as many, a distance of
#: 0.001 changes by less than 1 %.
_BINS = 8192

#: States a side that give the variance of a mean over directions.
_FOR_VARIANCE = 50_000


@dataclass(frozen=True)
class Estimate:
    """Distance between two samples, and its error."""

    value: float
    error: float
    #: Distance of each variable, whose largest is the value; empty for the joint law.
    by_variable: tuple[float, ...] = ()

    @property
    def certain(self) -> float:
        """Distance of the laws that is certain: three errors less; infinite for NaN."""
        low = self.value - 3.0 * self.error
        return low if np.isfinite(low) else float("inf")

    @property
    def distance(self) -> float | tuple[float, ...]:
        """Measured distance of each variable, or of the joint law."""
        return self.by_variable or self.value


@dataclass(frozen=True)
class Settings:
    """Choices in the estimates of the metrics."""

    #: Selects the directions, and seeds the classifier.
    seed: int = 0
    #: Directions of the sliced Wasserstein distance.
    directions: int = 64
    #: Largest number of states a side for the classifier, of which half are learned from.
    classified: int | None = METRICS["auc"].trial_states


def at_resolution(values: FloatArray, key: int) -> FloatArray:
    """Blur states (n, d) by normal noise of a key, whose standard deviation is `RESOLUTION`.

    The noise is independent of the states. If both sides have such noise, laws that differ by much
    less look alike, and no distance between laws grows.
    """
    return values + RESOLUTION * np.random.default_rng(key).standard_normal(values.shape)


def estimated(table: FloatArray, direct: FloatArray, settings: Settings) -> dict[str, Estimate]:
    """Estimate all metrics of two samples (n, d) and (m, d) at `RESOLUTION`, by name."""
    table, direct = at_resolution(table, 0), at_resolution(direct, 1)
    return {name: estimate(table, direct, settings) for name, estimate in ESTIMATES.items()}


def ks(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate the largest Kolmogorov-Smirnov distance of a variable of states (n, d) and (m, d).

    The standard error is the largest that a distribution function of n states has, 0.5 / sqrt(n).
    """
    values = ks_distances(table, direct)
    root = np.sqrt(1.0 / len(table) + 1.0 / len(direct))
    error = (0.5 + _KS_NOISE / 3.0) * root
    return Estimate(float(values.max()), float(error), tuple(values.tolist()))


def ks_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute the Kolmogorov-Smirnov distances of the variables of two samples (., d), (d,)."""
    return np.array([_largest_gap(np.sort(x), np.sort(y)) for x, y in zip(a.T, b.T, strict=True)])


def _largest_gap(a: FloatArray, b: FloatArray) -> float:
    """Find the largest difference of two empirical distribution functions of sorted values."""
    points = np.concatenate((a, b))
    below_a = np.searchsorted(a, points, side="right") / a.size
    below_b = np.searchsorted(b, points, side="right") / b.size
    return float(np.abs(below_a - below_b).max())


def ratio(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate how far the ratio of two means of positive numbers, (n,) and (m,), is from 1."""
    error = np.hypot(*(x.std() / (x.mean() * np.sqrt(len(x))) for x in (table, direct)))
    return Estimate(float(abs(table.mean() / direct.mean() - 1.0)), float(error))


def correlation_error(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate the most certain error of a correlation between states (n, d) and (m, d).

    Errors differ: a few rare rebounds carry the correlations of grazing impacts.
    """
    variance = correlation_variances(table) / len(table)
    variance += correlation_variances(direct) / len(direct)
    errors = (1.0 + _CORRELATION_NOISE / 3.0) * np.sqrt(variance)
    gaps = np.triu(np.abs(correlations(table) - correlations(direct)), 1)
    # without constant variables, which never differ
    certain = np.where(gaps > 0.0, gaps - 3.0 * errors, -np.inf)
    worst = np.unravel_index(certain.argmax(), gaps.shape)
    return Estimate(float(gaps[worst]), float(errors[worst]))


def correlations(values: FloatArray) -> FloatArray:
    """Compute the correlation matrix (d, d) of values (n, d); 0 for constant variables."""
    scaled = standardised(values)
    return scaled.T @ scaled / len(values)


def correlation_variances(values: FloatArray) -> FloatArray:
    """Compute the variances of estimates of correlations, times the number of states, shape (d, d).

    With z the standardised variables, an estimate of r_jk moves by the mean of z_j z_k - r_jk
    (z_j^2 + z_k^2) / 2, whose variance this is; normality is not assumed. It is 0 on the diagonal
    and for constant variables.
    Source: Ferguson, A Course in Large Sample Theory (1996), chapter 8.
    """
    z = standardised(values)
    squares, count = z * z, len(values)
    r, even = z.T @ z / count, squares.T @ squares / count
    odd = (squares * z).T @ z / count
    fourth = np.diag(even)
    ends = fourth[:, None] + 2.0 * even + fourth[None, :]
    return np.maximum(even - r * (odd + odd.T) + 0.25 * r * r * ends, 0.0)


def sliced_wasserstein(a: FloatArray, b: FloatArray, settings: Settings) -> Estimate:
    """Estimate the sliced Wasserstein-1 distance of states (n, d) and (m, d).

    Both samples are divided by the second's standard deviations and projected on random unit
    directions; the Wasserstein-1 distances of the projections are averaged. A variable that is
    constant in the second is not scaled. On a line the distance is the area between the
    distribution functions. It equals the difference of the means of a function whose slope is 1 or
    -1, depending on which of them is above; the variance of that function gives the standard error.
    Source: Bonneel, Rabin, Peyre, Pfister, "Sliced and Radon Wasserstein barycenters of measures",
    J. Math. Imaging Vis. 51 (2015).
    """
    # only differences count, so the states are neither centred nor copied
    scale, count = np.where(varies(b), b.std(axis=0), 1.0), settings.directions
    mean_a, mean_b = (np.zeros(min(len(x), _FOR_VARIANCE)) for x in (a, b))
    value = noise = 0.0
    per_state = 1.0 / len(a) + 1.0 / len(b)
    for direction in unit_directions(count, a.shape[1], settings.seed) / scale:
        bin_a, bin_b, width = _binned(a @ direction, b @ direction)
        below = _cumulative(bin_b)
        gap = _cumulative(bin_a) - below
        value += width * float(np.abs(gap).sum())
        # mean area of a normal difference of known variance
        spread = np.sqrt(below * (1.0 - below)).sum()
        noise += width * float(spread) * np.sqrt(2.0 / np.pi * per_state)
        witness = width * np.cumsum(np.sign(gap))
        mean_a += witness[bin_a[: len(mean_a)]]
        mean_b += witness[bin_b[: len(mean_b)]]
    error = np.sqrt(mean_a.var() / len(a) + mean_b.var() / len(b)) + noise / 3.0
    return Estimate(value / count, float(error) / count)


def varies(values: FloatArray) -> NDArray[np.bool_]:
    """Tell which variables (d,) of a sample (n, d) spread by more than rounding."""
    return np.ptp(values, axis=0) > CONSTANT_SPREAD


def standardised(values: FloatArray) -> FloatArray:
    """Standardise values (n, d) with their own moments; 0 where a variable is constant."""
    moving = varies(values)
    centred = np.where(moving, values - values.mean(axis=0), 0.0)
    return centred / np.where(moving, centred.std(axis=0), 1.0)


def unit_directions(count: int, dimension: int, seed: int) -> FloatArray:
    """Draw directions uniform on the unit sphere, shape (count, dimension)."""
    normal = np.random.default_rng(seed).standard_normal((count, dimension))
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _binned(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Give the bin of each value of two samples, and the width of a bin."""
    low, high = min(a.min(), b.min()), max(a.max(), b.max())
    width = max(float(high - low), 1e-300) / _BINS
    in_a, in_b = (np.minimum(((x - low) / width).astype(np.int32), _BINS - 1) for x in (a, b))
    return in_a, in_b, width


def _cumulative(bins: FloatArray) -> FloatArray:
    """Compute the empirical distribution function at the upper ends of the bins."""
    return np.cumsum(np.bincount(bins, minlength=_BINS)) / len(bins)


def auc(table: FloatArray, direct: FloatArray, settings: Settings) -> Estimate:
    """Estimate how well gradient-boosted trees tell samples (n, d) and (m, d) apart.

    A classifier of 60 trees with at most 127 leaves learns on the first half of each sample; the
    area under its ROC curve is taken on the others. It is 0.5 if the samples cannot be told apart,
    and 1 if they always can. Noise makes it no larger.
    Sources: Lopez-Paz and Oquab, "Revisiting classifier two-sample tests", ICLR 2017; of the
    standard error: DeLong, DeLong, Clarke-Pearson, Biometrics 44 (1988) 837-845.
    """
    few = min(len(table), len(direct), settings.classified or len(table))
    of_table, of_direct = classifier_scores(table[:few], direct[:few], settings.seed)
    ranks = stats.rankdata(np.concatenate((of_table, of_direct)))
    above = (ranks[: len(of_table)] - stats.rankdata(of_table)) / len(of_direct)
    below = 1.0 - (ranks[len(of_table) :] - stats.rankdata(of_direct)) / len(of_table)
    error = np.sqrt(above.var() / len(above) + below.var() / len(below))
    return Estimate(float(above.mean()), float(error))


def classifier_scores(a: FloatArray, b: FloatArray, seed: int) -> tuple[FloatArray, FloatArray]:
    """Score how likely a classifier thinks each state is of the first sample.

    It learns from the first half of each sample, and scores the others.
    """
    (train_a, test_a), (train_b, test_b) = (np.split(x, [len(x) // 2]) for x in (a, b))
    model = HistGradientBoostingClassifier(
        learning_rate=_RATE,
        max_iter=TREES,
        max_leaf_nodes=_LEAVES,
        early_stopping=False,
        random_state=seed % 2**32,
    )
    labels = np.repeat(np.array([1, 0]), [len(train_a), len(train_b)])
    # its threads wait for each other by spinning: on a busy machine two were forty times slower
    # than one, with the same result
    with threadpool_limits(limits=1, user_api="openmp"):
        model.fit(np.concatenate((train_a, train_b)), labels)
        score = model.predict_proba(np.concatenate((test_a, test_b)))[:, 1]
    return score[: len(test_a)], score[len(test_a) :]


#: Function of each metric, of the states of table and direct simulation and `Settings`.
ESTIMATES: Mapping[str, Callable[[FloatArray, FloatArray, Settings], Estimate]] = {
    "ks": lambda a, b, _: ks(a, b),
    "sliced_wasserstein": sliced_wasserstein,
    "correlation_error": lambda a, b, _: correlation_error(a, b),
    "auc": auc,
}
