"""Choose the impact conditions at which the accuracy of a table is measured.

The fit of a table is best at its nodes, so conditions lie between them. Angles are in degrees from
the wall, speeds in m/s.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from sampler.errors import InputError
from sampler.table import Table
from tablegen.model.float_array import FloatArray

#: Smallest distance of a condition from a node, over the distance between the two nodes around it.
_MARGIN = 0.2

#: Largest number of conditions whose spread over the plane of angle and speed is optimised. For
#: more conditions the optimisation would take seconds.
_MOST_OPTIMISED_CONDITIONS = 256

#: Angles of the last two conditions of the spin law, over the largest angle.
_STEEP_SHARES = (0.96, 0.99)

#: Separates the random numbers of this module from others with the same seed.
_STREAM_KEY = 2**31


class ComparedCondition(NamedTuple):
    """Impact condition without spin at which a table is compared with direct simulation."""

    #: Impact angle [degrees] and speed [m/s].
    alpha_deg: float
    speed: float
    #: Whether the spin law is compared, in which each particle keeps its own grain; else the
    #: law of first impacts is.
    own: bool = False


def pick_conditions(table: Table, count: int, seed: int) -> list[ComparedCondition]:
    """Choose conditions between nodes, evenly spread over angle and speed, and sorted by angle.

    The conditions are a Latin hypercube of low discrepancy over degrees and m/s. Each one is then
    moved inside its cell, so that its distance from the nodes is at least a fifth of the width of
    the cell. If an axis has one node, all conditions have the value of that node.
    """
    if count == 0:
        return []
    rng = np.random.default_rng([seed, _STREAM_KEY])
    optimization = "random-cd" if 1 < count <= _MOST_OPTIMISED_CONDITIONS else None
    points = qmc.LatinHypercube(2, optimization=optimization, rng=rng).random(count)
    points = points[np.argsort(points[:, 0])]
    alpha = _between_nodes(points[:, 0], table.alpha_nodes_deg)
    speed = _between_nodes(points[:, 1], table.speed_nodes)
    return [ComparedCondition(float(a), float(v)) for a, v in zip(alpha, speed, strict=True)]


def _between_nodes(u: FloatArray, nodes: FloatArray) -> FloatArray:
    """Map numbers u from 0 to 1 to values inside the cells of an axis."""
    if len(nodes) == 1:
        return np.full(len(u), nodes[0])
    value = nodes[0] + u * (nodes[-1] - nodes[0])
    cell = np.clip(np.searchsorted(nodes, value, side="right") - 1, 0, len(nodes) - 2)
    low, width = nodes[cell], nodes[cell + 1] - nodes[cell]
    return low + width * (_MARGIN + (1.0 - 2.0 * _MARGIN) * (value - low) / width)


def pick_own_conditions(table: Table, count: int, seed: int) -> list[ComparedCondition]:
    """Choose conditions of the spin law, as `pick_conditions` does.

    The last two are nearly normal impacts, because there the law changes fastest with the angle.
    """
    places = [place._replace(own=True) for place in pick_conditions(table, count, seed + 1)]
    last = min(90.0, float(table.alpha_nodes_deg[-1]))
    for k, share in enumerate(reversed(_STEEP_SHARES[-count:] if count else ()), 1):
        places[-k] = places[-k]._replace(alpha_deg=last * share)
    return places


def check_conditions(table: Table, places: Sequence[ComparedCondition]) -> list[ComparedCondition]:
    """Return conditions as floats; raise `InputError` if none is given or one is not covered."""
    if not places:
        raise InputError("at", "no condition", "one or more")
    axes = [("alpha", table.alpha_nodes_deg, "degrees")]
    if not table.speed_independent:
        axes.append(("speed", table.speed_nodes, "m/s"))
    for place in places:
        for value, (name, nodes, unit) in zip(place, axes, strict=False):
            low, high = nodes[[0, -1]]
            if not low <= value <= high:
                allowed = f"{low:g} to {high:g} {unit}, which the table covers"
                raise InputError(name, f"{value:.9g} {unit}", allowed)
    return [ComparedCondition(float(p.alpha_deg), float(p.speed)) for p in places]
