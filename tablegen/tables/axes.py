"""Where the nodes of a table are, and the look-up that finds the cell of a condition.

A quantile at a condition is interpolated linearly in the *fractional node index*. That index is
tabulated at equal steps of the angle and of the speed, so the draw finds it without a search and
without knowing which abscissa made it: the square root of the angle (measured: EXPERIMENTS.md),
and for the speed the restitution law at normal impact, exp(-coefficient V^exponent), through
which alone the speed acts.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.tables.intervals import Grid, Middle, Place

#: Monotone function of an angle or speed in which interpolation is linear.
Abscissa = Callable[[FloatArray], FloatArray]

#: Entries that a look-up may have; it gets the fewest that find its nodes.
LOOKUP_SIZES = tuple(2**k + 1 for k in range(11, 18))

#: How far a look-up may be off at a node, where it has a kink between two entries: half of what a
#: table file may be.
_MOST_OFF = 0.01

#: Least distance of two nodes over that of the ends: 32 steps of the largest look-up, in which it
#: finds nodes of any abscissa.
_LEAST_DISTANCE = 32.0 / (LOOKUP_SIZES[-1] - 1)

#: Intervals of the first grid, before any error is measured: equal steps, at most this wide in the
#: square root of the angle in degrees, and for the restitution abscissa so many that it changes by
#: a factor of exp(_SPEED_STEP) at most on average.
_ANGLE_STEP = 0.6
_SPEED_STEP = 0.75

#: Intervals narrower than this share of an axis, in its abscissa, are not halved: what is off there
#: has another cause than the nodes.
_FINEST = 1.0 / 256.0


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
    """Nodes at equal steps of an abscissa, up to ``most`` wide."""
    if last == first:
        return np.array([first])
    ends = axis(np.array([first, last]))
    count = int(np.ceil(abs(ends[1] - ends[0]) / most)) + 1
    nodes = _inverse(axis, first, last, np.linspace(ends[0], ends[1], count))
    nodes[1:-1] = [_rounded(x, (last - first) / count) for x in nodes[1:-1]]
    nodes[0], nodes[-1] = first, last
    return nodes


def _inverse(axis: Abscissa, first: float, last: float, values: FloatArray) -> FloatArray:
    """Points between two ends at which a monotone abscissa has given values."""
    points = np.linspace(first, last, 20_001)
    along = axis(points)
    # np.interp wants a growing abscissa
    sign = 1.0 if along[-1] > along[0] else -1.0
    return np.interp(sign * values, sign * along, points)


def _rounded(value: float, step: float) -> float:
    """Give a number of few digits within a thousandth of a step."""
    return round(value, 3 - int(np.floor(np.log10(step))))


def _speed_axis(config: Config, first: float, last: float) -> Abscissa:
    """Abscissa of the speed, if it can tell the ends apart."""
    ends = config.speed_coordinate(np.array([first, last]))
    if not (np.all(ends > 0.0) and (first == last or ends[0] != ends[1])):
        raise InputError(
            f"domain.speed: got [{first:g}, {last:g}], where the restitution law has no digits "
            "left to tell speeds apart, allowed: a lower end, or table.speed_nodes of your own"
        )
    return config.speed_coordinate


def first_grid(config: Config) -> Grid:
    """Nodes that a configuration names, or a coarse grid to begin with."""
    domain, table = config.domain, config.table
    alpha, speed = np.array(table.alpha_nodes_deg or ()), np.array(table.speed_nodes or ())
    if alpha.size == 0:
        alpha = _equal_steps(np.sqrt, *domain.alpha_deg, _ANGLE_STEP)
    if speed.size == 0:
        axis = _speed_axis(config, *domain.speed)
        ends = axis(np.array(domain.speed))
        count = max(np.ceil(abs(np.log(ends[1] / ends[0])) / _SPEED_STEP), 1.0)
        speed = _equal_steps(axis, *domain.speed, abs(ends[1] - ends[0]) / (count - 1e-9))
    return Grid(tuple(map(float, alpha)), tuple(map(float, speed)))


def middles(config: Config) -> tuple[Middle, Middle]:
    """How intervals of angle and of speed are halved: in the middle of the axis' abscissa.

    Returns
    -------
    tuple of two callables
        They give None on an axis whose nodes the configuration names, and in intervals that are
        fine enough already.
    """
    domain, table = config.domain, config.table
    return (
        _middle(np.sqrt, domain.alpha_deg, table.alpha_nodes_deg is not None),
        _middle(config.speed_coordinate, domain.speed, table.speed_nodes is not None),
    )


def _middle(axis: Abscissa, ends: tuple[float, float], fixed: bool) -> Middle:
    whole = float(abs(np.diff(axis(np.array(ends)))[0]))
    least = _LEAST_DISTANCE * (ends[1] - ends[0])

    def middle(low: float, high: float) -> float | None:
        a, b = axis(np.array([low, high]))
        if fixed or abs(b - a) < 2.0 * _FINEST * whole:
            return None
        half = _halfway(axis, low, high)
        return half if min(half - low, high - half) >= least else None

    return middle


def _lookup(field: str, nodes: FloatArray, axis: Abscissa) -> FloatArray:
    """Fractional node index at equal steps between two ends, piecewise linear in an abscissa.

    Parameters
    ----------
    field : str
        Of the nodes, to open an error message.
    nodes : (n,) float64
    axis : callable
        Grows.
    """
    numbers = np.arange(len(nodes), dtype=np.float64)
    if len(nodes) == 1:
        return np.zeros(LOOKUP_SIZES[0])
    for size in LOOKUP_SIZES:
        points = np.linspace(nodes[0], nodes[-1], size)
        index = np.interp(axis(points), axis(nodes), numbers)
        index[0], index[-1] = numbers[0], numbers[-1]
        if not (np.diff(index) > 0.0).all():
            raise InputError(
                f"{field}: got {nodes[0]:g} to {nodes[-1]:g}, where interpolation has no digits "
                "left to tell values apart, allowed: a range in which rebounds change more"
            )
        if np.abs(np.interp(nodes, points, index) - numbers).max() <= _MOST_OFF:
            return index
    k, least = int(np.diff(nodes).argmin()), _LEAST_DISTANCE * (nodes[-1] - nodes[0])
    raise InputError(
        f"{field}: got {nodes[k]:.9g} and {nodes[k + 1]:.9g}, which a look-up from {nodes[0]:g} to "
        f"{nodes[-1]:g} cannot tell apart, allowed: nodes {least:.2g} apart"
    )


def middle_of(config: Config, place: Place) -> tuple[float, float]:
    """Condition in the middle of the nodes of a place, in the abscissas of the axes."""
    alpha, speed = place
    return (
        alpha[0] if len(alpha) == 1 else _halfway(np.sqrt, *alpha),
        speed[0] if len(speed) == 1 else _halfway(config.speed_coordinate, *speed),
    )


def _halfway(axis: Abscissa, low: float, high: float) -> float:
    a, b = axis(np.array([low, high]))
    return _rounded(float(_inverse(axis, low, high, np.array([0.5 * (a + b)]))[0]), high - low)


def make_axes(config: Config, grid: Grid | None = None) -> Axes:
    """Axes of a grid of nodes.

    Parameters
    ----------
    config : Config
    grid : Grid, optional
        By default the one of `first_grid`.

    Raises
    ------
    InputError
        If no look-up can tell the nodes of an axis apart.
    """
    alpha, speed = (np.array(nodes) for nodes in grid or first_grid(config))
    return Axes(
        alpha_deg=alpha,
        speed=speed,
        alpha_coordinate=_lookup("table.alpha_nodes_deg", alpha, np.sqrt),
        speed_coordinate=_lookup("table.speed_nodes", speed, lambda v: -config.speed_coordinate(v)),
    )
