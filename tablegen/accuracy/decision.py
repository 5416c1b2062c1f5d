"""Decide whether a measured accuracy holds, is missed or stays undecided.

A distance is *missed* if its lower confidence limit is above what is allowed, and *holds* if its
upper limit is within. Otherwise it is *undecided*, and more states are needed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from scipy.stats import norm

from tablegen.accuracy.noise_corrected import Estimate
from tablegen.config.config import AccuracyTargets
from tablegen.config.metric_table import METRICS, metric_of
from tablegen.config.targets import JointTargets, SpinTargets

if TYPE_CHECKING:
    from tablegen.accuracy.comparison import Measured
    from tablegen.accuracy.joint_law import JointComparison
    from tablegen.accuracy.later_hits import LaterHit

#: Probability that a table that has the accuracy is said to miss it, over all distances, conditions
#: and looks together (Bonferroni): half for the nodes, half for the comparisons.
FALSE_ALARMS = 0.01

#: Probability that a table that misses the accuracy at a condition is said to hold it there. Only
#: the looks share it, because every single distance must hold.
FALSE_HOLDS = 0.01

#: Number of comparisons assumed when the number of states is chosen, so that the measurement at a
#: condition does not depend on how many others there are.
_MANY = 100

#: Looks at a comparison, each with more states than the one before.
LOOKS = 3

#: Largest distances allowed, by metric.
Targets = AccuracyTargets | SpinTargets | JointTargets

HOLDS, MISSED, UNDECIDED = "holds", "missed", "undecided"


#: Distances measured somewhere: estimates by metric, and the place in words.
Judged: TypeAlias = "Measured | JointComparison | LaterHit"


@dataclass(frozen=True)
class Verdict:
    """Lines on the distances that are missed or undecided, each with its worst condition."""

    missed: list[str]
    undecided: list[str]

    def __add__(self, other: "Verdict") -> "Verdict":
        return Verdict(self.missed + other.missed, self.undecided + other.undecided)


@cache
def _deviations(comparisons: int) -> tuple[float, float]:
    """Give the standard errors down to the lower and up to the upper confidence limit."""
    down = norm.isf(FALSE_ALARMS / 2 / (len(METRICS) * LOOKS * max(1, comparisons)))
    return float(down), float(norm.isf(FALSE_HOLDS / LOOKS))


def limits(name: str, estimate: Estimate, comparisons: int) -> tuple[float, float]:
    """Compute the confidence limits of a distance; ``comparisons`` are judged together."""
    metric, (down, up) = metric_of(name), _deviations(comparisons)
    low = estimate.held_out - down * estimate.held_out_error
    high = estimate.value + up * estimate.standard_error
    return float(np.clip(low, metric.least, metric.most)), float(min(high, metric.most))


def decide(name: str, estimate: Estimate, allowed: float, comparisons: int) -> str:
    """Decide on one distance: `HOLDS`, `MISSED` or `UNDECIDED`; arguments as for `limits`."""
    low, high = limits(name, estimate, comparisons)
    if high <= allowed:
        return HOLDS
    # NaN compares false and counts as missed
    return UNDECIDED if low <= allowed and np.isfinite(estimate.value) else MISSED


def undecided_metrics(comparison: Judged, targets: Targets) -> list[str]:
    """List the distances of a comparison that need more states."""
    return [
        name
        for name, estimate in comparison.estimates.items()
        if decide(name, estimate, getattr(targets, name), _MANY) == UNDECIDED
    ]


def judge(
    measured: Sequence[Judged], targets: Targets, together: int | None = None, prefix: str = ""
) -> Verdict:
    """Hold measured distances against an accuracy.

    ``together`` is the number of comparisons judged together, if more than these; each line begins
    with ``prefix`` and the name of the metric.
    """
    count = together or len(measured)
    lines: dict[str, list[str]] = {HOLDS: [], MISSED: [], UNDECIDED: []}
    for name in measured[0].estimates if measured else ():
        if not all(name in c.estimates for c in measured):
            continue
        allowed = getattr(targets, name)
        decided = [(c, decide(name, c.estimates[name], allowed, count)) for c in measured]
        for outcome in (MISSED, UNDECIDED):
            found = [c for c, said in decided if said == outcome]
            if found:
                worst = max(found, key=lambda c: c.estimates[name].value)
                low, high = limits(name, worst.estimates[name], count)
                others = f" and {len(found) - 1} more" if len(found) > 1 else ""
                lines[outcome].append(
                    f"{prefix}{name}: {worst.estimates[name].value:.4f} at {worst.place}{others}, "
                    f"where {allowed:g} is allowed; the error without noise is {low:.4f} to "
                    f"{high:.4f}"
                )
    return Verdict(lines[MISSED], lines[UNDECIDED])


def judged_record(
    estimates: Mapping[str, Estimate], targets: Targets, together: int
) -> dict[str, dict[str, Any]]:
    """Give estimates as JSON-ready numbers, with confidence limits and verdict; see `judge`."""
    record = {}
    for name, estimate in estimates.items():
        low, high = limits(name, estimate, together)
        verdict = decide(name, estimate, getattr(targets, name), together)
        record[name] = {**estimate.to_dict(), "low": low, "high": high, "verdict": verdict}
    return record


def verdict_words(missed: Sequence[str], undecided: Sequence[str], accuracy: str) -> str:
    """Say in one sentence whether an accuracy holds; every text and page uses these words.

    ``accuracy`` is "declared accuracy" or "accuracy asked for".
    """
    if missed:
        return f"The {accuracy} is missed:"
    if undecided:
        return f"The {accuracy} is not missed, but the noise leaves open whether it holds:"
    return f"The {accuracy} holds at every condition."
