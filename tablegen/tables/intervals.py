"""Placement of nodes: intervals are halved until the error between nodes is small enough.

The grid is a product of angles and speeds. The error in the middle of an *edge* between two
neighbouring nodes shows which axis to refine. When all edges are good, the centres of the cells are
measured as well.
"""

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import NamedTuple

#: Limits of errors on edges and in centres, in units of the allowed error. Edges leave room for the
#: other axis. Noise counts as error.
EDGE_LIMIT = 0.85
CENTRE_LIMIT = 1.0

#: Rounds after which the refinement ends: the error may have another cause than the nodes.
MOST_ROUNDS = 16

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

    def alpha_edges(self) -> list[Place]:
        """Edges between neighbouring angles, at every speed."""
        return [Place(pair, (v,)) for pair in pairwise(self.alpha_deg) for v in self.speed]

    def speed_edges(self) -> list[Place]:
        """Edges between neighbouring speeds, at every angle."""
        return [Place((a,), pair) for pair in pairwise(self.speed) for a in self.alpha_deg]

    def cells(self) -> list[Place]:
        """Cells between two angles and two speeds."""
        return [Place(a, v) for a in pairwise(self.alpha_deg) for v in pairwise(self.speed)]


#: Middle of an interval on an axis, or None if the interval must not be halved.
Middle = Callable[[float, float], float | None]

#: Errors of the places of a grid, in units of the allowed error.
Measure = Callable[[Grid, list[Place]], Mapping[Place, float]]


class Placement(NamedTuple):
    """Outcome: the grid, the largest error measured in it, and whether it is below the limits."""

    grid: Grid
    worst: float
    reached: bool


def refine(grid: Grid, measure: Measure, middle_alpha: Middle, middle_speed: Middle) -> Placement:
    """Halve intervals until the errors in the middles of all edges and cells are small enough.

    Parameters
    ----------
    grid : Grid
        First grid.
    measure : callable
        Is called again for places that it has measured before.
    middle_alpha, middle_speed : callable
    """
    for _ in range(MOST_ROUNDS):
        errors = dict(measure(grid, grid.alpha_edges() + grid.speed_edges()))
        alphas = {e.alpha_deg for e in grid.alpha_edges() if errors[e] > EDGE_LIMIT}
        speeds = {e.speed for e in grid.speed_edges() if errors[e] > EDGE_LIMIT}
        refined = _halved(grid, alphas, speeds, middle_alpha, middle_speed)
        if refined == grid:
            centres = measure(grid, grid.cells())
            alphas, speeds = _blamed(centres, errors)
            errors |= centres
            refined = _halved(grid, alphas, speeds, middle_alpha, middle_speed)
        if refined == grid:
            break
        grid = refined
    worst = max(errors.values(), default=0.0)
    return Placement(grid, worst, worst <= CENTRE_LIMIT)


def _blamed(
    centres: Mapping[Place, float], edges: Mapping[Place, float]
) -> tuple[set[Interval], set[Interval]]:
    """Intervals of angle and of speed whose edges are the worse ones of a bad cell."""
    alphas, speeds = set(), set()
    for cell, error in centres.items():
        if error <= CENTRE_LIMIT:
            continue
        along_alpha = max(edges[Place(cell.alpha_deg, (v,))] for v in cell.speed)
        along_speed = max(edges[Place((a,), cell.speed)] for a in cell.alpha_deg)
        if along_alpha >= along_speed:
            alphas.add(cell.alpha_deg)
        else:
            speeds.add(cell.speed)
    return alphas, speeds


def _halved(
    grid: Grid,
    alphas: Iterable[Interval],
    speeds: Iterable[Interval],
    middle_alpha: Middle,
    middle_speed: Middle,
) -> Grid:
    """Grid with a node in the middle of every interval that is named and may be halved."""

    def with_middles(
        nodes: tuple[float, ...], intervals: Iterable[Interval], middle: Middle
    ) -> tuple[float, ...]:
        new = (middle(*interval) for interval in intervals)
        return tuple(sorted({*nodes, *(node for node in new if node is not None)}))

    return Grid(
        with_middles(grid.alpha_deg, alphas, middle_alpha),
        with_middles(grid.speed, speeds, middle_speed),
    )
