"""Four distances between two samples of rebound states, each with its error.

The states are those of `tablegen`: velocities over the impact speed V, and angular velocities times
a/V with the half-size a, so all distances are pure numbers. The sample of the table comes first,
the sample of direct simulation second; they have n and m states. No single number tells whether two
laws are the same, so there are four (`ESTIMATES`):

``ks``
    Kolmogorov-Smirnov distance, the largest over the variables::

        D = max_x |F(x) - G(x)|

    with the empirical distribution functions F and G of one variable. Standard error: at most
    ``0.5 sqrt(1/n + 1/m)``, because F(x) has the variance F (1 - F) / n, at most 1 / (4 n).
``sliced_wasserstein``
    Mean over K random unit directions of the area between the distribution functions of the
    projected states::

        W = 1/K sum_k integral |F_k(x) - G_k(x)| dx

    The area is also E_F[h] - E_G[h] with h' = sign(G_k - F_k). Standard error:
    ``sqrt(var_F[h] / n + var_G[h] / m)``, with h averaged over the directions.
``correlation_error``
    Error of the correlation r_jk of two variables, for the pair whose error is most certain::

        C = |r_jk - s_jk|

    Standard error: the root of the sum of both variances of `correlations`.
``auc``
    Area under the ROC curve of a classifier that tells the samples apart: the probability that it
    ranks a state of the table above one of direct simulation. Standard error (DeLong):
    ``sqrt(var[A(x)] / n' + var[B(y)] / m')`` with the share A(x) of the reference ranked below the
    state x, the share B(y) of the table ranked above the state y, and n', m' states that the
    classifier has not learned from.

Two samples of one law differ by chance. So the distance of two samples is on average larger than
that of their laws, by at most the *noise*: the mean distance of two samples of one law. The `error`
of an estimate is its standard error plus a third of the noise. Then value - 3 error is rarely above
the distance of the laws.

Sources are named at each function.
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

#: Number of trees of the classifier, leaves of a tree, and learning rate.
TREES, _LEAVES, _RATE = 60, 127, 0.15

#: Difference of two states, in units of V or V/a, that does not count: no flow code notices a
#: thousandth of the impact speed. Without it, a law that always gives 6e-17 and a table that always
#: gives 0 would have the largest possible distance.
RESOLUTION = 1e-3

#: Difference of two states of the spin law, in units of V or V/a, that does not count in
#: Kolmogorov-Smirnov distances. Variables of nearly round grains vary by as little, so that a law
#: which is exact for all uses would be far from another by their ranks.
TOLERANCE = 3e-3

#: A variable counts as constant if its largest value is at most this much above its smallest. This
#: is larger than rounding of numbers of order one.
CONSTANT_SPREAD = 1e-12

#: Noise of the largest of six Kolmogorov-Smirnov distances, in units of sqrt(1/n + 1/m), and noise
#: of the largest error of fifteen correlations, in standard errors.
_KS_NOISE, _CORRELATION_NOISE = 1.2, 2.0

#: Number of equal bins over the range of a projection. Counting in bins is faster than sorting.
#: With half as many bins, a distance of 0.001 changes by less than 1 %.
_BINS = 8192

#: Largest number of states on each side from which the variance of h is computed; it needs an array
#: of this length, and no more accuracy.
_VARIANCE_STATES = 50_000


@dataclass(frozen=True)
class Estimate:
    """Distance between two samples, and its error."""

    value: float
    error: float
    #: Distance of each variable, of which `value` is the largest; empty if the distance is one of
    #: all variables together.
    by_variable: tuple[float, ...] = ()

    @property
    def certain(self) -> float:
        """Distance that the laws certainly have: value - 3 error; infinity if that is NaN.

        A number that could not be measured must not hold.
        """
        low = self.value - 3.0 * self.error
        return low if np.isfinite(low) else float("inf")

    @property
    def distance(self) -> float | tuple[float, ...]:
        """Distances of the variables if there are such, else the one distance."""
        return self.by_variable or self.value


@dataclass(frozen=True)
class Settings:
    """Settings of the metrics that draw random numbers."""

    #: Seed of the directions and of the classifier.
    seed: int = 0
    #: Number of directions of the sliced Wasserstein distance.
    directions: int = 64
    #: Largest number of states on each side for the classifier, which learns from half of them.
    #: None: all states.
    classified: int | None = METRICS["auc"].trial_states
    #: Difference that does not count in Kolmogorov-Smirnov distances.
    tolerance: float = 0.0


def at_resolution(values: FloatArray, key: int) -> FloatArray:
    """Add normal noise to states (n, d), with a standard deviation of `RESOLUTION`.

    ``key`` seeds the noise. If both samples have such noise, laws that differ by much less look
    alike. Noise that is independent of the states increases no distance between laws.
    """
    blurred = np.random.default_rng(key).standard_normal(values.shape)
    blurred *= RESOLUTION
    blurred += values
    return blurred


def estimate_metrics(
    table: FloatArray, direct: FloatArray, settings: Settings
) -> dict[str, Estimate]:
    """Estimate all metrics of two samples (n, d) and (m, d) that `at_resolution` has blurred.

    Returns the estimates by the names of `tablegen.config.metric_table.METRICS`.
    """
    return {name: estimate(table, direct, settings) for name, estimate in ESTIMATES.items()}


def ks(table: FloatArray, direct: FloatArray, tolerance: float = 0.0) -> Estimate:
    """Estimate the largest Kolmogorov-Smirnov distance of any variable of states (n, d), (m, d).

    Differences of up to ``tolerance`` in a variable do not count (`ks_distances`).
    """
    values = ks_distances(table, direct, tolerance)
    root = np.sqrt(1.0 / len(table) + 1.0 / len(direct))
    error = (0.5 + _KS_NOISE / 3.0) * root
    return Estimate(float(values.max()), float(error), tuple(values.tolist()))


def ks_distances(a: FloatArray, b: FloatArray, tolerance: float = 0.0) -> FloatArray:
    """Compute the distance of each variable, (d,), of samples (n, d) and (m, d).

    With the distribution functions F and G and the tolerance e it is the largest of

        F(x - e) - G(x)    and    G(x - e) - F(x),

    which is the Kolmogorov-Smirnov distance for e = 0.
    """
    pairs = zip(a.T, b.T, strict=True)
    return np.array([_largest_gap(np.sort(x), np.sort(y), tolerance) for x, y in pairs])


def _largest_gap(a: FloatArray, b: FloatArray, tolerance: float) -> float:
    """Compute the largest difference of the distribution functions of two sorted samples."""
    # the function of a is larger by most at a value of a, where it has just grown, and so for b
    below_b = np.searchsorted(b, a + tolerance, side="right") / b.size
    below_a = np.searchsorted(a, b + tolerance, side="right") / a.size
    more_a = np.arange(1, a.size + 1) / a.size - below_b
    more_b = np.arange(1, b.size + 1) / b.size - below_a
    return float(max(more_a.max(), more_b.max()))


def ratio(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate |mean(table) / mean(direct) - 1| of positive numbers, (n,) and (m,).

    The standard error is that of a ratio of independent means near 1, by the delta method: the root
    of the sum of both squared relative standard errors.
    """
    error = np.hypot(*(x.std() / (x.mean() * np.sqrt(len(x))) for x in (table, direct)))
    return Estimate(float(abs(table.mean() / direct.mean() - 1.0)), float(error))


