"""Coarse test of every node of a table, before a fine comparison at some conditions.

A wrong node is fully visible at the node itself, and by a quarter or less in the middle of a cell.
The nodes that look worst are compared finely afterwards, with other random numbers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from sampler.table import Table
from tablegen.accuracy.conditions import Place
from tablegen.accuracy.decision import FALSE_ALARMS
from tablegen.accuracy.measure import ComparedCondition, in_threads
from tablegen.accuracy.noise_corrected import Estimate, Settings, estimated
from tablegen.config.config import AccuracyTargets, Config
from tablegen.config.metric_table import METRICS
from tablegen.progress import bar

#: States a side at each node: they show errors of about 0.03 in a Kolmogorov-Smirnov distance.
SAMPLES = 20_000

#: Number of nodes that are compared finely.
WORST = 4

#: Distances of the coarse test; a classifier learns little from so few states.
NAMES = tuple(name for name, metric in METRICS.items() if not metric.learned)

#: Directions of the sliced Wasserstein distance: fewer than in a fine comparison, to save time.
_DIRECTIONS = 8

#: First number of the nodes as compared conditions; other conditions have those below.
FIRST_NODE = 2**30


@dataclass(frozen=True)
class Screening:
    """Result of the coarse test."""

    #: Number of nodes of the table.
    nodes: int
    #: States a side at each.
    samples: int
    #: Angle [degrees] and speed [m/s] of the nodes that look worst, the worst first.
    suspects: tuple[tuple[float, float], ...]
    #: One line for each distance that some node misses.
    missed: tuple[str, ...]


def screen(
    table: Table,
    config: Config,
    targets: AccuracyTargets,
    *,
    seed: int,
    samples: int = SAMPLES,
    progress: bool = False,
) -> Screening:
    """Compare a table with direct simulation at every node, coarsely; see `measure` for arguments.

    Tables that have the accuracy are said to miss it with a probability of at most half of
    `FALSE_ALARMS`, over all nodes and distances together.
    """
    nodes = [Place(float(a), float(v)) for a in table.alpha_nodes_deg for v in table.speed_nodes]
    settings = Settings(seed % 2**32, _DIRECTIONS)

    def estimates(k: int) -> dict[str, Estimate]:
        node = ComparedCondition(table, config, nodes[k], seed, FIRST_NODE + k)
        return estimated(*node.states(samples), settings, NAMES)

    with bar(progress, "node", total=len(nodes), desc="all nodes") as counted:
        found = in_threads(estimates, range(len(nodes)), counted.update)
    order = np.argsort([-_suspicion(at_node, targets) for at_node in found], kind="stable")
    return Screening(
        nodes=len(nodes),
        samples=samples,
        suspects=tuple((nodes[k].alpha_deg, nodes[k].speed) for k in order[:WORST]),
        missed=tuple(_missed(nodes, found, targets)),
    )


def _suspicion(found: Mapping[str, Estimate], targets: AccuracyTargets) -> float:
    """Give the largest excess over the allowed distance and the noise, in standard errors."""
    excess = [
        (estimate.value - estimate.noise - getattr(targets, name))
        / max(estimate.standard_error, 1e-9)
        for name, estimate in found.items()
    ]
    return float(np.max(np.nan_to_num(excess, nan=np.inf)))


def _missed(
    nodes: Sequence[Place], found: Sequence[Mapping[str, Estimate]], targets: AccuracyTargets
) -> list[str]:
    """Write a line for each distance that is certainly above the allowed one at some node."""
    deviations = float(norm.isf(FALSE_ALARMS / 2 / (len(NAMES) * len(nodes))))
    lines = []
    for name in NAMES:
        allowed, here = getattr(targets, name), [at_node[name] for at_node in found]
        low = np.array([e.held_out - deviations * e.held_out_error for e in here])
        beyond: NDArray[np.bool_] = ~(low <= allowed)
        if beyond.any():
            worst = int(np.argmax(np.where(beyond, [e.value for e in here], -np.inf)))
            lines.append(
                f"{name}: at {int(beyond.sum())} of {len(nodes)} nodes, worst "
                f"{here[worst].value:.4f} at {nodes[worst].alpha_deg:.2f} degrees, "
                f"{nodes[worst].speed:.1f} m/s, where {allowed:g} is allowed"
            )
    return lines
