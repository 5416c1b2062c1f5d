"""Whether a measured accuracy holds, is missed, or cannot be told from noise.

An accuracy is *missed* if the error is above what was asked for even at its lower confidence
limit, and *holds* if it is below at its upper one. Anything else is *undecided*: more states would
tell. `FALSE_ALARMS` is the probability that one table that has the accuracy everywhere is said to
miss it, over all distances, conditions, nodes and looks together (Bonferroni). `FALSE_HOLDS` is the
probability that a table is said to hold, although it misses somewhere that was looked at: to hold,
every single distance must, so that no further correction than for the looks is needed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.stats import norm

from tablegen.accuracy.noise_corrected import Estimate
from tablegen.config.config import AccuracyTargets
from tablegen.config.metric_table import METRICS
from tablegen.config.targets import JointTargets, SpinTargets

#: Probability that a table that has the accuracy is said to miss it; half of it belongs to the
#: test of the nodes, and half to the comparisons.
FALSE_ALARMS = 0.01

#: Probability that a table that misses the accuracy at a condition is said to hold it there.
FALSE_HOLDS = 0.01

#: More states are taken as if so many comparisons were judged together, so that what is measured
#: at a condition does not depend on how many others there are.
_MANY = 100

#: How often a comparison may be made, each time with more states.
LOOKS = 3

#: Largest distances by metric.
Targets = AccuracyTargets | SpinTargets | JointTargets

HOLDS, MISSED, UNDECIDED = "holds", "missed", "undecided"


def deviations_down(comparisons: int) -> float:
    """Count the standard errors down to the lower confidence limit, for so many comparisons."""
    return float(norm.isf(FALSE_ALARMS / 2 / (len(METRICS) * LOOKS * max(1, comparisons))))


def deviations_up() -> float:
    """Count the standard errors up to the upper confidence limit."""
    return float(norm.isf(FALSE_HOLDS / LOOKS))


def limits(name: str, estimate: Estimate, comparisons: int) -> tuple[float, float]:
    """Confidence limits of a distance between the laws of table and direct simulation.

    Parameters
    ----------
    name : str
        Of the distance, as in `AccuracyTargets`.
    estimate : Estimate
    comparisons : int
        How many comparisons are judged together.

    Returns
    -------
    low, high : float
    """
    low = estimate.at_least(deviations_down(comparisons))
    high = estimate.at_most(deviations_up())
    metric = METRICS[name]
    return float(np.clip(low, metric.least, metric.most)), float(min(high, metric.most))


def decide(name: str, estimate: Estimate, allowed: float, comparisons: int) -> str:
    """Say whether one distance is `HOLDS`, `MISSED` or `UNDECIDED`.

    Parameters
    ----------
    name, estimate, comparisons
        As for `limits`.
    allowed : float
        Largest distance that was asked for.
    """
    low, high = limits(name, estimate, comparisons)
    if high <= allowed:
        return HOLDS
    # not a number compares with nothing, and is no accuracy
    return UNDECIDED if low <= allowed and np.isfinite(estimate.value) else MISSED


class Judged(Protocol):
    """What is judged: distances somewhere."""

    @property
    def estimates(self) -> Mapping[str, Estimate]:
        """By metric."""

    @property
    def place(self) -> str:
        """Where, in words."""


def undecided_metrics(comparison: Judged, targets: Targets) -> list[str]:
    """List the distances of a comparison that need more states."""
    return [
        name
        for name, estimate in comparison.estimates.items()
        if decide(name, estimate, getattr(targets, name), _MANY) == UNDECIDED
    ]


@dataclass(frozen=True)
class Verdict:
    """What was missed and what could not be decided, a line for each distance."""

    #: The worst condition of each distance, with what was measured there.
    missed: list[str]
    undecided: list[str]

    @property
    def holds(self) -> bool:
        """Whether every distance holds at every condition that was looked at."""
        return not self.missed and not self.undecided


def judge(
    measured: Sequence[Judged], targets: Targets, together: int | None = None, whose: str = ""
) -> Verdict:
    """Hold what was measured against an accuracy.

    Parameters
    ----------
    measured : sequence of Judged
    targets : Targets
    together : int, optional
        How many comparisons are judged together, if more than these.
    whose : str
        What a line begins with, if not with the metric.
    """
    count = together or len(measured)
    lines: dict[str, list[str]] = {HOLDS: [], MISSED: [], UNDECIDED: []}
    for name in METRICS:
        if not all(name in c.estimates for c in measured):
            continue
        allowed = getattr(targets, name)
        found = [(c, decide(name, c.estimates[name], allowed, count)) for c in measured]
        for outcome in (MISSED, UNDECIDED):
            such = [c for c, decided in found if decided == outcome]
            if such:
                worst = max(such, key=lambda c: c.estimates[name].value)
                others = f" and {len(such) - 1} more" if len(such) > 1 else ""
                lines[outcome].append(f"{whose}{_line(name, worst, allowed, count)}{others}")
    return Verdict(lines[MISSED], lines[UNDECIDED])


def _line(name: str, comparison: Judged, allowed: float, count: int) -> str:
    low, high = limits(name, comparison.estimates[name], count)
    value = comparison.estimates[name].value
    return (
        f"{name}: {value:.4f}, the error {low:.4f} to {high:.4f}, where {allowed:g} is allowed, "
        f"at {comparison.place}"
    )