def correlation_error(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate the most certain error of a correlation, of states (n, d) and (m, d).

    It belongs to the pair of variables with the largest value - 3 error, not with the largest
    value: standard errors differ from pair to pair, because at grazing impacts some correlations
    depend on few rare rebounds.
    """
    (table_r, table_variance), (direct_r, direct_variance) = (
        correlations(table),
        correlations(direct),
    )
    variance = table_variance / len(table)
    variance += direct_variance / len(direct)
    errors = (1.0 + _CORRELATION_NOISE / 3.0) * np.sqrt(variance)
    gaps = np.triu(np.abs(table_r - direct_r), 1)
    # a gap of exactly 0 is that of a constant variable, or lies outside the upper triangle
    certain = np.where(gaps > 0.0, gaps - 3.0 * errors, -np.inf)
    worst = np.unravel_index(certain.argmax(), gaps.shape)
    return Estimate(float(gaps[worst]), float(errors[worst]))


def correlations(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute the correlations of values (n, d), and n times the variance of each estimate, (d, d).

    With the standardised variables z, the error of an estimate of r_jk is, to first order, the mean
    over the states of::

        z_j z_k - r_jk (z_j^2 + z_k^2) / 2

    The variance is that of this expression, and does not assume normal variables. It is 0 on the
    diagonal. Both numbers are 0 where a variable is constant.
    Source: Ferguson, A Course in Large Sample Theory (1996), chapter 8.
    """
    z, count = standardised(values), len(values)
    powers = z * z
    r, even = z.T @ z / count, powers.T @ powers / count
    powers *= z
    odd = powers.T @ z / count
    fourth = np.diag(even)
    ends = fourth[:, None] + 2.0 * even + fourth[None, :]
    return r, np.maximum(even - r * (odd + odd.T) + 0.25 * r * r * ends, 0.0)


def sliced_wasserstein(a: FloatArray, b: FloatArray, settings: Settings) -> Estimate:
    """Estimate the sliced Wasserstein-1 distance of states (n, d) and (m, d).

    Each variable of both samples is divided by its standard deviation in the second sample, or by 1
    if it is constant there. The states are then projected on random unit directions. On a line the
    Wasserstein-1 distance is the area between the distribution functions; the function averages it
    over the directions.

    The noise uses that F_k(x) - G_k(x), for equal laws, is nearly normal with a standard deviation
    of sqrt(G_k (1 - G_k) (1/n + 1/m)), and that the mean of |z| is sqrt(2/pi) for normal z.
    Source: Bonneel, Rabin, Peyre, Pfister, "Sliced and Radon Wasserstein barycenters of measures",
    J. Math. Imaging Vis. 51 (2015).
    """
    # a shift of both samples changes no distance, so they are not centred, which would copy them
    scale, count = np.where(varies(b), b.std(axis=0), 1.0), settings.directions
    mean_a, mean_b = (np.zeros(min(len(x), _VARIANCE_STATES)) for x in (a, b))
    value = noise = 0.0
    per_state = 1.0 / len(a) + 1.0 / len(b)
    for direction in unit_directions(count, a.shape[1], settings.seed) / scale:
        bin_a, bin_b, width = _bin_numbers(a @ direction, b @ direction)
        below = _cumulative(bin_b)
        gap = _cumulative(bin_a) - below
        value += width * float(np.abs(gap).sum())
        spread = np.sqrt(below * (1.0 - below)).sum()
        noise += width * float(spread) * np.sqrt(2.0 / np.pi * per_state)
        # h of the module's formula, but for its sign, which does not change its variance
        witness = width * np.cumsum(np.sign(gap))
        mean_a += witness[bin_a[: len(mean_a)]]
        mean_b += witness[bin_b[: len(mean_b)]]
    error = np.sqrt(mean_a.var() / len(a) + mean_b.var() / len(b)) + noise / 3.0
    return Estimate(value / count, float(error) / count)


def varies(values: FloatArray) -> NDArray[np.bool_]:
    """Tell which variables, (d,), of a sample (n, d) are not constant (`CONSTANT_SPREAD`)."""
    return np.ptp(values, axis=0) > CONSTANT_SPREAD


def standardised(values: FloatArray) -> FloatArray:
    """Scale each variable of values (n, d) to mean 0 and variance 1; a constant one to 0."""
    moving = varies(values)
    scaled = values - values.mean(axis=0)
    scaled[:, ~moving] = 0.0
    scaled /= np.where(moving, scaled.std(axis=0), 1.0)
    return scaled


def unit_directions(count: int, dimension: int, seed: int) -> FloatArray:
    """Draw unit vectors of uniform direction, shape (count, dimension)."""
    normal = np.random.default_rng(seed).standard_normal((count, dimension))
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _bin_numbers(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the number of the bin of each value, for both samples, and the width of a bin."""
    low, high = min(a.min(), b.min()), max(a.max(), b.max())
    width = max(float(high - low), 1e-300) / _BINS
    in_a, in_b = (np.minimum(((x - low) / width).astype(np.int32), _BINS - 1) for x in (a, b))
    return in_a, in_b, width


def _cumulative(bins: FloatArray) -> FloatArray:
    """Compute the empirical distribution function at the upper ends of the bins."""
    return np.cumsum(np.bincount(bins, minlength=_BINS)) / len(bins)


def auc(table: FloatArray, direct: FloatArray, settings: Settings) -> Estimate:
    """Estimate how well gradient-boosted trees tell samples (n, d) and (m, d) apart.

    A classifier of 60 trees with at most 127 leaves learns from the first half of each sample. The
    area under its ROC curve is measured on the second halves. It is 0.5 if the classifier cannot
    tell the samples apart, and 1 if it always can. It has no noise: the mean over two samples of
    one law is 0.5.
    Sources: Lopez-Paz and Oquab, "Revisiting classifier two-sample tests", ICLR 2017. For the
    standard error: DeLong, DeLong, Clarke-Pearson, Biometrics 44 (1988) 837-845.
    """
    few = min(len(table), len(direct), settings.classified or len(table))
    table_scores, direct_scores = classifier_scores(table[:few], direct[:few], settings.seed)
    ranks = stats.rankdata(np.concatenate((table_scores, direct_scores)))
    above = (ranks[: len(table_scores)] - stats.rankdata(table_scores)) / len(direct_scores)
    below = 1.0 - (ranks[len(table_scores) :] - stats.rankdata(direct_scores)) / len(table_scores)
    error = np.sqrt(above.var() / len(above) + below.var() / len(below))
    return Estimate(float(above.mean()), float(error))


def classifier_scores(a: FloatArray, b: FloatArray, seed: int) -> tuple[FloatArray, FloatArray]:
    """Compute the probability, by a classifier, that a state is one of the first sample.

    The classifier learns from the first half of each sample. Returns the probabilities of the
    states of the second halves.
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
    # The threads of scikit-learn wait for each other in busy loops. On a machine with other work,
    # two threads took forty times as long as one, and gave the same result.
    with threadpool_limits(limits=1, user_api="openmp"):
        model.fit(np.concatenate((train_a, train_b)), labels)
        score = model.predict_proba(np.concatenate((test_a, test_b)))[:, 1]
    return score[: len(test_a)], score[len(test_a) :]


#: Function of each metric; its arguments are the states of the table, those of direct simulation,
#: and `Settings`.
ESTIMATES: Mapping[str, Callable[[FloatArray, FloatArray, Settings], Estimate]] = {
    "ks": lambda a, b, settings: ks(a, b, settings.tolerance),
    "sliced_wasserstein": sliced_wasserstein,
    "correlation_error": lambda a, b, _: correlation_error(a, b),
    "auc": auc,
}
