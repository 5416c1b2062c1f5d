"""Interpolation error: draws half-way between neighbouring nodes against direct simulation."""

import math
from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.table import Table
from tablegen.accuracy.measure import FIRST_STREAM, SMALLEST_SAMPLES, sample_size
from tablegen.accuracy.metrics import ESTIMATES, Settings, at_resolution
from tablegen.checkpoints import Arrays, stable_number
from tablegen.config.config import AccuracyTargets, Config
from tablegen.config.metric_table import METRICS, worst_share
from tablegen.fitting.node import NodeArrays
from tablegen.model.float_array import FloatArray
from tablegen.simulation.scene_variables import simulated_variables
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes
from tablegen.tables.intervals import EDGE_LIMIT, Grid, Place

#: Directions of the sliced Wasserstein distance: fewer than in a report, for the time.
_DIRECTIONS = 8

#: Metrics that take little time.
CHEAP = tuple(name for name, metric in METRICS.items() if metric.trial_states is None)

#: Smallest number of states on each side for cheap metrics.
SMALLEST_CHEAP_SAMPLES = 25_000

#: Cheap metrics are measured with this share of the states first. The noise of fewer states makes
#: an error larger: it is on average 0.54 of the allowed KS for equal laws, instead of 0.27. So an
#: error that is small enough with few states is small enough, and one above _CERTAINLY_BAD, in
#: units of the allowed error, is too large. All states are needed in between only.
_FIRST_SHARE, _CERTAINLY_BAD = 0.25, 1.6


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
    table = Table(assemble(config, make_axes(config, Grid(*place)), nodes))
    most = max(METRICS[name].trial_states or 0 for name in names)
    if most:
        states = min(sample_size(config.accuracy, SMALLEST_SAMPLES), most)
        return _compare(config, table, condition, states, names)
    states = sample_size(config.accuracy, SMALLEST_CHEAP_SAMPLES)
    errors = _compare(config, table, condition, math.ceil(_FIRST_SHARE * states), names)
    if EDGE_LIMIT < worst_error(errors, config.accuracy)[0] < _CERTAINLY_BAD:
        return _compare(config, table, condition, states, names)
    return errors


def worst_error(errors: Arrays, targets: AccuracyTargets) -> tuple[float, str]:
    """Find the largest error in units of what is allowed, and the name of its metric."""
    largest = {name: float(np.max(values)) for name, values in errors.items()}
    return worst_share(largest, targets.model_dump())


def _compare(
    config: Config,
    table: Table,
    condition: tuple[float, float],
    states: int,
    names: Sequence[str],
) -> Arrays:
    """Compare a number of draws of a table at a condition with as many simulated states."""
    (alpha_deg, speed), seed = condition, config.table.seed
    alpha1 = np.radians(alpha_deg)
    stream = FIRST_STREAM + stable_number(f"trial {alpha_deg!r} {speed!r}", 31)
    simulation = simulate(config, alpha1, speed, states, seed=seed, stream=stream, threads=1)
    direct = at_resolution(simulated_variables(simulation, config.domain.columns), 1)
    del simulation
    # a number of hits that no report uses
    hit = 2**32 - 1
    drawn = table.sample(alpha1, speed, seed=seed, hit=hit, index=np.arange(states), threads=1)
    drawn = at_resolution(drawn, 0)
    with threadpool_limits(limits=1, user_api="blas"):
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
