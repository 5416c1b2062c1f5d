"""Fit a grid of nodes that has the accuracy that a configuration asks for.

First the size of the mixture is chosen, by fits that are compared with direct simulation at their
own condition, without interpolation. Then `tablegen.tables.intervals` places the nodes, from the
interpolation errors between neighbouring nodes.
"""

from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import NamedTuple

import numpy as np

from tablegen.checkpoints import SECONDS, Arrays, Stopwatch, Task, TaskRunner
from tablegen.config.config import Config
from tablegen.fitting.node import NodeArrays, fit_node
from tablegen.fitting.resolution import LADDER, Resolution, resolution
from tablegen.tables.axes import first_grid, middle_of, middles
from tablegen.tables.interpolation_error import (
    error_of,
    interpolation_errors,
    share_of_allowed,
)
from tablegen.tables.intervals import Grid, Place, Placement, refine

#: Share of the allowed AUC (above 0.5) for the mixture; the rest is for interpolation.
_CAPACITY = 0.66

#: The error of a mixture of K components falls as K to minus this power, measured.
_DECAY = 0.75

#: Conditions at which the mixture is chosen: these shares of the square root of the angle, at the
#: slowest and the fastest speed.
_PROBES = (0.1, 0.6, 0.98)


class RefinedGrid(NamedTuple):
    """Outcome: sizes, nodes row by row, and how the placement ended."""

    size: Resolution
    placement: Placement
    nodes: list[NodeArrays]


def _node_task(config: Config, alpha_deg: float, speed: float, size: Resolution) -> Arrays:
    """Fit a node; returns its arrays and the seconds of each stage."""
    watch = Stopwatch()
    arrays = fit_node(config, alpha_deg, speed, size, watch)
    return {**arrays._asdict(), SECONDS: watch.seconds}


def node_key(alpha_deg: float, speed: float, size: Resolution) -> str:
    """Key of the task that fits a node."""
    return f"node {alpha_deg!r} {speed!r} {tuple(size)}"


class NodeCache:
    """Nodes and interpolation errors of one configuration; each is computed once."""

    def __init__(self, config: Config, runner: TaskRunner) -> None:
        self.config, self.runner = config, runner
        self._nodes: dict[tuple[Resolution, float, float], NodeArrays] = {}
        self._errors: dict[tuple[Resolution, Place], Arrays] = {}

    def fit(self, size: Resolution, conditions: Iterable[tuple[float, float]]) -> list[NodeArrays]:
        """Fit the nodes at conditions (alpha_deg, speed); returns them in this order."""
        wanted = list(conditions)
        missing = [c for c in dict.fromkeys(wanted) if (size, *c) not in self._nodes]
        tasks = {
            node_key(a, v, size): Task(_node_task, (self.config, a, v, size)) for a, v in missing
        }
        made = self.runner.run("fitting nodes", tasks)
        for (a, v), arrays in zip(missing, made.values(), strict=True):
            node = {name: arrays[name] for name in NodeArrays._fields}
            self._nodes[size, a, v] = NodeArrays(**node)
        return [self._nodes[(size, *c)] for c in wanted]

    def errors(
        self, size: Resolution, places: Iterable[Place], error: Callable[[Place, Arrays], float]
    ) -> dict[Place, float]:
        """Measure the errors in the middles of places, in units of the allowed error."""
        wanted = list(places)
        missing = [p for p in dict.fromkeys(wanted) if (size, p) not in self._errors]
        self.fit(size, (c for place in missing for c in product(*place)))
        tasks, owner = {}, {}
        for place in missing:
            nodes = self.fit(size, product(*place))
            arguments = (self.config, place, middle_of(self.config, place), nodes)
            key = f"trial {tuple(place)!r} {tuple(size)}"
            tasks[key], owner[key] = Task(interpolation_errors, arguments), place
        known = {p: error(p, self._errors[size, p]) for p in wanted if p not in missing}

        def on_result(key: str, arrays: Arrays) -> None:
            self._errors[size, owner[key]] = arrays
            known[owner[key]] = error(owner[key], arrays)
            self.runner.note = f"worst error {max(known.values()):.2f} of what is allowed"

        self.runner.run("checking", tasks, on_result)
        return {place: known[place] for place in wanted}


def fit_nodes(config: Config, grid: Grid, runner: TaskRunner) -> list[NodeArrays]:
    """Fit all nodes of a grid, in the resolution that the configuration names.

    Returns
    -------
    list of NodeArrays
        Row by row: all speeds of the first angle, then of the second.
    """
    return NodeCache(config, runner).fit(resolution(config), product(*grid))


def refine_grid(cache: NodeCache) -> RefinedGrid:
    """Choose the sizes, place the nodes and fit them.

    Parameters
    ----------
    cache : NodeCache
        Of the configuration; nodes that it has are not fitted again.

    Returns
    -------
    RefinedGrid
        Nodes and sizes that the configuration names are taken as they are; if it names both lists
        of nodes, no interpolation error is measured.
    """
    config = cache.config
    size, grid = resolution(config), first_grid(config)
    fixed = config.table.alpha_nodes_deg is not None and config.table.speed_nodes is not None
    if config.table.components is None:
        size = _choose_components(cache)
    if fixed:
        placement = Placement(grid, float("nan"), True)
    else:

        def measure(_: Grid, places: list[Place]) -> Mapping[Place, float]:
            return cache.errors(size, places, lambda p, found: error_of(found, config.accuracy, p))

        placement = refine(grid, measure, *middles(config))
    return RefinedGrid(size, placement, cache.fit(size, product(*placement.grid)))


def _choose_components(cache: NodeCache) -> Resolution:
    """Find the smallest mixture that leaves room for interpolation at every probe."""
    config = cache.config
    (low, high), speeds = np.sqrt(config.domain.alpha_deg), first_grid(config).speed
    angles = dict.fromkeys(round(float((low + x * (high - low)) ** 2), 6) for x in _PROBES)
    probes = [Place((a,), (v,)) for a in angles for v in sorted({speeds[0], speeds[-1]})]
    least = 0
    for rung, components in enumerate(LADDER):
        size = resolution(config, components)
        if rung < least:
            continue
        error = max(
            cache.errors(
                size, probes, lambda _, found: share_of_allowed("auc", found, config.accuracy)
            ).values()
        )
        if error <= _CAPACITY:
            break
        # go on where the measured decay leads, or a little below
        wanted = components * (error / _CAPACITY) ** (1.0 / _DECAY)
        least = sum(rung_size < 0.8 * wanted for rung_size in LADDER)
    return size
