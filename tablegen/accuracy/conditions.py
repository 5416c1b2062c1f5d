"""Where the accuracy of a table is measured: conditions spread evenly over angle and speed."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from sampler.arguments import told_apart
from sampler.errors import InputError
from sampler.table import Table

#: A condition keeps this distance from the nodes of an axis, as a share of their distance.
MARGIN = 0.2

#: Up to so many, exchanges make the conditions fill the plane more evenly; it takes seconds beyond.
_EXCHANGED = 256

#: Purpose of the random numbers, next to the seed.
_KEY = 2**31


def pick_conditions(table: Table, count: int, seed: int) -> list[tuple[float, float]]:
    """Choose conditions between nodes, evenly spread over angle [degrees] and speed [m/s].

    A Latin hypercube: of ``count`` equal parts of the range of angles each has one condition, and
    of the range of speeds too; exchanges of low discrepancy spread the pairs. A condition is then
    moved inside its cell so that it keeps a fifth of the cell's width from its nodes.

    Returns
    -------
    list of (alpha_deg, speed)
        By increasing angle. An axis of one node has only that value.
    """
    if count == 0:
        return []
    rng = np.random.default_rng([seed, _KEY])
    exchanges = "random-cd" if 1 < count <= _EXCHANGED else None
    points = qmc.LatinHypercube(2, optimization=exchanges, seed=rng).random(count)
    points = points[np.argsort(points[:, 0])]
    alpha = _between_nodes(points[:, 0], table.alpha_nodes_deg)
    speed = _between_nodes(points[:, 1], table.speed_nodes)
    return [(float(a), float(v)) for a, v in zip(alpha, speed, strict=True)]


def _between_nodes(u: NDArray[np.float64], nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Map numbers from 0 to 1 to the range of an axis, and inside of its cells."""
    if len(nodes) == 1:
        return np.full(len(u), nodes[0])
    value = nodes[0] + u * (nodes[-1] - nodes[0])
    cell = np.clip(np.searchsorted(nodes, value, side="right") - 1, 0, len(nodes) - 2)
    low, width = nodes[cell], nodes[cell + 1] - nodes[cell]
    return low + width * (MARGIN + (1.0 - 2.0 * MARGIN) * (value - low) / width)


def check_conditions(
    table: Table, conditions: Sequence[tuple[float, float]], count: int | None = None
) -> list[tuple[float, float]]:
    """Refuse conditions that the table does not cover.

    Parameters
    ----------
    table : Table
    conditions : sequence of (alpha_deg, speed)
        Impact angles [degrees] and speeds [m/s].
    count : int, optional
        How many there are with those that are checked elsewhere.

    Returns
    -------
    list of (alpha_deg, speed)

    Raises
    ------
    InputError
        If one is outside of the table's range, or there is none.
    """
    if (len(conditions) if count is None else count) == 0:
        raise InputError("at: got no condition, allowed: one or more")
    for alpha_deg, speed in conditions:
        for name, value, nodes, unit in (
            ("alpha", alpha_deg, table.alpha_nodes_deg, "degrees"),
            ("speed", speed, table.speed_nodes, "m/s"),
        ):
            if not nodes[0] <= value <= nodes[-1]:
                raise InputError(
                    f"{name}: got {told_apart(value, nodes[0], nodes[-1], digits=6)} {unit}, "
                    f"allowed: {nodes[0]:g} to {nodes[-1]:g} {unit}, which the table covers"
                )
    return [(float(a), float(v)) for a, v in conditions]
