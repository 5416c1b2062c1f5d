"""Fit a grid of nodes that has the accuracy that a configuration asks for.

First the size of the mixture is chosen, by fits that are compared with direct simulation at their
own condition, without interpolation. Then `tablegen.tables.intervals` places the nodes, from the
interpolation errors between neighbouring nodes.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from tablegen.checkpoints import Arrays, Task, TaskRunner
from tablegen.config.config import Config
from tablegen.config.metric_table import METRICS
from tablegen.fitting.node import NodeArrays, fit_node
from tablegen.fitting.resolution import Resolution
from tablegen.tables.axes import middle_condition, middles
from tablegen.tables.interpolation_error import CHEAP, interpolation_errors, worst_error
from tablegen.tables.intervals import CENTRE_LIMIT, Grid, Interval, Place, Placement, refine
from tablegen.tables.plan import Plan

#: What helps where the planned nodes do not; more is allowed only where little is missed.
_REMEDY = "give more components, alpha_nodes_deg or speed_nodes in [table]"
_REMEDY_IF_LITTLE_IS_MISSED, _LITTLE = "allow more in [accuracy], or ", 2.0

#: Share of the allowed AUC (above 0.5) for the mixture; the rest is for interpolation.
_CAPACITY = 0.66

#: The error of a mixture of K components falls as K to minus this power, measured.
_DECAY = 0.75

#: Conditions at which the mixture is chosen: these shares of the square root of the angle, at the
#: slowest and the fastest speed.
_PROBES = (0.1, 0.6, 0.98)


class RefinedGrid(NamedTuple):
    """Outcome: sizes, nodes row by row, how the placement ended, and lines on what it misses."""

    size: Resolution
    placement: Placement
    nodes: list[NodeArrays]
    missed: list[str]


def _node_task(config: Config, alpha_deg: float, speed: float, size: Resolution) -> Arrays:
    """Fit a node; returns its arrays."""
    return fit_node(config, alpha_deg, speed, size)._asdict()


def node_key(alpha_deg: float, speed: float, size: Resolution) -> str:
    """Make the key of the task that fits a node."""
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
        fitted = self.runner.run("fitting nodes", tasks)
        for (a, v), arrays in zip(missing, fitted.values(), strict=True):
            node = {name: arrays[name] for name in NodeArrays._fields}
            self._nodes[size, a, v] = NodeArrays(**node)
        return [self._nodes[(size, *c)] for c in wanted]

    def errors(
        self,
        size: Resolution,
        places: Iterable[Place],
        names: Sequence[str],
        stage: str,
    ) -> dict[Place, float]:
        """Measure errors by some metrics in the middles of places, in units of the allowed error.

        Metrics that were measured there before count, too. ``stage`` begins the note of the
        progress.
        """
        wanted = list(dict.fromkeys(places))
        known = {place: self._errors.setdefault((size, place), {}) for place in wanted}
        missing = {p: [n for n in names if n not in known[p]] for p in wanted}
        self.fit(size, (c for place in wanted if missing[place] for c in product(*place)))
        tasks, owner = {}, {}
        for place in wanted:
            if missing[place]:
                nodes = self.fit(size, product(*place))
                condition = middle_condition(self.config, place)
                arguments = (self.config, place, condition, nodes, missing[place])
                key = f"trial {tuple(place)!r} {tuple(size)} {', '.join(missing[place])}"
                tasks[key], owner[key] = Task(interpolation_errors, arguments), place
        self.runner.note = stage

        def share(place: Place) -> float:
            return worst_error(known[place], self.config.accuracy)[0]

        def on_result(key: str, arrays: Arrays) -> None:
            place = owner[key]
            # without the processor time of a piece
            known[place].update({name: arrays[name] for name in missing[place]})
            worst = max((place for place in wanted if known[place]), key=share)
            self.runner.note = f"{stage}worst {self.error_text(size, worst)}"

        self.runner.run("checking", tasks, on_result)
        return {place: share(place) for place in wanted}

    def error_text(self, size: Resolution, place: Place) -> str:
        """Describe where the error in the middle of a place is, by which metric, and how large."""
        distances, targets = self._errors[size, place], self.config.accuracy
        share, name = worst_error(distances, targets)
        alpha_deg, speed = middle_condition(self.config, place)
        value = METRICS[name].text(float(np.max(distances[name])))
        return (
            f"{name} {value} at {alpha_deg:.4g} degrees, {speed:.4g} m/s, "
            f"{share:.2f} times the allowed {getattr(targets, name):g}"
        )


def refine_grid(plan: Plan, cache: NodeCache) -> RefinedGrid:
    """Choose the size, place the nodes and fit those that the cache does not have.

    If the configuration names both lists of nodes, no interpolation error is measured.
    """
    config, rounds, missed = plan.config, dict[Grid, int](), list[str]()
    size = plan.sizes[0] if len(plan.sizes) == 1 else _choose_size(plan, cache)

    def measure(grid: Grid, places: list[Place]) -> Mapping[Place, float]:
        number = rounds.setdefault(grid, len(rounds) + 1)
        nodes, planned = (" x ".join(map(str, n)) for n in (map(len, grid), plan.most))
        stage = f"round {number}, {nodes} nodes of at most {planned}, "
        errors = cache.errors(size, places, CHEAP, stage)
        return errors | cache.errors(size, _cells_to_classify(grid, errors), tuple(METRICS), stage)

    named = config.table.alpha_nodes_deg is not None and config.table.speed_nodes is not None
    placement = Placement(plan.grid)
    if not named:
        placement = refine(plan.grid, measure, *middles(config), plan.most)
    if placement.where is not None and not placement.reached:
        remedy = _REMEDY_IF_LITTLE_IS_MISSED * (placement.worst <= _LITTLE) + _REMEDY
        missed = [f"{cache.error_text(size, placement.where)}, half-way between nodes; {remedy}"]
    nodes, cache.runner.note = cache.fit(size, product(*placement.grid)), ""
    return RefinedGrid(size, placement, nodes, missed)


def _cells_to_classify(grid: Grid, errors: Mapping[Place, float]) -> list[Place]:
    """Choose the cells in which all metrics are measured, after the cheap ones.

    The classifier takes 4 to 40 times as long as the cheap metrics. So it is asked where they hold,
    in the worst cell between each two angles: the joint law changes little from speed to speed.
    """
    cells = dict[Interval, Place]()
    for place in sorted(errors, key=lambda place: errors[place]):
        is_cell = all(len(place[k]) == min(2, len(nodes)) for k, nodes in enumerate(grid))
        if is_cell and errors[place] <= CENTRE_LIMIT:
            cells[place.alpha_deg] = place
    return list(cells.values())


def _choose_size(plan: Plan, cache: NodeCache) -> Resolution:
    """Find the smallest mixture that leaves room for interpolation at every probe."""
    (low, high), speeds = np.sqrt(plan.config.domain.alpha_deg), plan.grid.speed
    angles = dict.fromkeys(round(float((low + x * (high - low)) ** 2), 6) for x in _PROBES)
    probes = [Place((a,), (v,)) for a in angles for v in sorted({speeds[0], speeds[-1]})]
    least = 0.0
    for size in plan.sizes:
        if size.components < least and size != plan.sizes[-1]:
            continue
        stage = f"mixture of {size.components}, "
        error = max(cache.errors(size, probes, ("auc",), stage).values())
        if error <= _CAPACITY:
            break
        # go on where the measured decay leads, or a little below
        least = 0.8 * size.components * (error / _CAPACITY) ** (1.0 / _DECAY)
    return size
