"""Accuracy of a table at some conditions, against direct simulation with new particles."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.library import processors
from sampler.table import Table
from tablegen.accuracy.comparison import Comparison, Spin, compare, sharpened
from tablegen.accuracy.decision import LOOKS, Targets, undecided_metrics
from tablegen.accuracy.scene_variables import simulated_variables
from tablegen.config.config import AccuracyTargets, Config
from tablegen.model.float_array import FloatArray
from tablegen.progress import bar
from tablegen.simulation.simulate import simulate
from tablegen.tasks.side_by_side import side_by_side

#: Least number of states a side in a comparison, and this over the square of the declared
#: Kolmogorov-Smirnov distance where that is more: noise is then a third of what is declared.
_LEAST_SAMPLES = 100_000
_SAMPLES = 40.0

#: Each further look at an undecided comparison has so many times as many states, up to the limit:
#: four million take a gigabyte and half a minute.
_MORE = 3
_MOST_SAMPLES = 4_000_000

#: Streams from here on belong to measurements; nodes use those below.
FIRST_STREAM = 2**31

_Piece = TypeVar("_Piece")
_Result = TypeVar("_Result")


def in_threads(
    work: Callable[[_Piece], _Result], pieces: Iterable[_Piece], tick: Callable[[int], Any]
) -> list[_Result]:
    """Work on pieces side by side, on all processors, one thread each.

    More threads would sum in another order, which changes the last bit of what a table stores.

    Parameters
    ----------
    work : callable
    pieces : iterable
    tick : callable
        Called with 1 as each is done, in their order.

    Returns
    -------
    list
        Results in the order of the pieces.
    """
    found = []
    with threadpool_limits(limits=1):
        for result in side_by_side(work, pieces, processors()):
            found.append(result)
            tick(1)
    return found


def sample_size(targets: Targets) -> int:
    """States a side with which a declared accuracy can be told from noise.

    Two samples of n differ by sqrt(log(12 / q) / n) in the worst of six variables with
    probability q; at q = 1e-3 that is half of the declared distance. A distance below 0.0032 may
    stay undecided: a table that declares it shall not use up the memory.
    """
    return min(max(_LEAST_SAMPLES, int(_SAMPLES / targets.ks**2)), _MOST_SAMPLES)


def measure(
    table: Table,
    config: Config,
    conditions: Sequence[tuple[float, float]],
    *,
    seed: int,
    samples: int | None = None,
    targets: AccuracyTargets | None = None,
    progress: bool = False,
) -> list[Comparison]:
    """Compare a table with direct simulation at some conditions.

    Where a distance can neither be said to hold nor to be missed, it is measured again with three
    times, then nine times as many states.

    Parameters
    ----------
    table : Table
    config : Config
        What the table claims to represent.
    conditions : sequence of (alpha_deg, speed)
    seed : int
        Of the simulation, of the draws and of the metrics.
    samples : int, optional
        States a side at first; by default as many as the accuracy needs.
    targets : AccuracyTargets, optional
        Accuracy that is asked for; the declared one by default.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    list of Comparison, in the order of the conditions
    """
    places = [ComparedCondition(table, config, *c, seed, k) for k, c in enumerate(conditions)]
    return compared_side_by_side(places, samples, targets or config.accuracy, progress)


def compared_side_by_side(
    places: Sequence["ComparedCondition"],
    samples: int | None,
    targets: Targets,
    progress: bool,
    words: str = "validating",
) -> list[Comparison]:
    """Compare at some conditions, on all processors; arguments as for `measure`."""
    count = samples or sample_size(targets)
    with bar(progress, "condition", total=len(places), desc=words) as counted:
        return in_threads(lambda place: place.compared(count, targets), places, counted.update)


@dataclass(frozen=True)
class ComparedCondition:
    """A condition at which a table is compared with direct simulation."""

    table: Table
    config: Config
    alpha_deg: float
    speed: float
    seed: int
    #: Keeps conditions that share a seed apart: of the simulation's stream, and hit of the draws.
    number: int
    #: Spin before the impact times a/V; None: today's law, of particles without spin.
    spin: Spin | None = None

    def states(self, count: int) -> tuple[FloatArray, FloatArray]:
        """States drawn from the table, and simulated ones; the first are the same for any count."""
        alpha1, index = np.radians(self.alpha_deg), np.arange(count)
        spin: dict[str, Any] = {} if self.spin is None else {"spin": self.spin}
        direct = simulate(
            self.config,
            alpha1,
            self.speed,
            count,
            seed=self.seed,
            stream=FIRST_STREAM + self.number,
            threads=1,
            **spin,
        )
        drawn = self.table.sample(
            alpha1, self.speed, seed=self.seed, hit=self.number, index=index, threads=1, **spin
        )
        return drawn, simulated_variables(direct, self.table.columns)

    def compared(self, samples: int, targets: Targets) -> Comparison:
        """Compare, with more states until everything is decided or there are too many."""
        seed = self.seed % 2**32
        comparison = compare(
            *self.states(samples),
            self.alpha_deg,
            self.speed,
            seed=seed,
            variables=self.table.columns,
            spin=self.spin,
        )
        for look in range(1, LOOKS):
            count = min(samples * _MORE**look, max(samples, _MOST_SAMPLES))
            unclear = undecided_metrics(comparison, targets)
            if not unclear or count <= comparison.states:
                break
            comparison = sharpened(comparison, *self.states(count), unclear, seed)
        return comparison
