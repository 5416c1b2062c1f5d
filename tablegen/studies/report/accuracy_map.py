"""Accuracy of a table over its whole range of angles and speeds, against direct simulation."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.compilation.processors import processors
from sampler.table import Table
from tablegen.accuracy.comparison import estimate_all
from tablegen.accuracy.noise_corrected import Estimate
from tablegen.accuracy.samples import FloatArray
from tablegen.config import Config
from tablegen.studies.report.benchmark import Tick
from tablegen.studies.report.budget import Effort
from tablegen.studies.report.direct_method import direct_states
from tablegen.studies.report.method_errors import batch_seed

#: Purposes of random numbers, beside those of the races.
_DIRECT, _OTHER, _TABLE = range(200, 203)

#: Directions of the sliced Wasserstein distance: a map has many points.
_DIRECTIONS = 8


@dataclass(frozen=True)
class Point:
    """A condition of the map and what was measured there."""

    alpha_deg: float
    speed: float
    #: Of each component, in the order of `STATE`.
    ks_components: tuple[float, ...]
    ks: float
    sliced_wasserstein: float
    correlation_error: float
    auc: float
    #: The four distances with their noise told apart.
    estimates: dict[str, Estimate]


@dataclass(frozen=True)
class Atlas:
    """Accuracy map.

    Attributes
    ----------
    alpha_deg, speed : tuple of float
        The grid.
    points : tuple of Point
        All speeds of the first angle, then of the second.
    floor : tuple of Point
        Direct against direct on the diagonal of the grid, with as many states.
    samples : int
        States a side.
    """

    alpha_deg: tuple[float, ...]
    speed: tuple[float, ...]
    points: tuple[Point, ...]
    floor: tuple[Point, ...]
    samples: int

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        return asdict(self)


def grid(table: Table, shape: tuple[int, int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Choose angles [degrees] and speeds in the middle of equal parts.

    Parts are equal in the square root of the angle, because the law changes faster near grazing,
    and in the speed.
    """
    low, high = np.sqrt(np.degrees(table.alpha_range))
    roots = low + (high - low) * (np.arange(shape[0]) + 0.5) / shape[0]
    first, last = table.speed_range
    speeds = first + (last - first) * (np.arange(shape[1]) + 0.5) / shape[1]
    alpha = (np.round(roots**2, 2), np.round(speeds, 1))
    return tuple(np.unique(alpha[0]).tolist()), tuple(np.unique(alpha[1]).tolist())


def _point(
    alpha_deg: float, speed: float, sample: FloatArray, direct: FloatArray, size: int
) -> Point:
    estimates, by_component = estimate_all(sample, direct, 0, _DIRECTIONS, size)
    return Point(
        alpha_deg=alpha_deg,
        speed=speed,
        ks_components=tuple(by_component.tolist()),
        **{name: estimate.value for name, estimate in estimates.items()},
        estimates=estimates,
    )


def make_atlas(table: Table, config: Config, effort: Effort, seed: int, tick: Tick) -> Atlas:
    """Compare a table with direct simulation on a grid of conditions.

    Parameters
    ----------
    table : Table
    config : Config
        What the table claims to represent.
    effort : Effort
    seed : int
    tick : callable
        Called with 1 for each condition.

    Returns
    -------
    Atlas
    """
    alpha, speed = grid(table, effort.grid)
    conditions = [(a, v) for a in alpha for v in speed]
    count = effort.mapped

    def states(k: int, purpose: int) -> FloatArray:
        return direct_states(config, *conditions[k], count, batch_seed(seed, purpose, k), threads=1)

    def against_table(k: int) -> Point:
        drawn = table.sample(
            np.radians(conditions[k][0]),
            conditions[k][1],
            seed=batch_seed(seed, _TABLE, k),
            index=np.arange(count),
            threads=1,
        )
        found = _point(*conditions[k], drawn, states(k, _DIRECT), effort.classified)
        tick(1)
        return found

    def against_direct(k: int) -> Point:
        found = _point(*conditions[k], states(k, _OTHER), states(k, _DIRECT), effort.classified)
        tick(1)
        return found

    diagonal = _diagonal(len(alpha), len(speed))
    with threadpool_limits(limits=1), ThreadPoolExecutor(processors()) as pool:
        points = tuple(pool.map(against_table, range(len(conditions))))
        floor = tuple(pool.map(against_direct, diagonal))
    return Atlas(alpha, speed, points, floor, count)


def _diagonal(rows: int, columns: int) -> list[int]:
    """Numbers of the points of a grid nearest to its diagonal, one a row."""
    return [i * columns + min(columns - 1, i * columns // rows) for i in range(rows)]


def steps(table: Table, effort: Effort) -> int:
    """How often `make_atlas` ticks."""
    alpha, speed = grid(table, effort.grid)
    return len(alpha) * (len(speed) + 1)
