"""What a few nodes are worth in the middle between them, against fresh direct simulation."""

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.table import Table
from tablegen.accuracy.comparison import CLASSIFIED, PROJECTED
from tablegen.accuracy.measure import FIRST_STREAM, sample_size
from tablegen.accuracy.metrics import (
    classifier_auc,
    correlation_error,
    ks_distances,
    sliced_wasserstein,
)
from tablegen.accuracy.scene_variables import simulated_components
from tablegen.config import AccuracyTargets, Config
from tablegen.fitting.node import NodeArrays
from tablegen.refinement.assembly import assemble
from tablegen.refinement.axes import make_axes
from tablegen.refinement.intervals import Grid, Place
from tablegen.simulate import simulate
from tablegen.tasks.runner import SECONDS, Arrays, Stopwatch, stable_number

#: Directions of the sliced Wasserstein distance: fewer than in a report, for the time.
_DIRECTIONS = 8

#: Whoever declares 0.5 itself asks for what noise denies.
_LEAST_AUC = 0.002

#: A distance function this many times what is allowed settles it without a classifier.
_HOPELESS = 2.0


def error_of(found: Arrays, targets: AccuracyTargets, place: Place) -> float:
    """Largest of the distances of a trial, each in units of what is allowed.

    An AUC counts from 0.5, where nothing can be told apart. The sliced Wasserstein distance counts
    in the centres of cells only: near grazing its noise is two thirds of what the standard preset
    allows, which would halve intervals that are good enough.
    """
    errors = [
        float(np.max(found["ks"])) / targets.ks,
        float(found["correlation_error"]) / targets.correlation_error,
        auc_error(found, targets),
    ]
    if len(place.alpha_deg) == len(place.speed) == 2:
        errors.append(float(found["sliced_wasserstein"]) / targets.sliced_wasserstein)
    return max(errors)


def auc_error(found: Arrays, targets: AccuracyTargets) -> float:
    """How far the AUC of a trial is above 0.5, in units of what is allowed."""
    return (float(found["auc"]) - 0.5) / max(targets.auc - 0.5, _LEAST_AUC)


def try_nodes(
    config: Config, place: Place, condition: tuple[float, float], nodes: list[NodeArrays]
) -> Arrays:
    """Compare draws between some nodes with direct simulation.

    Parameters
    ----------
    config : Config
    place : Place
        Where the nodes are.
    condition : tuple (alpha_deg, speed)
        Among the nodes.
    nodes : list of NodeArrays
        Row by row, as `assemble` takes them.

    Returns
    -------
    Arrays
        ``ks`` (6,), ``sliced_wasserstein``, ``correlation_error`` and ``auc``; the last is 0.5
        without a measurement where a distance function is far off anyhow or any AUC is allowed.
    """
    watch, (alpha_deg, speed) = Stopwatch(), condition
    stream = FIRST_STREAM + stable_number(f"trial {alpha_deg!r} {speed!r}", 31)
    samples, seed = sample_size(config.accuracy), config.table.seed
    simulation = simulate(
        config, np.radians(alpha_deg), speed, samples, seed=seed, stream=stream, threads=1
    )
    direct = simulated_components(simulation, config.domain.columns)
    watch.stage("simulation")
    # a report counts its conditions from 0 there
    hit = 2**32 - 1
    table = Table(assemble(config, make_axes(config, Grid(*place)), nodes))
    drawn = table.sample(
        np.radians(alpha_deg), speed, seed=seed, hit=hit, index=np.arange(samples), threads=1
    )
    with threadpool_limits(limits=1, user_api="blas"):
        found = _distances(drawn, direct, config.accuracy, place)
    watch.stage("check")
    return {**found, SECONDS: watch.seconds}


def _distances(
    drawn: NDArray[np.float64],
    direct: NDArray[np.float64],
    targets: AccuracyTargets,
    place: Place,
) -> Arrays:
    """Measure the distances that decide, cheap ones first."""
    found: Arrays = {
        "ks": ks_distances(drawn, direct),
        "sliced_wasserstein": np.array(0.0),
        "correlation_error": np.array(correlation_error(drawn, direct)),
        "auc": np.array(0.5),
    }
    if error_of(found, targets, place) < _HOPELESS:
        found["sliced_wasserstein"] = np.array(
            sliced_wasserstein(drawn[:PROJECTED], direct[:PROJECTED], _DIRECTIONS)
        )
        if targets.auc < 1.0:  # no sample is told from another by more
            found["auc"] = np.array(classifier_auc(drawn[:CLASSIFIED], direct[:CLASSIFIED]))
    return found
