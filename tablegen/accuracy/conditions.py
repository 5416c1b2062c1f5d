"""Impact conditions at which the accuracy of a table is measured."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from sampler.errors import InputError
from sampler.table import Table
from tablegen.model.float_array import FloatArray

#: Least distance of a condition from a node, as a share of the distance between nodes.
_MARGIN = 0.2

#: Largest number of conditions whose spread over the plane is optimised; more would take seconds.
_OPTIMISED = 256

#: Angles of the last two conditions of particles with their own grain, over the largest.
_STEEP = (0.96, 0.99)

#: Purpose of the random numbers, next to the seed.
_KEY = 2**31


class Place(NamedTuple):
    """Impact condition, without spin, at which a table is compared with direct simulation."""

    #: Impact angle [degrees] and speed [m/s].
    alpha_deg: float
    speed: float
    #: Whether particles have their own grain, by the spin law; else the first-impact law.
    own: bool = False


def pick_conditions(table: Table, count: int, seed: int) -> list[Place]:
    """Choose conditions between nodes, evenly spread over angle and speed and sorted by angle.

    The conditions are a Latin hypercube of low discrepancy over degrees and m/s. Each is then moved
    inside its cell to keep a fifth of the cell's width from the nodes. An axis of one node has only
    that value.
    """
    if count == 0:
        return []
    rng = np.random.default_rng([seed, _KEY])
    optimization = "random-cd" if 1 < count <= _OPTIMISED else None
    points = qmc.LatinHypercube(2, optimization=optimization, seed=rng).random(count)
    points = points[np.argsort(points[:, 0])]
    alpha = _between_nodes(points[:, 0], table.alpha_nodes_deg)
    speed = _between_nodes(points[:, 1], table.speed_nodes)
    return [Place(float(a), float(v)) for a, v in zip(alpha, speed, strict=True)]


def _between_nodes(u: FloatArray, nodes: FloatArray) -> FloatArray:
    """Map numbers from 0 to 1 to the inside of the cells of an axis."""
    if len(nodes) == 1:
        return np.full(len(u), nodes[0])
    value = nodes[0] + u * (nodes[-1] - nodes[0])
    cell = np.clip(np.searchsorted(nodes, value, side="right") - 1, 0, len(nodes) - 2)
    low, width = nodes[cell], nodes[cell + 1] - nodes[cell]
    return low + width * (_MARGIN + (1.0 - 2.0 * _MARGIN) * (value - low) / width)


def pick_own_conditions(table: Table, count: int, seed: int) -> list[Place]:
    """Choose conditions as `pick_conditions` for particles with their own grain.

    The last two are nearly normal impacts, where the law changes fastest.
    """
    places = [place._replace(own=True) for place in pick_conditions(table, count, seed + 1)]
    last = min(90.0, float(table.alpha_nodes_deg[-1]))
    for k, share in enumerate(reversed(_STEEP[-count:] if count else ()), 1):
        places[-k] = places[-k]._replace(alpha_deg=last * share)
    return places


def check_conditions(table: Table, places: Sequence[Place]) -> list[Place]:
    """Refuse conditions that a table does not cover, or none at all, with an `InputError`."""
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
    return [Place(float(p.alpha_deg), float(p.speed)) for p in places]
