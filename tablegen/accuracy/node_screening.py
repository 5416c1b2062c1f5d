"""A coarse test of every node of a table, before the fine one at some conditions.

A node that is wrong is seen whole at the node itself, and by a quarter or less in the middle of a
cell: so the nodes are where to look. Twenty thousand states a side tell an error about the size of
three hundredths of a Kolmogorov-Smirnov distance, or a tenth of a correlation; the nodes that look
worst, wrong or not, are afterwards compared finely, with other random numbers, so that smaller
errors are found as well.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from sampler.table import Table
from tablegen.accuracy.decision import FALSE_ALARMS
from tablegen.accuracy.measure import ComparedCondition, in_threads
from tablegen.accuracy.noise_corrected import Estimate, Settings, estimated
from tablegen.config.config import AccuracyTargets, Config
from tablegen.config.metric_table import METRICS
from tablegen.progress import bar

#: States a side at each node.
SAMPLES = 20_000

#: Nodes that are compared finely: those that look worst.
WORST = 4

#: Distances that the coarse test takes; a classifier learns little from so few states.
NAMES = tuple(name for name, metric in METRICS.items() if not metric.learned)

#: Directions of the sliced Wasserstein distance: fewer than in a comparison, for the time.
_DIRECTIONS = 8

#: Numbers of the nodes, as compared conditions, begin here; those of conditions are below.
FIRST_NODE = 2**30


@dataclass(frozen=True)
class Screening:
    """What the coarse test found."""

    #: Nodes of the table, all of which were looked at.
    nodes: int
    #: States a side at each.
    samples: int
    #: Tuple of (alpha_deg, speed). The nodes that look worst, the worst first.
    suspects: tuple[tuple[float, float], ...]
    #: One line for each distance that some node misses.
    missed: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready dictionary."""
        record = asdict(self)
        return {name: list(v) if isinstance(v, tuple) else v for name, v in record.items()}


def screen(
    table: Table,
    config: Config,
    targets: AccuracyTargets,
    *,
    seed: int,
    samples: int = SAMPLES,
    progress: bool = False,
) -> Screening:
    """Compare a table with direct simulation at every node, coarsely.

    A table that has the accuracy at all its nodes is said to miss it with a probability of at most
    half of `tablegen.accuracy.decision.FALSE_ALARMS`, over all nodes and distances together.

    Parameters
    ----------
    table : Table
    config : Config
        What the table claims to represent.
    targets : AccuracyTargets
        Accuracy that is asked for.
    seed : int
    samples : int
        States a side at each node.
    progress : bool
        Show a progress bar on standard error.
    """
    nodes = [(float(a), float(v)) for a in table.alpha_nodes_deg for v in table.speed_nodes]

    settings = Settings(seed % 2**32, _DIRECTIONS)

    def estimates(k: int) -> dict[str, Estimate]:
        node = ComparedCondition(table, config, *nodes[k], seed, FIRST_NODE + k)
        return estimated(*node.states(samples), settings, NAMES)

    with bar(progress, "node", total=len(nodes), desc="all nodes") as counted:
        found = in_threads(estimates, range(len(nodes)), counted.update)
    order = np.argsort([-_suspicion(at_node, targets) for at_node in found], kind="stable")
    return Screening(
        nodes=len(nodes),
        samples=samples,
        suspects=tuple(nodes[k] for k in order[:WORST]),
        missed=tuple(_missed(nodes, found, targets)),
    )


def _suspicion(found: Mapping[str, Estimate], targets: AccuracyTargets) -> float:
    """Largest excess over what is allowed and over noise, in standard errors."""
    excess = [
        (estimate.value - estimate.noise - getattr(targets, name))
        / max(estimate.standard_error, 1e-9)
        for name, estimate in found.items()
    ]
    return float(np.max(np.nan_to_num(excess, nan=np.inf)))


def _missed(
    nodes: Sequence[tuple[float, float]],
    found: Sequence[Mapping[str, Estimate]],
    targets: AccuracyTargets,
) -> list[str]:
    """Write a line for each distance that is certainly above what is allowed at some node."""
    deviations = float(norm.isf(FALSE_ALARMS / 2 / (len(NAMES) * len(nodes))))
    lines = []
    for name in NAMES:
        allowed, here = getattr(targets, name), [at_node[name] for at_node in found]
        low = np.array([estimate.at_least(deviations) for estimate in here])
        beyond: NDArray[np.bool_] = ~(low <= allowed)
        if beyond.any():
            worst = int(np.argmax(np.where(beyond, [e.value for e in here], -np.inf)))
            alpha_deg, speed = nodes[worst]
            lines.append(
                f"{name}: at {int(beyond.sum())} of {len(nodes)} nodes, worst "
                f"{here[worst].value:.4f}, where {allowed:g} is allowed, at {alpha_deg:.2f} "
                f"degrees, {speed:.1f} m/s"
            )
    return lines
