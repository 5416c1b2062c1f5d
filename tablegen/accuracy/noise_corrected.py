"""Estimate distances between two laws from samples, with the noise separated from the error.

Every distance is the largest of many differences of means: over places of a distribution function,
pairs of variables, functions of slope one, or classifiers. Two finite samples of one law differ
somewhere by chance, so the measured distance is on average at least the true one. The difference of
one half of the states, at the place where the other half differs most, is on average at most the
true one, with a normal error of known size. The two bracket the true distance.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy import integrate, stats

from tablegen.accuracy.metrics import (
    DIRECTIONS,
    at_resolution,
    classifier_scores,
    correlations,
    largest_gap,
    standardised,
    unit_directions,
    varies,
)
from tablegen.config.metric_table import METRICS
from tablegen.model.float_array import FloatArray

#: Equal bins over the range of a projection, which avoid sorting: with half as many, a distance of
#: 0.001 changes by less than 1 %.
_BINS = 8192

#: States a side that give the variance of a mean over directions.
_FOR_VARIANCE = 50_000


@dataclass(frozen=True)
class Estimate:
    """Distance between two samples, with bounds on the distance between their laws."""

    #: Distance of the samples; on average not below that of the laws.
    value: float
    #: Standard error of the value.
    standard_error: float
    #: Difference in one half of the states, at the place where the other half differs most; on
    #: average not above the distance of the laws.
    held_out: float
    held_out_error: float
    #: Mean of the value if both samples had one law.
    noise: float
    #: Distance of each variable, whose largest is the value; empty for the joint law.
    by_variable: tuple[float, ...] = ()

    @property
    def distance(self) -> float | tuple[float, ...]:
        """Measured distance of each variable, or of the joint law."""
        return self.by_variable or self.value

    def to_dict(self) -> dict[str, Any]:
        """Give the numbers for JSON, without the distances of each variable."""
        return {name: value for name, value in asdict(self).items() if name != "by_variable"}


@dataclass(frozen=True)
class Settings:
    """Choices in the estimates of the metrics."""

    #: Selects the directions, and seeds the classifier.
    seed: int = 0
    #: Directions of the sliced Wasserstein distance.
    directions: int = DIRECTIONS
    #: Largest number of states a side for the classifier, learning and test; None: all.
    classified: int | None = METRICS["auc"].trial_states
    #: States of these from which it learns; None: half of them.
    trained: int | None = None


def ks_estimate(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate the largest Kolmogorov-Smirnov distance of a variable of states (n, d) and (m, d).

    The standard error is the largest that a distribution function of n states has, 0.5 / sqrt(n).
    The noise is the mean of Kolmogorov's distribution, for the largest of d independent variables.
    """
    (learn_a, test_a), (learn_b, test_b) = _halves(table), _halves(direct)
    d = table.shape[1]
    values = np.array([abs(largest_gap(table[:, k], direct[:, k])[1]) for k in range(d)])
    found = [largest_gap(learn_a[:, k], learn_b[:, k]) for k in range(d)]
    worst = int(np.argmax([abs(gap) for _, gap in found]))
    place, gap = found[worst]
    beyond = (test_a[:, worst] <= place).mean() - (test_b[:, worst] <= place).mean()
    root = np.sqrt(1.0 / len(table) + 1.0 / len(direct))
    return Estimate(
        value=float(values.max()),
        standard_error=0.5 * root,
        held_out=float(np.sign(gap) * beyond),
        held_out_error=0.5 * np.sqrt(1.0 / len(test_a) + 1.0 / len(test_b)),
        noise=root * _mean_of_largest(stats.kstwobign.cdf, d),
        by_variable=tuple(values.tolist()),
    )


