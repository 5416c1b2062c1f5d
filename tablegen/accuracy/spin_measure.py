"""Accuracy of a spin law: at some conditions, and over the impacts that occur in chains."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.formats.channels import STATE
from sampler.formats.layout import ACCURACY
from sampler.table import Table
from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.decision import Verdict, judge
from tablegen.accuracy.joint_law import JointComparison, compare_chains, drawn_from
from tablegen.accuracy.measure import ComparedCondition, compared_side_by_side
from tablegen.accuracy.spin_conditions import SpinCondition
from tablegen.config.config import Config
from tablegen.config.metric_table import JOINT, METRICS
from tablegen.config.targets import SpinTargets
from tablegen.progress import bar

#: Numbers of spinning conditions begin here, and the seed of each differs by its number: those of
#: other conditions and of nodes are elsewhere.
FIRST_SPINNING = 2**29


@dataclass(frozen=True)
class SpinAccuracy:
    """What was measured of a spin law."""

    #: At spinning conditions.
    comparisons: list[Comparison]
    #: Over the impacts of chains; None if that was not measured.
    joint: JointComparison | None

    @property
    def count(self) -> int:
        """How many comparisons that are."""
        return len(self.comparisons) + (self.joint is not None)

    def judged(self, targets: SpinTargets, together: int) -> Verdict:
        """Hold it against an accuracy, together with so many comparisons in all."""
        verdict = judge(self.comparisons, targets, together, whose="spin ")
        if self.joint is None:
            return verdict
        joint = judge([self.joint], targets.joint, together, whose=f"spin {JOINT}")
        return Verdict(verdict.missed + joint.missed, verdict.undecided + joint.undecided)


def measure_spin(
    table: Table,
    config: Config,
    conditions: Sequence[SpinCondition],
    *,
    seed: int,
    samples: int | None = None,
    targets: SpinTargets | None = None,
    joint: bool = True,
    progress: bool = False,
) -> SpinAccuracy:
    """Compare a table's spin law with direct simulation.

    Parameters
    ----------
    table : Table
        With a spin law.
    config : Config
        What the table claims to represent.
    conditions : sequence of SpinCondition
    seed : int
        Of the simulation, of the draws and of the metrics.
    samples : int, optional
        States a side at first, at each condition and over the chains; by default as many as the
        accuracy needs.
    targets : SpinTargets, optional
        Accuracy that is asked for; the declared one by default.
    joint : bool
        Whether to measure over the impacts of chains.
    progress : bool
        Show a progress bar on standard error.
    """
    targets = targets or config.spin_targets
    places = [
        ComparedCondition(table, config, c.alpha_deg, c.speed, seed, FIRST_SPINNING + k, c.spin)
        for k, c in enumerate(conditions)
    ]
    found = compared_side_by_side(places, samples, targets, progress, "spinning")
    over = None
    if joint:
        with threadpool_limits(limits=1), bar(progress, total=1, desc="chains") as counted:
            draw = drawn_from(table, seed)
            over = compare_chains(draw, config, seed=seed, samples=samples, targets=targets.joint)
            counted.update()
    return SpinAccuracy(found, over)


def spin_accuracy_datasets(measured: SpinAccuracy | None) -> dict[str, NDArray[np.float64]]:
    """Datasets of the group ``spin_accuracy`` of a table file; empty ones if nothing was measured.

    Parameters
    ----------
    measured : SpinAccuracy or None
    """
    comparisons = measured.comparisons if measured else []
    joint = measured.joint if measured else None
    columns: dict[str, list[Any]] = {
        "alpha_deg": [c.alpha_deg for c in comparisons],
        "speed": [c.speed for c in comparisons],
        "spin": [c.spin for c in comparisons],
        **{name: [c.distances()[name] for c in comparisons] for name in METRICS},
        "joint_ks": [joint.estimates["ks"].by_variable] if joint else [],
        "joint_auc": [joint.estimates["auc"].value] if joint else [],
    }
    wide = {"spin": 3, "ks": len(STATE), "joint_ks": len(STATE)}
    found = {name: np.array(values, dtype=np.float64) for name, values in columns.items()}
    return {
        f"{ACCURACY}{name}": values.reshape(-1, wide[name]) if name in wide else values
        for name, values in found.items()
    }
