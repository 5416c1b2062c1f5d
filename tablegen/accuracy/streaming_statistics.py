"""Streaming moments and histograms of a direct simulation: in memory that does not grow with it.

Batches are simulated, summarised and forgotten. Summaries are merged in the order of the particles,
whichever thread was first, so the result is the same to the last bit for any number of threads.
"""

from dataclasses import dataclass
from functools import partial, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.formats.channels import STATE
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import Condition
from tablegen.model.jit import kernel
from tablegen.progress import bar
from tablegen.simulation.batches import ParticleRun, batches
from tablegen.simulation.simulate import Simulation, check_run
from tablegen.tasks.side_by_side import side_by_side

Counts = NDArray[np.int64]

#: Ranges of the histograms, by variable. Without spin before the impact, energy keeps u, v, w
#: within the first three; the slimmest particles of the default population reach |omega| = 4.
LOW: FloatArray = np.array([-1.0, 0.0, -1.0, -4.0, -4.0, -4.0])
HIGH: FloatArray = np.array([1.0, 1.0, 1.0, 4.0, 4.0, 4.0])
BINS = 200

#: Rebounds are counted by their number of collisions, 1 to 5 and more.
COLLISION_LABELS = ("1", "2", "3", "4", "5", ">5")


@dataclass(frozen=True)
class RunStatistics:
    """Statistics of a run of n rebounds; variables in the order of `STATE`."""

    #: Number of rebounds n.
    count: int
    #: Shape (6,).
    mean: FloatArray
    #: Shape (6, 6). Sums over the run of products of deviations from the mean.
    comoment: FloatArray
    #: Shape (6,).
    minimum: FloatArray
    maximum: FloatArray
    #: Shape (6, BINS). Rebounds in bins of equal width from `LOW` to `HIGH`; a bin holds its lower
    #: end, the last one both.
    histogram: Counts
    #: Shape (6, 2). Rebounds below and above the range of the histogram.
    outside: Counts
    #: Shape (6,). Rebounds with 1, 2, 3, 4, 5 and more collisions.
    collision_counts: Counts
    #: Collisions of all rebounds together.
    collisions: int
    most_collisions: int
    #: Shape (2,). Mean translational and rotational energy over the energy before the impact.
    energy: FloatArray

    @property
    def covariance(self) -> FloatArray:
        """Covariance matrix, (6, 6): sums over n, not n - 1, so that one rebound has one."""
        return self.comoment / self.count

    @property
    def standard_deviation(self) -> FloatArray:
        """Standard deviation of each variable, (6,): root of the covariance's diagonal."""
        return np.sqrt(np.diag(self.covariance))

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain lists and numbers, by the names of the variables.

        Returns
        -------
        dict
            What ``json`` can write; shares of the numbers of collisions are in per cent.
        """

        def named(values: FloatArray) -> dict[str, Any]:
            return dict(zip(STATE, values.tolist(), strict=True))

        percent = 100.0 * self.collision_counts / self.count
        return {
            "count": self.count,
            "mean": named(self.mean),
            "std": named(self.standard_deviation),
            "min": named(self.minimum),
            "max": named(self.maximum),
            "columns": list(STATE),
            "covariance": self.covariance.tolist(),
            "collisions_percent": dict(zip(COLLISION_LABELS, percent.tolist(), strict=True)),
            "collisions_mean": self.collisions / self.count,
            "collisions_max": self.most_collisions,
            "energy_translational": float(self.energy[0]),
            "energy_rotational": float(self.energy[1]),
            "histogram": {
                name: {
                    "low": float(LOW[i]),
                    "high": float(HIGH[i]),
                    "below": int(self.outside[i, 0]),
                    "above": int(self.outside[i, 1]),
                    "counts": self.histogram[i].tolist(),
                }
                for i, name in enumerate(STATE)
            },
        }


@kernel
def _moments(state: FloatArray, mean: FloatArray, comoment: FloatArray) -> None:
    """Mean (6,) and sums of products of deviations (6, 6) of (n, 6) states, in two passes."""
    count = state.shape[0]
    for j in range(6):
        total = 0.0
        for i in range(count):
            total += state[i, j]
        mean[j] = total / count
    comoment[:] = 0.0
    for i in range(count):
        for j in range(6):
            for k in range(j + 1):
                comoment[j, k] += (state[i, j] - mean[j]) * (state[i, k] - mean[k])
    for j in range(6):
        for k in range(j):
            comoment[k, j] = comoment[j, k]


@kernel
def _bins(
    state: FloatArray, low: FloatArray, high: FloatArray, histogram: Counts, outside: Counts
) -> None:
    """Count (n, 6) states into (6, bins) bins, and those (6, 2) below and above them."""
    bins = histogram.shape[1]
    for i in range(state.shape[0]):
        for j in range(6):
            value = state[i, j]
            if value < low[j]:
                outside[j, 0] += 1
            elif value > high[j]:
                outside[j, 1] += 1
            else:
                place = int((value - low[j]) / (high[j] - low[j]) * bins)
                histogram[j, min(place, bins - 1)] += 1


def summarise(state: FloatArray, collisions: Counts, energy: FloatArray) -> RunStatistics:
    """Statistics of rebounds at hand.

    Parameters
    ----------
    state : (n, 6) float64
        Finite; n is 1 or more.
    collisions : (n,) int64
    energy : (n, 2) float64
    """
    mean, comoment = np.empty(6), np.empty((6, 6))
    histogram, outside = np.zeros((6, BINS), dtype=np.int64), np.zeros((6, 2), dtype=np.int64)
    _moments(state, mean, comoment)
    _bins(state, LOW, HIGH, histogram, outside)
    last = len(COLLISION_LABELS)
    return RunStatistics(
        count=len(state),
        mean=mean,
        comoment=comoment,
        minimum=state.min(axis=0),
        maximum=state.max(axis=0),
        histogram=histogram,
        outside=outside,
        collision_counts=np.bincount(np.minimum(collisions, last), minlength=last + 1)[1:],
        collisions=int(collisions.sum()),
        most_collisions=int(collisions.max()),
        energy=energy.mean(axis=0),
    )


def merge(first: RunStatistics, second: RunStatistics) -> RunStatistics:
    """Statistics of two runs together.

    Means and products of deviations are updated, never differences of large sums (Chan, Golub
    and LeVeque, "Updating formulae and a pairwise algorithm for computing sample variances",
    1979), so nothing cancels however long the run is.
    """
    count = first.count + second.count
    share = second.count / count
    step = second.mean - first.mean
    shift = np.outer(step, step) * (first.count * share)
    return RunStatistics(
        count=count,
        mean=first.mean + step * share,
        comoment=first.comoment + second.comoment + shift,
        minimum=np.minimum(first.minimum, second.minimum),
        maximum=np.maximum(first.maximum, second.maximum),
        histogram=first.histogram + second.histogram,
        outside=first.outside + second.outside,
        collision_counts=first.collision_counts + second.collision_counts,
        collisions=first.collisions + second.collisions,
        most_collisions=max(first.most_collisions, second.most_collisions),
        energy=first.energy + (second.energy - first.energy) * share,
    )


def statistics_of(simulation: Simulation) -> RunStatistics:
    """Statistics of a simulation at hand, the same to the last bit as `simulate_statistics`."""
    state, collisions, energy = simulation.state, simulation.collisions, simulation.energy
    parts = (summarise(state[p], collisions[p], energy[p]) for p in batches(len(state)))
    return reduce(merge, parts)


def _batch_statistics(run: ParticleRun, part: slice) -> RunStatistics:
    """Simulate the particles of a part of a run; their statistics."""
    size = part.stop - part.start
    state, energy, kind = np.empty((size, 6)), np.empty((size, 2)), np.empty((size, 3))
    collisions = np.empty(size, dtype=np.int64)
    run.simulate(part.start, state, collisions, kind, energy)
    run.check_finite(part.start, state, energy)
    return summarise(state, collisions, energy)


def simulate_statistics(
    pair: MaterialPair,
    population: Population,
    condition: Condition,
    count: int,
    *,
    seed: int,
    stream: int = 0,
    threads: int | None = None,
    progress: bool = False,
) -> RunStatistics:
    """Simulate ``count`` rebounds and keep their statistics only.

    The particles are those of `simulate_condition` with the same arguments.
    Memory does not depend on ``count``.

    Parameters
    ----------
    pair : MaterialPair
        Laws of restitution (6) and of resistance to sliding (7).
    population : Population
        Shapes and aspect ratios.
    condition : Condition
        From `tablegen.simulation.simulate.make_condition`.
    count : int
        Number of particles, positive.
    seed : int
        0 to 2**64 - 1.
    stream : int
        0 to 2**32 - 1; keeps conditions that share a seed independent.
    threads : int, optional
        Default: one a processor. The result does not depend on it.
    progress : bool
        Show a progress bar on standard error.

    Raises
    ------
    InputError
        If an argument is out of range.
    RuntimeError
        If a particle is still in contact after 10**8 collisions, or is not finite.
    """
    workers = check_run(count, seed, stream, threads)
    work = partial(_batch_statistics, ParticleRun(pair, population, condition, seed, stream))
    total: RunStatistics | None = None
    with bar(progress, "rebound", total=count, unit_scale=True, desc="simulating") as counted:
        # no more are under way than keep the threads busy, or summaries would pile up behind a
        # slow batch
        for part in side_by_side(work, batches(count), workers, ahead=2 * workers):
            total = part if total is None else merge(total, part)
            counted.update(part.count)
    assert total is not None  # a run has at least one batch
    return total