def ratio_estimate(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate how far the ratio of two means of positive numbers, (n,) and (m,), is from 1."""
    (learn_a, test_a), (learn_b, test_b) = _halves(table), _halves(direct)
    error = float(np.hypot(*(x.std() / (x.mean() * np.sqrt(len(x))) for x in (table, direct))))
    learned, tested = (a.mean() / b.mean() - 1.0 for a, b in ((learn_a, learn_b), (test_a, test_b)))
    return Estimate(
        value=float(abs(table.mean() / direct.mean() - 1.0)),
        standard_error=error,
        held_out=float(np.sign(learned) * tested),
        held_out_error=error * np.sqrt(2.0),
        noise=error * np.sqrt(2.0 / np.pi),
    )


def correlation_estimate(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate the largest error of a correlation, from (n, d) and (m, d) states.

    Standard errors are the asymptotic ones of `correlation_variances`. The noise is the mean of the
    largest of independent normal numbers, one for each pair of variables.
    """
    (learn_a, test_a), (learn_b, test_b) = _halves(table), _halves(direct)
    d = table.shape[1]
    pairs = d * (d - 1) // 2
    if pairs == 0:
        return Estimate(0.0, 0.0, 0.0, 0.0, 0.0)
    gap = correlations(learn_a) - correlations(learn_b)
    worst = np.unravel_index(np.abs(gap).argmax(), gap.shape)
    beyond = correlations(test_a) - correlations(test_b)
    variance = correlation_variances(table) / len(table)
    variance += correlation_variances(direct) / len(direct)
    errors = np.sqrt(variance)
    share = np.sqrt(len(table) / len(test_a))
    return Estimate(
        value=float(np.abs(correlations(table) - correlations(direct)).max()),
        standard_error=float(errors.max()),
        held_out=float(np.sign(gap[worst]) * beyond[worst]),
        held_out_error=float(errors[worst] * share),
        noise=float(errors[np.triu_indices(d, 1)].mean())
        * _mean_of_largest(stats.halfnorm.cdf, pairs),
    )


def certain_correlation_error(table: FloatArray, direct: FloatArray) -> float:
    """Compute the largest error of a correlation beyond two standard errors of it.

    A few rare rebounds carry the correlations of grazing impacts, so that their noise is large.
    """
    variances = (correlation_variances(states) / len(states) for states in (table, direct))
    beyond = np.abs(correlations(table) - correlations(direct)) - 2.0 * np.sqrt(sum(variances))
    return max(float(beyond.max()), 0.0)


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


def sliced_wasserstein_estimate(a: FloatArray, b: FloatArray, settings: Settings) -> Estimate:
    """Estimate the `sliced_wasserstein` distance of states (n, d) and (m, d).

    On a line the distance is the area between the distribution functions. It equals the difference
    of the means of a function whose slope is 1 or -1, depending on which of them is above. One half
    of the states finds that function and the other half tests it. The noise is the mean area of a
    normal difference of known variance.
    """
    # only differences count, so the states are neither centred nor copied
    scale, directions = np.where(varies(b), b.std(axis=0), 1.0), settings.directions
    split_a, split_b = len(a) // 2, len(b) // 2
    sampled = slice(split_a, split_a + _FOR_VARIANCE), slice(split_b, split_b + _FOR_VARIANCE)
    mean_a, mean_b = (np.zeros(len(x[part])) for x, part in zip((a, b), sampled, strict=True))
    value = held_out = noise = 0.0
    per_state = 1.0 / len(a) + 1.0 / len(b)
    for direction in unit_directions(directions, a.shape[1], settings.seed) / scale:
        bin_a, bin_b, width = _binned(a @ direction, b @ direction)
        found = _cumulative(bin_a[:split_a]) - _cumulative(bin_b[:split_b])
        tested = _cumulative(bin_a[split_a:]) - _cumulative(bin_b[split_b:])
        below = _cumulative(bin_b)
        slope = np.sign(found)
        value += width * float(np.abs(_cumulative(bin_a) - below).sum())
        held_out += width * float(slope @ tested)
        spread = np.sqrt(below * (1.0 - below)).sum()
        noise += width * float(spread) * np.sqrt(2.0 / np.pi * per_state)
        witness = width * np.cumsum(slope)
        mean_a += witness[bin_a[sampled[0]]]
        mean_b += witness[bin_b[sampled[1]]]
    variances = mean_a.var() / directions**2, mean_b.var() / directions**2
    tested_a, tested_b = len(a) - split_a, len(b) - split_b
    return Estimate(
        value=value / directions,
        standard_error=float(np.sqrt(variances[0] / len(a) + variances[1] / len(b))),
        held_out=held_out / directions,
        held_out_error=float(np.sqrt(variances[0] / tested_a + variances[1] / tested_b)),
        noise=noise / directions,
    )


def auc_estimate(table: FloatArray, direct: FloatArray, settings: Settings) -> Estimate:
    """Estimate the area under the ROC curve of a classifier, on states that it has not seen.

    Source of the standard error: DeLong, DeLong, Clarke-Pearson, Biometrics 44 (1988) 837-845.
    """
    few = min(len(table), len(direct), settings.classified or len(table))
    of_table, of_direct = classifier_scores(
        table[:few], direct[:few], settings.seed, settings.trained or few // 2
    )
    ranks = stats.rankdata(np.concatenate((of_table, of_direct)))
    above = (ranks[: len(of_table)] - stats.rankdata(of_table)) / len(of_direct)
    below = 1.0 - (ranks[len(of_table) :] - stats.rankdata(of_direct)) / len(of_table)
    error = float(np.sqrt(above.var() / len(above) + below.var() / len(below)))
    area = float(above.mean())
    return Estimate(area, error, area, error, 0.5)


#: Function of each metric, of the states of table and direct simulation and `Settings`.
ESTIMATES: Mapping[str, Callable[[FloatArray, FloatArray, Settings], Estimate]] = {
    "ks": lambda a, b, _: ks_estimate(a, b),
    "sliced_wasserstein": sliced_wasserstein_estimate,
    "correlation_error": lambda a, b, _: correlation_estimate(a, b),
    "auc": auc_estimate,
}


def estimated(
    table: FloatArray,
    direct: FloatArray,
    settings: Settings,
    metrics: Iterable[str] = tuple(METRICS),
) -> dict[str, Estimate]:
    """Estimate metrics of two samples (n, d) and (m, d) at `RESOLUTION`, by name."""
    table, direct = at_resolution(table, 0), at_resolution(direct, 1)
    return {name: ESTIMATES[name](table, direct, settings) for name in metrics}


def _halves(states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Split independent states into halves."""
    return states[: len(states) // 2], states[len(states) // 2 :]


def _mean_of_largest(cdf: Callable[[FloatArray], FloatArray], count: int) -> float:
    """Compute the mean of the largest of independent positive numbers of one distribution."""
    grid = np.linspace(0.0, 10.0, 10_001)
    return float(integrate.trapezoid(1.0 - cdf(grid) ** count, grid))


def _binned(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Give the bin of each value of two samples, and the width of a bin."""
    low, high = min(a.min(), b.min()), max(a.max(), b.max())
    width = max(float(high - low), 1e-300) / _BINS
    in_a, in_b = (np.minimum(((x - low) / width).astype(np.int32), _BINS - 1) for x in (a, b))
    return in_a, in_b, width


def _cumulative(bins: FloatArray) -> FloatArray:
    """Compute the empirical distribution function at the upper ends of the bins."""
    return np.cumsum(np.bincount(bins, minlength=_BINS)) / len(bins)
