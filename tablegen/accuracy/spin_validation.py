"""What a validation found of a table's spin law."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tablegen.accuracy.decision import decide, limits
from tablegen.accuracy.noise_corrected import Estimate
from tablegen.accuracy.spin_measure import SpinAccuracy
from tablegen.config.metric_table import JOINT, METRICS
from tablegen.config.targets import SpinTargets


def judged_record(
    estimates: Mapping[str, Estimate], targets: Any, together: int
) -> dict[str, dict[str, Any]]:
    """Estimates for JSON, with confidence limits and verdict of each.

    Parameters
    ----------
    estimates : mapping from metric to Estimate
    targets : Targets
        What each is held against.
    together : int
        How many comparisons are judged together.
    """
    record = {}
    for name, estimate in estimates.items():
        low, high = limits(name, estimate, together)
        verdict = decide(name, estimate, getattr(targets, name), together)
        record[name] = {**estimate.to_dict(), "low": low, "high": high, "verdict": verdict}
    return record


@dataclass(frozen=True)
class SpinValidation:
    """What was measured of a spin law, and what it was held against."""

    measured: SpinAccuracy
    declared: SpinTargets
    asked: SpinTargets
    #: Worst distance of each limit that the file stores, as it says of itself; None if nothing.
    stored: dict[str, float] | None

    @property
    def worst(self) -> dict[str, float]:
        """Largest distance of each limit that was measured, noise included."""
        return {name: max(e.value for e in found) for name, found in self._estimates().items()}

    def surpassed(self, together: int) -> dict[str, float]:
        """Errors that are, noise allowed for, above the worst that the file stores."""
        found = {}
        for name, estimates in self._estimates().items():
            metric = name.removeprefix(JOINT)
            least = max(limits(metric, e, together)[0] for e in estimates)
            # noise may take what is stored below the distance of equal laws
            if self.stored and least > max(self.stored.get(name, least), METRICS[metric].least):
                found[name] = least
        return found

    def _estimates(self) -> dict[str, list[Estimate]]:
        """Estimates of each limit."""
        found: dict[str, list[Estimate]] = {}
        for comparison in self.measured.comparisons:
            for name, estimate in comparison.estimates.items():
                found.setdefault(name, []).append(estimate)
        joint = self.measured.joint
        of_joint = joint.estimates if joint else {}
        return found | {f"{JOINT}{name}": [estimate] for name, estimate in of_joint.items()}

    def to_dict(self, together: int) -> dict[str, Any]:
        """JSON-ready dictionary with every number."""
        joint = self.measured.joint
        over = None
        if joint is not None:
            judged = judged_record(joint.estimates, self.asked.joint, together)
            over = joint.to_dict() | {"estimates": judged}
        return {
            "declared": self.declared.model_dump(),
            "asked": self.asked.model_dump(),
            "stored": self.stored,
            "conditions": [
                c.to_dict() | {"estimates": judged_record(c.estimates, self.asked, together)}
                for c in self.measured.comparisons
            ],
            "joint": over,
        }
