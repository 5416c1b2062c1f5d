"""Impact conditions at which the accuracy of a table is measured."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from sampler.errors import InputError
from sampler.table import Table
from tablegen.config.config import Config
from tablegen.config.defaults import GENERATE_SPIN_CONDITIONS
from tablegen.model.float_array import FloatArray
from tablegen.simulation.impact_chains import energy_factor, speeds_measured

#: Spin before an impact times a/V, wall axes.
Spin = tuple[float, float, float]

#: Least distance of a condition from a node, as a share of the distance between nodes.
_MARGIN = 0.2

#: Largest number of conditions whose spread over the plane is optimised; more would take seconds.
_OPTIMISED = 256

#: Range of angles [degrees] and largest spin [V/a] of spinning conditions.
_ANGLES_DEG = (5.0, 85.0)
_MOST_SPIN = 2.0

#: Purposes of the random numbers, next to the seed.
_KEY, _SPIN_KEY = 2**31, 2**31 + 2


class Place(NamedTuple):
    """Impact condition at which a table is compared with direct simulation."""

    #: Impact angle [degrees] and speed [m/s].
    alpha_deg: float
    speed: float
    #: None: first-impact law, of particles without spin.
    spin: Spin | None = None


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


def pick_spin_conditions(config: Config, count: int, seed: int) -> list[Place]:
    """Choose conditions of spinning particles, evenly spread and sorted by angle.

    The conditions are a Latin hypercube over the angle from 5 to 85 degrees, the speeds at which
    the law of restitution was measured, the size of the spin up to 2 V/a and its direction. The
    domain of the configuration limits angles and speeds further.
    """
    if count == 0:
        return []
    rng = np.random.default_rng([seed, _SPIN_KEY])
    points = qmc.LatinHypercube(5, seed=rng).random(count)
    points = points[np.argsort(points[:, 0])]
    low, high = (float(np.clip(end, *config.domain.alpha_deg)) for end in _ANGLES_DEG)
    slow, fast = speeds_measured(config)
    size, y, turn = _MOST_SPIN * points[:, 2], 2.0 * points[:, 3] - 1.0, 2.0 * np.pi * points[:, 4]
    radius = np.sqrt(1.0 - y * y)
    spins = size[:, None] * np.column_stack([radius * np.cos(turn), y, radius * np.sin(turn)])
    return [
        Place(low + (high - low) * a, slow + (fast - slow) * v, (x, y, z))
        for a, v, (x, y, z) in zip(*points[:, :2].T.tolist(), spins.tolist(), strict=True)
    ]


def spin_conditions_beside(conditions: int) -> int:
    """Give the number of spinning conditions at which a new table is measured, from the others."""
    return min(GENERATE_SPIN_CONDITIONS, 3 * conditions)


def check_conditions(table: Table, places: Sequence[Place]) -> list[Place]:
    """Refuse conditions that a table does not cover, or none at all, with an `InputError`."""
    if not places:
        raise InputError("at: got no condition, allowed: one or more")
    for place in places:
        for name, value, (low, high), unit in _ranges(table, place):
            if not low <= value <= high:
                raise InputError(
                    f"{name}: got {value:.9g} {unit}, allowed: {low:g} to {high:g} {unit}, which "
                    f"the {'table' if place.spin is None else 'spin law'} covers"
                )
    return [Place(float(p.alpha_deg), float(p.speed), p.spin) for p in places]


def _ranges(table: Table, place: Place) -> Iterator[tuple[str, float, FloatArray, str]]:
    """Name, value, range and unit of the numbers of a condition that have a range."""
    if place.spin is None:
        yield "alpha", place.alpha_deg, table.alpha_nodes_deg[[0, -1]], "degrees"
        yield "speed", place.speed, table.speed_nodes[[0, -1]], "m/s"
        return
    if not table.has_spin:
        raise InputError("at: got a spin, allowed: none, the table has no spin law")
    spin = np.asarray(place.spin, dtype=np.float64)
    if spin.shape != (3,) or not np.isfinite(spin).all():
        raise InputError(f"spin: got {place.spin}, allowed: three finite numbers")
    effective, contents = place.speed * float(energy_factor(spin[None])[0]), table.contents
    yield "alpha", place.alpha_deg, contents["spin/alpha_range_deg"], "degrees"
    yield "speed with the spin's energy", effective, contents["spin/speed_range"], "m/s"
