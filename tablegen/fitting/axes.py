"""Where the nodes of a table are, and the look-up that finds the cell of a condition.

A quantile at a condition is interpolated linearly in the *fractional node index*. That index is
tabulated at equal steps of the angle and of the speed, so the draw finds it without a search and
without knowing which abscissa made it: the square root of the angle (measured: EXPERIMENTS.md),
and for the speed the restitution law at normal impact, exp(-coefficient V^exponent), through
which alone the speed acts.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from tablegen.config import Config

FloatArray = NDArray[np.float64]

#: Entries of a look-up table.
LOOKUP_SIZE = 2049

#: Widest spacing of angle nodes [degrees], and their spacing near grazing relative to the angle:
#: the undeflected part of the law scales with the angle there.
ANGLE_STEP_DEG = 4.0
GRAZING_STEP = 0.4
LEAST_ANGLE_STEP_DEG = 0.5

#: Spacing of speed nodes in the logarithm of the restitution abscissa.
SPEED_STEP = 0.36


@dataclass(frozen=True)
class Axes:
    """Node grid of a table.

    Attributes
    ----------
    alpha_deg : (n_alpha,) float64
        Impact angles of the nodes [degrees].
    speed : (n_speed,) float64
        Speeds of the nodes [m/s].
    alpha_coordinate, speed_coordinate : (LOOKUP_SIZE,) float64
        Fractional node index at equal steps between the first and the last node.
    """

    alpha_deg: FloatArray
    speed: FloatArray
    alpha_coordinate: FloatArray
    speed_coordinate: FloatArray


def _angle_nodes(first: float, last: float) -> FloatArray:
    """Angle nodes: steps that grow with the angle up to a constant, fitted to the range."""
    nodes = [first]
    while nodes[-1] < last:
        step = np.clip(GRAZING_STEP * nodes[-1], LEAST_ANGLE_STEP_DEG, ANGLE_STEP_DEG)
        nodes.append(nodes[-1] + float(step))
    grid = np.array(nodes)
    # squeeze the steps a little so that the last node falls on the end of the range
    return first + (grid - first) * ((last - first) / max(grid[-1] - first, 1e-300))


def _speed_nodes(config: Config, first: float, last: float) -> FloatArray:
    """Speed nodes equally spaced in the logarithm of the restitution abscissa."""
    ends = config.speed_coordinate(np.array([first, last]))
    if not np.all(ends > 0.0):
        raise InputError(
            f"domain.speed: got [{first:g}, {last:g}], where the restitution law has no digits "
            "left to tell speeds apart, allowed: a lower end, or table.speed_nodes of your own"
        )
    low, high = np.log(ends)
    count = int(np.ceil(abs(high - low) / SPEED_STEP)) + 1
    speeds = np.linspace(first, last, 20_001)
    # the abscissa falls with the speed
    nodes = np.interp(
        -np.linspace(low, high, count), -np.log(config.speed_coordinate(speeds)), speeds
    )
    nodes[0], nodes[-1] = first, last
    return nodes


def _lookup(nodes: FloatArray, abscissa: FloatArray, points: FloatArray) -> FloatArray:
    """Fractional node index of ``points``, piecewise linear in the abscissa of the nodes."""
    if len(nodes) == 1:
        return np.zeros(len(points))
    index = np.interp(points, abscissa, np.arange(len(nodes), dtype=np.float64))
    index[0], index[-1] = 0.0, len(nodes) - 1.0
    return index


def make_axes(config: Config) -> Axes:
    """Place the nodes that a configuration asks for, or the default ones.

    Parameters
    ----------
    config : Config

    Returns
    -------
    Axes
    """
    domain, table = config.domain, config.table
    alpha, speed = np.array(table.alpha_nodes_deg or ()), np.array(table.speed_nodes or ())
    if alpha.size == 0:
        first, last = domain.alpha_deg
        alpha = _angle_nodes(first, last) if last > first else np.array([first])
    if speed.size == 0:
        first, last = domain.speed
        speed = _speed_nodes(config, first, last) if last > first else np.array([first])
    alphas = np.linspace(alpha[0], alpha[-1], LOOKUP_SIZE)
    speeds = np.linspace(speed[0], speed[-1], LOOKUP_SIZE)
    return Axes(
        alpha_deg=alpha,
        speed=speed,
        alpha_coordinate=_lookup(alpha, np.sqrt(alpha), np.sqrt(alphas)),
        speed_coordinate=_lookup(
            speed, -config.speed_coordinate(speed), -config.speed_coordinate(speeds)
        ),
    )
