"""Nodes of a table, and the look-up that finds the cell of a condition.

A quantile at a condition is interpolated linearly in the *fractional node index*. That index is
tabulated at equal steps of the angle and of the speed, so the draw finds it without a search.

- Between two angles it follows the means of rebounds (`tablegen.tables.angle_path`). Intervals are
  divided in the square root of the angle.
- Between two speeds it is linear in the abscissa in which the law of restitution is linear:
  exp(-coefficient V^exponent), a power of V, or V of a tabulated law.

The angles and speeds of a tabulated law, where it bends, are nodes.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from sampler.errors import InputError
from tablegen.config.config import Config, TableSettings
from tablegen.config.pairs import MaterialPair
from tablegen.model.float_array import FloatArray
from tablegen.tables.angle_path import path_index
from tablegen.tables.intervals import Grid, Middle, Place

#: Monotone function of an angle or speed in which interpolation is linear.
Abscissa = Callable[[FloatArray], FloatArray]

#: Allowed numbers of entries of a look-up; the smallest that finds all nodes is taken.
LOOKUP_SIZES = tuple(2**k + 1 for k in range(11, 18))

#: Largest error of a look-up at a node: half of the error that the file format allows.
_MOST_OFF = 0.01

#: Smallest distance of two nodes over that of the ends: 32 steps of the largest look-up.
_LEAST_DISTANCE = 32.0 / (LOOKUP_SIZES[-1] - 1)

#: Largest steps of the first grid: in the square root of the angle in degrees, and in the logarithm
#: of the abscissa of the speed.
_ANGLE_STEP = 0.6
_SPEED_STEP = 0.75

#: Most new nodes over the intervals of the first grid, of angles and of speeds; and in a grid of
#: one speed, whose nodes cost little.
_NEW_NODES, _NEW_NODES_OF_ONE_SPEED = (1, 2), (2, 0)

#: Narrowest interval that is halved, as a share of the axis in its abscissa.
_NARROWEST = 1.0 / 256.0


@dataclass(frozen=True)
class Axes:
    """Node grid of a table."""

    #: (n_alpha,) float64. Impact angles of the nodes [degrees].
    alpha_deg: FloatArray
    #: (n_speed,) float64. Speeds of the nodes [m/s].
    speed: FloatArray
    #: (n,) float64, n one of `LOOKUP_SIZES`. Fractional node index at equal steps between the first
    #: and the last node.
    alpha_coordinate: FloatArray
    speed_coordinate: FloatArray


def _equal_steps(axis: Abscissa, first: float, last: float, most: float) -> FloatArray:
    """Place nodes at equal steps of an abscissa, at most ``most`` wide."""
    if last == first:
        return np.array([first])
    ends = axis(np.array([first, last]))
    count = int(np.ceil(abs(ends[1] - ends[0]) / most)) + 1
    nodes = _inverse(axis, first, last, np.linspace(ends[0], ends[1], count))
    nodes[1:-1] = [_rounded(x, (last - first) / count) for x in nodes[1:-1]]
    nodes[0], nodes[-1] = first, last
    return nodes


def _inverse(axis: Abscissa, first: float, last: float, values: FloatArray) -> FloatArray:
    """Find the points between two ends at which a monotone abscissa has given values."""
    points = np.linspace(first, last, 20_001)
    along = axis(points)
    # np.interp needs an increasing abscissa
    sign = 1.0 if along[-1] > along[0] else -1.0
    return np.interp(sign * values, sign * along, points)


def _rounded(value: float, step: float) -> float:
    """Round to few digits, within a thousandth of a step."""
    return round(value, 3 - int(np.floor(np.log10(step))))


def first_grid(config: Config) -> Grid:
    """Make the grid that a configuration names, or else a coarse one.

    If no law depends on the speed, the coarse grid has one speed.
    """
    domain, table, pair = config.domain, config.table, config.pair
    alpha, speed = np.array(table.alpha_nodes_deg or ()), np.array(table.speed_nodes or ())
    if alpha.size == 0:
        alpha = _first_angles(pair, domain.alpha_deg)
    if speed.size == 0 and not pair.restitution.depends_on_speed:
        speed = np.array(domain.speed[1:])
    elif speed.size == 0:
        speed = _first_speeds(pair, domain.speed)
    return Grid(tuple(map(float, alpha)), tuple(map(float, speed)))


def _first_angles(pair: MaterialPair, ends: tuple[float, float]) -> FloatArray:
    """Place angles at equal steps between the ends and the angles at which a tabulated law bends.

    A particle that does not spin meets the wall at the angle of its impact.
    """
    parts = [_equal_steps(np.sqrt, a, b, _ANGLE_STEP) for a, b in _pieces(pair, "angle_deg", ends)]
    return np.unique(np.concatenate([*parts, ends[:1]]))


def _first_speeds(pair: MaterialPair, ends: tuple[float, float]) -> FloatArray:
    """Place speeds at equal steps between the ends and the speeds at which a tabulated law bends.

    The first contact of a particle that does not spin has the speed of its impact. A range whose
    ends the abscissa cannot distinguish is refused.
    """
    axis, (first, last) = pair.restitution.coordinate, ends
    whole = axis(np.array(ends))
    if not (np.all(whole != 0.0) and (first == last or whole[0] != whole[1])):
        raise InputError(
            "domain.speed",
            f"[{first:g}, {last:g}]",
            problem="where the restitution hardly depends on the speed any more",
            remedy="lower the upper end, or give table.speed_nodes",
        )
    parts = [np.array(ends[:1])]
    for low, high in _pieces(pair, "speed", ends):
        low_value, high_value = axis(np.array([low, high]))
        count = max(np.ceil(abs(np.log(high_value / low_value)) / _SPEED_STEP), 1.0)
        parts.append(_equal_steps(axis, low, high, abs(high_value - low_value) / (count - 1e-9)))
    return np.unique(np.concatenate(parts))


def _pieces(
    pair: MaterialPair, field: str, ends: tuple[float, float]
) -> Iterator[tuple[float, float]]:
    """Split a range at the nodes of the tabulated laws of a pair."""
    laws, (first, last) = (pair.restitution, pair.resistance), ends
    bends = {node for law in laws for node in getattr(law, field, None) or ()}
    pieces, apart = [first], _LEAST_DISTANCE * (last - first)
    for node in sorted(bends):
        if pieces[-1] + apart <= node <= last - apart:
            pieces.append(node)
    return pairwise([*pieces, last] if first < last else [first])


def most_nodes(table: TableSettings, grid: Grid) -> tuple[int, int]:
    """Find the largest numbers of angles and of speeds to which a first grid may be refined."""
    fixed = table.alpha_nodes_deg is not None, table.speed_nodes is not None
    shares = _NEW_NODES if len(grid.speed) > 1 else _NEW_NODES_OF_ONE_SPEED
    sizes = zip(map(len, grid), fixed, shares, strict=True)
    a, v = (n if named else n + share * (n - 1) for n, named, share in sizes)
    return a, v


def middles(config: Config) -> tuple[Middle, Middle]:
    """Make functions that halve intervals of angle and of speed in the middle of their abscissa.

    They return None on an axis whose nodes the configuration names, and for narrow intervals.
    """
    domain, table = config.domain, config.table
    return (
        _middle(np.sqrt, domain.alpha_deg, table.alpha_nodes_deg is not None),
        _middle(config.pair.restitution.coordinate, domain.speed, table.speed_nodes is not None),
    )


def _middle(axis: Abscissa, ends: tuple[float, float], fixed: bool) -> Middle:
    whole = float(abs(np.diff(axis(np.array(ends)))[0]))
    least = _LEAST_DISTANCE * (ends[1] - ends[0])

    def middle(low: float, high: float) -> float | None:
        a, b = axis(np.array([low, high]))
        if fixed or abs(b - a) < 2.0 * _NARROWEST * whole:
            return None
        half = _halfway(axis, low, high)
        return half if min(half - low, high - half) >= least else None

    return middle


def _lookup(field: str, nodes: FloatArray, index_at: Abscissa) -> FloatArray:
    """Tabulate the fractional node index, a function of the angle or the speed, at equal steps."""
    numbers = np.arange(len(nodes), dtype=np.float64)
    if len(nodes) == 1:
        return np.zeros(LOOKUP_SIZES[0])
    for size in LOOKUP_SIZES:
        points = np.linspace(nodes[0], nodes[-1], size)
        index = index_at(points)
        index[0], index[-1] = numbers[0], numbers[-1]
        if not (np.diff(index) > 0.0).all():
            raise InputError(
                field,
                f"{nodes[0]:g} to {nodes[-1]:g}",
                problem="where rebounds hardly change",
                remedy="give a range in which rebounds change more",
            )
        if np.abs(np.interp(nodes, points, index) - numbers).max() <= _MOST_OFF:
            return index
    k, least = int(np.diff(nodes).argmin()), _LEAST_DISTANCE * (nodes[-1] - nodes[0])
    raise InputError(
        field,
        f"{nodes[k]:.9g} and {nodes[k + 1]:.9g}",
        f"nodes at least {least:.2g} apart, from {nodes[0]:g} to {nodes[-1]:g}",
    )


def middle_condition(config: Config, place: Place) -> tuple[float, float]:
    """Find the condition in the middle of a place, in the abscissas of the axes."""
    alpha, speed = place
    return (
        alpha[0] if len(alpha) == 1 else _halfway(np.sqrt, *alpha),
        speed[0] if len(speed) == 1 else _halfway(config.pair.restitution.coordinate, *speed),
    )


def _halfway(axis: Abscissa, low: float, high: float) -> float:
    a, b = axis(np.array([low, high]))
    return _rounded(float(_inverse(axis, low, high, np.array([0.5 * (a + b)]))[0]), high - low)


def make_axes(config: Config, grid: Grid | None = None) -> Axes:
    """Make the axes of a grid, by default that of `first_grid`; refuses nodes too close."""
    alpha, speed = (np.array(nodes) for nodes in grid or first_grid(config))
    path, numbers = path_index(config, alpha), np.arange(len(speed), dtype=np.float64)
    axis = config.pair.restitution.coordinate

    def speed_index(values: FloatArray) -> FloatArray:
        # the abscissa falls
        return np.interp(-axis(values), -axis(speed), numbers)

    return Axes(
        alpha_deg=alpha,
        speed=speed,
        alpha_coordinate=_lookup(
            "table.alpha_nodes_deg", alpha, lambda values: np.interp(values, *path)
        ),
        speed_coordinate=_lookup("table.speed_nodes", speed, speed_index),
    )
