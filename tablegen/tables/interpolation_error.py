"""Interpolation error: draws half-way between neighbouring nodes against direct simulation."""

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.table import Table
from tablegen.accuracy.measure import FIRST_STREAM, sample_size
from tablegen.accuracy.metrics import ESTIMATES, Settings, at_resolution
from tablegen.checkpoints import Arrays, stable_number
from tablegen.config.config import AccuracyTargets, Config
from tablegen.config.metric_table import METRICS
from tablegen.fitting.node import NodeArrays
from tablegen.model.float_array import FloatArray
from tablegen.simulation.scene_variables import simulated_variables
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes
from tablegen.tables.intervals import Grid, Place

#: Directions of the sliced Wasserstein distance: fewer than in a report, for the time.
_DIRECTIONS = 8

#: Expensive metrics are skipped where a cheap one is this many times the allowed value.
_SKIP_ABOVE = 2.0

#: Metrics that count on the edges of cells; in their centres all do.
ON_EDGES = tuple(name for name, metric in METRICS.items() if metric.on_edges)


def error_of(
    distances: Arrays, targets: AccuracyTargets, names: Sequence[str] = tuple(METRICS)
) -> tuple[float, str]:
    """Find the largest of some metrics, in units of its allowed value, and its name."""

    def share(name: str) -> float:
        return METRICS[name].share(float(np.max(distances[name])), getattr(targets, name))

    return max((share(name), name) for name in names)


def interpolation_errors(
    config: Config, place: Place, condition: tuple[float, float], nodes: list[NodeArrays]
) -> Arrays:
    """Compare draws at a condition (alpha_deg, speed) between the nodes of a place with simulation.

    Nodes come row by row, as for `assemble`. Returns values of `METRICS`. An expensive metric has
    the value of equal laws where a cheap one is far off, or where any value is allowed.
    """
    alpha_deg, speed = condition
    stream = FIRST_STREAM + stable_number(f"trial {alpha_deg!r} {speed!r}", 31)
    samples, seed = sample_size(config.accuracy), config.table.seed
    simulation = simulate(
        config, np.radians(alpha_deg), speed, samples, seed=seed, stream=stream, threads=1
    )
    direct = simulated_variables(simulation, config.domain.columns)
    # a number of hits that no report uses
    hit = 2**32 - 1
    table = Table(assemble(config, make_axes(config, Grid(*place)), nodes))
    drawn = table.sample(
        np.radians(alpha_deg), speed, seed=seed, hit=hit, index=np.arange(samples), threads=1
    )
    with threadpool_limits(limits=1, user_api="blas"):
        return _distances(drawn, direct, config.accuracy)


def _distances(drawn: FloatArray, direct: FloatArray, targets: AccuracyTargets) -> Arrays:
    """Measure the cheap metrics, then the expensive ones if they can decide."""
    drawn, direct = at_resolution(drawn, 0), at_resolution(direct, 1)

    def distance(name: str, most: int | None = None) -> FloatArray:
        estimate = ESTIMATES[name](drawn[:most], direct[:most], Settings(0, _DIRECTIONS))
        if name == "correlation_error":
            # that of a few rare rebounds is mostly noise
            return np.array(max(estimate.value - estimate.error, 0.0))
        return np.asarray(estimate.distance)

    distances: Arrays = {
        name: np.array(m.least) if m.trial_states else distance(name) for name, m in METRICS.items()
    }
    if error_of(distances, targets)[0] < _SKIP_ABOVE:
        for name, metric in METRICS.items():
            # the largest possible value allows any difference
            if metric.trial_states and getattr(targets, name) < metric.most:
                distances[name] = distance(name, metric.trial_states)
    return distances
