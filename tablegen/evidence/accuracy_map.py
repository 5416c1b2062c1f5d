"""Accuracy of a table over its whole range of angles and speeds, against direct simulation."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sampler.table import Table
from tablegen.accuracy.comparison import Measured
from tablegen.accuracy.measure import in_threads
from tablegen.accuracy.noise_corrected import Settings, estimated
from tablegen.config.config import Config
from tablegen.evidence.benchmark import Tick
from tablegen.evidence.budget import Budget
from tablegen.evidence.method_errors import batch_seed
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import simulate

#: Purposes of random numbers, apart from those of the benchmarks.
_DIRECT, _OTHER, _TABLE = range(200, 203)

#: Directions of the sliced Wasserstein distance: a map has many points.
_DIRECTIONS = 8


@dataclass(frozen=True)
class AccuracyMap:
    """Accuracy map."""

    #: The grid.
    alpha_deg: tuple[float, ...]
    speed: tuple[float, ...]
    #: All speeds of the first angle, then of the second.
    points: tuple[Measured, ...]
    #: Direct against direct on the diagonal of the grid, with as many states.
    floor: tuple[Measured, ...]
    #: States a side.
    samples: int

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for JSON; of metrics by variable the largest, and all of them."""
        points = {name: [_record(p) for p in getattr(self, name)] for name in ("points", "floor")}
        return vars(self) | points


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


def _record(point: Measured) -> dict[str, Any]:
    found: dict[str, Any] = {"alpha_deg": point.alpha_deg, "speed": point.speed}
    for name, estimate in point.estimates.items():
        if estimate.by_variable:
            found[f"{name}_components"] = estimate.by_variable
        found[name] = estimate.value
    return found | {"estimates": {n: e.to_dict() for n, e in point.estimates.items()}}


def make_accuracy_map(
    table: Table, config: Config, budget: Budget, seed: int, tick: Tick
) -> AccuracyMap:
    """Compare a table with direct simulation on a grid of conditions.

    Parameters
    ----------
    table : Table
    config : Config
        What the table claims to represent.
    budget : Budget
    seed : int
    tick : callable
        Called with 1 for each condition.
    """
    alpha, speed = grid(table, budget.grid)
    conditions = [(np.radians(a), v) for a in alpha for v in speed]
    count, settings = budget.mapped, Settings(0, _DIRECTIONS, budget.classified)

    def direct(k: int, purpose: int) -> FloatArray:
        key = batch_seed(seed, purpose, k)
        return simulate(config, *conditions[k], count, seed=key, threads=1).state

    def drawn(k: int) -> FloatArray:
        index, key = np.arange(count), batch_seed(seed, _TABLE, k)
        return table.sample(*conditions[k], seed=key, index=index, threads=1)

    def measured(k: int, states: FloatArray) -> Measured:
        a, v = alpha[k // len(speed)], speed[k % len(speed)]
        return Measured(a, v, estimated(states, direct(k, _DIRECT), settings))

    every, diagonal = range(len(conditions)), _diagonal(len(alpha), len(speed))
    points = in_threads(lambda k: measured(k, drawn(k)), every, tick)
    floor = in_threads(lambda k: measured(k, direct(k, _OTHER)), diagonal, tick)
    return AccuracyMap(alpha, speed, tuple(points), tuple(floor), count)


def _diagonal(rows: int, columns: int) -> list[int]:
    """Numbers of the points of a grid nearest to its diagonal, one a row."""
    return [i * columns + min(columns - 1, i * columns // rows) for i in range(rows)]


def steps(table: Table, budget: Budget) -> int:
    """How often `make_accuracy_map` ticks."""
    alpha, speed = grid(table, budget.grid)
    return len(alpha) * (len(speed) + 1)
