"""Interpolation error: draws half-way between neighbouring nodes against direct simulation."""

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.table import Table
from tablegen.accuracy.measure import FIRST_STREAM, SMALLEST_SAMPLES, sample_size
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

#: Metrics that take little time.
CHEAP = tuple(name for name, metric in METRICS.items() if metric.trial_states is None)

#: Smallest number of states on each side for cheap metrics.
SMALLEST_CHEAP_SAMPLES = 25_000


def interpolation_errors(
    config: Config,
    place: Place,
    condition: tuple[float, float],
    nodes: list[NodeArrays],
    names: Sequence[str] = tuple(METRICS),
) -> Arrays:
    """Compare draws at a condition (alpha_deg, speed) between the nodes of a place with simulation.

    Nodes come row by row, as for `assemble`. Returns values of the metrics that are named. An
    expensive metric has the value of equal laws where any value is allowed.
    """
    alpha_deg, speed = condition
    stream = FIRST_STREAM + stable_number(f"trial {alpha_deg!r} {speed!r}", 31)
    smallest = SMALLEST_CHEAP_SAMPLES if set(names) <= set(CHEAP) else SMALLEST_SAMPLES
    samples, seed = sample_size(config.accuracy, smallest), config.table.seed
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
        drawn, direct = at_resolution(drawn, 0), at_resolution(direct, 1)
        return {name: _distance(name, drawn, direct, config.accuracy) for name in names}


def _distance(
    name: str, drawn: FloatArray, direct: FloatArray, targets: AccuracyTargets
) -> FloatArray:
    """Measure a metric of blurred states, unless its largest possible value is allowed."""
    metric = METRICS[name]
    most = metric.trial_states
    if most and getattr(targets, name) >= metric.most:
        return np.array(metric.least)
    estimate = ESTIMATES[name](drawn[:most], direct[:most], Settings(0, _DIRECTIONS))
    if name == "correlation_error":
        # that of a few rare rebounds is mostly noise
        return np.array(max(estimate.value - estimate.error, 0.0))
    return np.asarray(estimate.distance)
