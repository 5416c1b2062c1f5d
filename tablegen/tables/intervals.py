"""Placement of nodes: intervals are halved until the error between nodes is small enough.

The grid is a product of angles and speeds. The error in the middle of an *edge* between two
neighbouring nodes shows which axis to refine. Errors change little from edge to edge along the
other axis, so edges are measured at the angles and speeds of the first grid. When these are good,
the centres of all cells are measured, and the edges of bad cells; the edges of a grid with one
angle or one speed are its cells. The grid never has more nodes than planned. If not all bad
intervals can be halved, the worst intervals are.
"""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import NamedTuple

#: Limits of errors on edges and in centres, in units of the allowed error. Edges leave room for the
#: other axis. Noise counts as error.
EDGE_LIMIT = 0.85
CENTRE_LIMIT = 1.0

#: Two neighbouring nodes of an axis, or the one node of a place on an edge.
Interval = tuple[float, ...]


class Place(NamedTuple):
    """Nodes around a condition: one or two angles, one or two speeds; it lies in their middle."""

    alpha_deg: Interval
    speed: Interval


class Grid(NamedTuple):
    """Angles [degrees] and speeds [m/s] of the nodes, increasing."""

    alpha_deg: tuple[float, ...]
    speed: tuple[float, ...]

    def edges(self, lines: "Grid") -> list[Place]:
        """List edges between neighbouring angles, then those between neighbouring speeds.

        Edges between angles lie at the speeds of ``lines``, the others at its angles.
        """
        alpha = [Place(pair, (v,)) for pair in pairwise(self.alpha_deg) for v in lines.speed]
        return alpha + [Place((a,), pair) for pair in pairwise(self.speed) for a in lines.alpha_deg]

    def cells(self) -> list[Place]:
        """List the cells between two angles and two speeds."""
        return [Place(a, v) for a in pairwise(self.alpha_deg) for v in pairwise(self.speed)]


#: Middle of an interval on an axis, or None if the interval must not be halved.
Middle = Callable[[float, float], float | None]

#: Errors of the places of a grid, in units of the allowed error.
Measure = Callable[[Grid, list[Place]], Mapping[Place, float]]


class Placement(NamedTuple):
    """Outcome: the grid, and the place with the largest error in it, if any was measured."""

    grid: Grid
    worst: float = 0.0
    where: Place | None = None

    @property
    def reached(self) -> bool:
        """Whether all errors are below the limit."""
        return self.worst <= CENTRE_LIMIT


def refine(
    grid: Grid,
    measure: Measure,
    middle_alpha: Middle,
    middle_speed: Middle,
    most: tuple[int, int],
) -> Placement:
    """Halve intervals until the errors in the middles of all edges and cells are small enough.

    ``measure`` is called again for places that it has measured before; ``most`` are the largest
    numbers of angles and of speeds.
    """
    halve = partial(_halve_intervals, middles=(middle_alpha, middle_speed), most=most)
    limit = EDGE_LIMIT if min(map(len, grid)) > 1 else CENTRE_LIMIT
    first = grid
    while True:
        errors = dict(measure(grid, grid.edges(first)))
        refined = halve(grid, {edge: error for edge, error in errors.items() if error > limit})
        if refined == grid:
            centres = measure(grid, grid.cells())
            bad = {cell: error for cell, error in centres.items() if error > CENTRE_LIMIT}
            around = measure(grid, [edge for cell in bad for edge in _edges_around(cell)])
            refined = halve(grid, _worst_edges(bad, around))
            errors |= {**around, **centres}
        if refined == grid:
            break
        grid = refined
    where = max(errors, key=lambda place: errors[place], default=None)
    return Placement(grid, errors[where] if where else 0.0, where)


def _edges_around(cell: Place) -> list[Place]:
    """List the four edges of a cell."""
    between_angles = [Place(cell.alpha_deg, (v,)) for v in cell.speed]
    return between_angles + [Place((a,), cell.speed) for a in cell.alpha_deg]


def _worst_edges(bad: Mapping[Place, float], edges: Mapping[Place, float]) -> dict[Place, float]:
    """Find the worst edge of each bad cell, with the error of the cell."""
    worst: dict[Place, float] = {}
    for cell, error in bad.items():
        edge = max(_edges_around(cell), key=lambda place: edges[place])
        worst[edge] = max(error, worst.get(edge, 0.0))
    return worst


def _halve_intervals(
    grid: Grid, bad: Mapping[Place, float], middles: tuple[Middle, Middle], most: tuple[int, int]
) -> Grid:
    """Put a node into the middle of the intervals of bad edges, those of the worst first."""
    axes = []
    for k, nodes in enumerate(grid):
        intervals = [edge[k] for edge in sorted(bad, key=lambda edge: -bad[edge])]
        halved = (
            middles[k](*interval) for interval in dict.fromkeys(intervals) if len(interval) > 1
        )
        new = [node for node in halved if node is not None]
        axes.append(tuple(sorted({*nodes, *new[: most[k] - len(nodes)]})))
    return Grid(*axes)
