"""Least squares from several starts: many rough looks, a few short searches, one long one."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from tablegen.measured.evaluations import Evaluations
from tablegen.measured.targets import STATED_ACCURACY, Targets
from tablegen.measured.trial_pairs import TrialPairs
from tablegen.model.float_array import FloatArray

#: How far a random start lies from the given pair, over its way to a random place of the search.
_WAYS = (1.0, 0.6, 0.3)

#: Least particles of each shape at each condition.
_FEWEST = 64

#: Part of the width of its search from a bound within which a coordinate counts as lying on it.
AT_BOUND = 1e-3

#: Weights of accuracies below this part of the stated ones would stand for digits that neither
#: experiment nor simulation has.
_LEAST_PART = 1e-3


class Stage(NamedTuple):
    """Searches with the same count of particles."""

    name: str
    #: How many go on from the stage before.
    starts: int
    #: Part of the full count of particles.
    part: float
    #: Most steps of each search; 0 only looks.
    steps: int
    #: Whether differences are taken from both sides.
    central: bool = False


#: What is done one after another; numbers from EXPERIMENTS.md.
STAGES = (
    Stage("looking", 64, 1 / 32, 0),
    Stage("searching", 4, 1 / 16, 12),
    Stage("refining", 2, 1 / 4, 10),
    Stage("finishing", 1, 1.0, 8, central=True),
)


def count_of(stage: Stage, count: int) -> int:
    """Particles of each shape at each condition in a stage."""
    return min(count, max(_FEWEST, round(stage.part * count)))


def most_particles(stage: Stage, trials: TrialPairs, count: int) -> int:
    """Particles of each shape and condition that a stage simulates at most."""
    free = int(np.count_nonzero(~trials.of_shares))
    each = 1 if stage.steps == 0 else stage.steps * (1 + (2 if stage.central else 1) * free)
    return stage.starts * each * count_of(stage, count)


def random_starts(trials: TrialPairs, count: int, seed: int) -> Iterator[FloatArray]:
    """Coordinates of the given pair, then of random ones ever nearer to and farther from it."""
    yield trials.start
    sequence = qmc.Sobol(trials.start.size, seed=np.random.default_rng(seed))
    # as many as keep it balanced, one of which makes room for the given pair
    places = sequence.random_base2((count - 1).bit_length())[: count - 1]
    for k, place in enumerate(trials.first + places * (trials.last - trials.first)):
        yield trials.start + _WAYS[k % len(_WAYS)] * (place - trials.start)


class Search:
    """Searches for the coordinates that follow the measured numbers best.

    Parameters
    ----------
    evaluations : Evaluations
        At the conditions of the targets.
    targets : Targets
    count : int
        Particles of each shape at each condition in the last stage.
    """

    def __init__(self, evaluations: Evaluations, targets: Targets, count: int) -> None:
        self._evaluations, self._targets, self._count = evaluations, targets, count

    def accuracy(self, x: FloatArray, count: int) -> FloatArray:
        """Accuracy (m,) of a residual, with the chance error of the simulation at x."""
        _, errors = self._targets.pick(self._evaluations.moments(x, count))
        stated = np.array([STATED_ACCURACY[name] for name in self._targets.quantity])
        both = np.hypot(self._targets.accuracy, errors)
        return np.asarray(np.maximum(both, _LEAST_PART * stated))

    def residuals(self, x: FloatArray, count: int) -> FloatArray:
        """Subtract the measured from the simulated numbers, (m,)."""
        values, _ = self._targets.pick(self._evaluations.moments(x, count))
        return values - self._targets.measured

    def run(self, seed: int, on_stage: Callable[[Stage], None]) -> FloatArray:
        """Go through all stages.

        Parameters
        ----------
        seed : int
            Of the random starts.
        on_stage : callable
            Is called with each stage before it begins.

        Returns
        -------
        (p,) float64
            Coordinates of the best.
        """
        trials = self._evaluations.trials
        found = list(random_starts(trials, STAGES[0].starts, seed))
        for stage in STAGES:
            on_stage(stage)
            count = count_of(stage, self._count)
            accuracy = self.accuracy(found[0], count)
            ends = [
                self.end(x, stage.steps, count, accuracy, stage.central)
                for x in found[: stage.starts]
            ]
            # the order of equal costs is that of the starts
            order = np.argsort([cost for cost, _ in ends], kind="stable")
            found = [ends[k][1] for k in order]
        return self.on_bounds(found[0])

    def on_bounds(self, x: FloatArray) -> FloatArray:
        """Put coordinates that end next to a bound, which the optimiser never reaches, on it."""
        trials = self._evaluations.trials
        near = AT_BOUND * (trials.last - trials.first)
        x = np.where(x - trials.low < near, trials.low, x)
        return np.where(trials.high - x < near, trials.high, x)

    def end(
        self, x: FloatArray, steps: int, count: int, accuracy: FloatArray, central: bool
    ) -> tuple[float, FloatArray]:
        """Cost and coordinates at the end of a search from x, of so many steps at most."""
        evaluations, trials = self._evaluations, self._evaluations.trials

        def weighted(y: FloatArray) -> FloatArray:
            return self.residuals(y, count) / accuracy

        def slopes(y: FloatArray) -> FloatArray:
            plain = evaluations.slopes(y, count, self._targets.pick, central)
            return plain / accuracy[:, None]

        if steps == 0:
            return 0.5 * float(np.sum(weighted(x) ** 2)), x
        solved = least_squares(
            weighted,
            x,
            slopes,
            bounds=(trials.low, trials.high),
            x_scale=trials.last - trials.first,
            ftol=1e-4,
            xtol=1e-5,
            gtol=None,
            max_nfev=steps,
        )
        return float(solved.cost), solved.x
