"""Distances between samples, and what chance makes of them."""

import math
from typing import NamedTuple

from scipy.stats import ks_2samp, kstwobign

from many_hits.models import FloatArray

#: Two samples of one law are further apart than `ks_by_chance` says with this probability.
LEVEL = 1e-3


class Estimate(NamedTuple):
    """A number and its standard error."""

    value: float
    error: float

    def __str__(self) -> str:
        if not math.isfinite(self.value):
            return "–"
        # Rounding is no error; spheres of a chain all do the same.
        chance = self.error > 1e-9 * abs(self.value)
        digits = max(1 - math.floor(math.log10(self.error)), 0) if chance else 2
        return f"{self.value:.{digits}f} ± {self.error:.{digits}f}"


def mean_of(values: FloatArray) -> Estimate:
    """Mean of independent numbers; not a number if there are fewer than two."""
    if len(values) < 2:
        return Estimate(math.nan, math.nan)
    return Estimate(float(values.mean()), float(values.std(ddof=1) / math.sqrt(len(values))))


def ratio_of(one: Estimate, other: Estimate) -> Estimate:
    """Ratio of two independent estimates, to first order in their errors."""
    if not other.value or not math.isfinite(one.value):
        return Estimate(math.nan, math.nan)
    ratio = one.value / other.value
    return Estimate(ratio, math.hypot(one.error, ratio * other.error) / abs(other.value))


def ks(one: FloatArray, other: FloatArray) -> float:
    """Kolmogorov-Smirnov distance of two samples; not a number if one is empty."""
    if not len(one) or not len(other):
        return math.nan
    return float(ks_2samp(one, other, method="asymp").statistic)


def ks_by_chance(one: int, other: int) -> Estimate:
    """Distance of two samples of one law: its mean, and what it exceeds with probability `LEVEL`.

    The asymptotic law of Kolmogorov and Smirnov, for independent samples of these sizes.
    """
    if not one or not other:
        return Estimate(math.nan, math.nan)
    scale = math.sqrt(1.0 / one + 1.0 / other)
    return Estimate(scale * float(kstwobign.mean()), scale * float(kstwobign.isf(LEVEL)))
