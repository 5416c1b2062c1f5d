"""Moments and histograms of a direct simulation, in memory that does not grow with its length.

Batches are simulated, summarised and merged in the order of the particles, so that the result is
the same to the last bit for any number of threads.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial, reduce
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.formats.channels import STATE
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import Condition
from tablegen.progress import bar
from tablegen.simulation.batches import ParticleRun, batches
from tablegen.simulation.simulate import Simulation, check_run

Counts = NDArray[np.int64]

#: Ranges of the histograms, by variable. Without spin before the impact, energy keeps u, v, w
#: within the first three; the slimmest particles of the default population reach |omega| = 4.
LOW: FloatArray = np.array([-1.0, 0.0, -1.0, -4.0, -4.0, -4.0])
HIGH: FloatArray = np.array([1.0, 1.0, 1.0, 4.0, 4.0, 4.0])
BINS = 200

#: Labels of the numbers of collisions, 1 to 5 and more.
COLLISION_LABELS = ("1", "2", "3", "4", "5", ">5")

#: Batches a thread that are simulated before their statistics are merged.
_AHEAD = 8


@dataclass(frozen=True)
class RunStatistics:
    """Statistics of n rebounds; variables in the order of `STATE`."""

    count: int
    #: Shape (6,).
    mean: FloatArray
    #: Shape (6, 6). Sums of products of deviations from the mean.
    comoment: FloatArray
    #: Shape (6,).
    minimum: FloatArray
    maximum: FloatArray
    #: Shape (6, BINS). Bins of equal width from `LOW` to `HIGH`; the last one includes both ends.
    histogram: Counts
    #: Shape (6, 2). Rebounds below and above the range of the histogram.
    outside: Counts
    #: Shape (6,). Rebounds with 1, 2, 3, 4, 5 and more collisions.
    collision_counts: Counts
    #: Sum and largest number of collisions.
    collisions: int
    most_collisions: int
    #: Shape (2,). Mean translational and rotational energy over the initial kinetic energy.
    energy: FloatArray

    @property
    def covariance(self) -> FloatArray:
        """Covariance matrix (6, 6), normalised by n."""
        return self.comoment / self.count

    @property
    def standard_deviation(self) -> FloatArray:
        """Standard deviation of each variable, (6,)."""
        return np.sqrt(np.diag(self.covariance))

    def to_dict(self) -> dict[str, Any]:
        """Give JSON-ready numbers by the names of the variables; collisions in per cent."""

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
            "histogram": {name: self._histogram(i) for i, name in enumerate(STATE)},
        }

    def _histogram(self, i: int) -> dict[str, Any]:
        """Give the histogram of one variable."""
        below, above = self.outside[i].tolist()
        ends = {"low": float(LOW[i]), "high": float(HIGH[i]), "below": below, "above": above}
        return ends | {"counts": self.histogram[i].tolist()}


def summarise(state: FloatArray, collisions: Counts, energy: FloatArray) -> RunStatistics:
    """Summarise n >= 1 rebounds: state (n, 6), collisions (n,), energy (n, 2), all finite."""
    mean = state.mean(axis=0)
    deviation = state - mean
    ends = zip(state.T, LOW, HIGH, strict=True)
    last = len(COLLISION_LABELS)
    return RunStatistics(
        count=len(state),
        mean=mean,
        # not a matrix product, whose last bits depend on the threads of the library
        comoment=np.einsum("ni,nj->ij", deviation, deviation),
        minimum=state.min(axis=0),
        maximum=state.max(axis=0),
        histogram=np.array([np.histogram(x, BINS, (low, high))[0] for x, low, high in ends]),
        outside=np.column_stack([(state < LOW).sum(axis=0), (state > HIGH).sum(axis=0)]),
        collision_counts=np.bincount(np.minimum(collisions, last), minlength=last + 1)[1:],
        collisions=int(collisions.sum()),
        most_collisions=int(collisions.max()),
        energy=energy.mean(axis=0),
    )


def merge(first: RunStatistics, second: RunStatistics) -> RunStatistics:
    """Merge the statistics of two runs without differences of large sums, so that nothing cancels.

    Source: Chan, Golub, LeVeque, "Updating formulae and a pairwise algorithm for computing sample
    variances" (1979).
    """
    count = first.count + second.count
    share, step = second.count / count, second.mean - first.mean
    return RunStatistics(
        count=count,
        mean=first.mean + step * share,
        comoment=first.comoment + second.comoment + np.outer(step, step) * (first.count * share),
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
    """Summarise a whole simulation, with the same bits as `simulate_statistics`."""
    state, collisions, energy = simulation.state, simulation.collisions, simulation.energy
    parts = (summarise(state[p], collisions[p], energy[p]) for p in batches(len(state)))
    return reduce(merge, parts)


def _batch_statistics(run: ParticleRun, part: slice) -> RunStatistics:
    """Simulate and summarise the particles of one batch."""
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
    """Simulate rebounds and keep only their statistics.

    Arguments, particles and errors are those of `tablegen.simulation.simulate.simulate_condition`.
    Memory does not depend on ``count``.
    """
    workers = check_run(count, seed, stream, threads)
    work = partial(_batch_statistics, ParticleRun(pair, population, condition, seed, stream))
    parts, total = batches(count), None
    with (
        bar(progress, "rebound", total=count, unit_scale=True, desc="simulating") as counted,
        ThreadPoolExecutor(workers) as pool,
    ):
        while group := list(islice(parts, _AHEAD * workers)):
            for part in pool.map(work, group):
                total = part if total is None else merge(total, part)
                counted.update(part.count)
    assert total is not None  # a run has at least one batch
    return total
