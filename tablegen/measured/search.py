"""Least squares from several starts: many rough looks, a few short searches, one long one."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc

from tablegen.measured.measurements import QUANTITIES, SPREAD, Measurements, Spreads
from tablegen.measured.moments import SimulatedMoments
from tablegen.measured.trials import Evaluations, TrialPairs
from tablegen.model.float_array import FloatArray

#: Least standard error assumed of a spread over that of a mean. A measured spread also holds those
#: of size, speed, direction before the impact and wall, which the pair does not have.
SPREAD_FACTOR = 2.5

#: Weight of a spread below its upper bound: of pairs that follow the means alike, that with the
#: larger spreads is taken, or grains would be spheres, which follow means most easily.
_BELOW = 0.15

#: Distance of random starts from the given pair, over that of a random place of the search.
_WAYS = (1.0, 0.6, 0.3)

#: Fewest particles of each shape at each condition.
_FEWEST = 64

#: Coordinates nearer to a bound than this part of the width of their search lie on it.
_AT_BOUND = 1e-3

#: Least share of a shape: in a table a rare one costs as much as any.
_LEAST_SHARE = 0.02

#: The seed of the second set of random numbers for slopes differs by this.
_SEED_OF_SLOPES = 0x510E

#: Number of last steps at most, and the part by which one may raise the cost, which is rough.
_LAST_STEPS, _TOLERATED = 4, 0.01

#: Singular values below this part of the largest are not followed in the last steps.
_OPEN = 1e-2


class Target(NamedTuple):
    """A measured mean or spread."""

    row: int
    quantity: str
    #: Whether it is a standard deviation.
    spread: bool
    measured: float
    #: Its standard error from the count of particles; 0 without a count.
    counted: float
    #: Whether smaller simulated numbers are as good.
    bound: bool = False

    @property
    def column(self) -> str:
        """Name of the column of measurements."""
        return self.quantity + SPREAD * self.spread

    @property
    def assumed(self) -> float:
        """Least standard error that is assumed."""
        return QUANTITIES[self.quantity].accuracy * (SPREAD_FACTOR if self.spread else 1.0)

    @property
    def accuracy(self) -> float:
        """Standard error that weights the fit."""
        return max(self.counted, self.assumed)

    @property
    def allowed(self) -> float:
        """Largest residual that errors explain: 2 assumed ones, or 3 by the count."""
        return max(2.0 * self.assumed, 3.0 * self.counted)


class Targets(tuple[Target, ...]):
    """All m measured numbers of a search."""

    def array(self, field: str) -> FloatArray:
        """Collect one field of all numbers, (m,)."""
        return np.array([getattr(target, field) for target in self], dtype=np.float64)

    def pick(self, simulated: SimulatedMoments) -> tuple[FloatArray, FloatArray]:
        """Pick the simulated numbers (m,) and their chance errors (m,)."""
        means = simulated.mean, simulated.mean_error
        spreads = simulated.std, simulated.std_error
        values, errors = (
            np.array([(spread if t.spread else mean)[t.quantity][t.row] for t in self])
            for mean, spread in zip(means, spreads, strict=True)
        )
        return values, errors


def make_targets(
    measurements: Measurements, simulated: SimulatedMoments | None, spreads: Spreads
) -> Targets:
    """List all means and spreads of some measurements, row by row.

    With a count n a mean is accurate to s / sqrt(n), with the measured spread s or, if that is
    missing, the simulated one; and a spread to s / sqrt(2 (n - 1)), as for a normal law. The out-
    of-plane angle has a spread only, because by symmetry its mean is zero. The simulated moments
    are those of the same rows; None without rows.
    """
    found: list[Target] = []
    for row, count in enumerate(measurements.count):
        for name in QUANTITIES:
            moments = measurements.moments[name]
            mean, std = float(moments.mean[row]), float(moments.std[row])
            size = std if std > 0.0 or simulated is None else float(simulated.std[name][row])
            if np.isfinite(mean) and name != "out_of_plane_deg":
                counted = size / np.sqrt(count) if count > 1.0 else 0.0
                found.append(Target(row, name, False, mean, counted))
            if np.isfinite(std) and spreads != "ignore":
                counted = size / np.sqrt(2.0 * (count - 1.0)) if count > 1.0 else 0.0
                bound = spreads == "upper-bound"
                found.append(Target(row, name, True, std, counted, bound))
    return Targets(found)


class Stage(NamedTuple):
    """Searches with the same count of particles."""

    name: str
    #: Number of searches that go on from the stage before.
    starts: int
    #: Part of the full count of particles.
    part: float
    #: Most steps of each search; 0 only computes the cost.
    steps: int
    #: Whether differences are taken from both sides.
    central: bool = False

    def count(self, full: int) -> int:
        """Particles of each shape at each condition."""
        return min(full, max(_FEWEST, round(self.part * full)))

    def most_particles(self, trials: TrialPairs, full: int) -> int:
        """Upper bound on the particles of each shape at each condition of all searches."""
        free = int(np.count_nonzero(~trials.of_shares))
        sides = 2 if self.central else 1
        each = 1 if self.steps == 0 else self.steps * (1 + sides * free)
        return self.starts * each * self.count(full)


#: Stages of a search, one after another; numbers from EXPERIMENTS.md.
STAGES = (
    Stage("looking", 64, 1 / 32, 0),
    Stage("searching", 4, 1 / 16, 12),
    Stage("refining", 2, 1 / 4, 10),
    Stage("finishing", 1, 1.0, 8, central=True),
)


def most_particles_after(trials: TrialPairs, count: int) -> int:
    """Upper bound on the particles of each shape at each condition after all stages."""
    free = int(np.count_nonzero(~trials.of_shares))
    return (2 * (1 + 2 * free) + _LAST_STEPS) * count


def random_starts(trials: TrialPairs, count: int, seed: int) -> Iterator[FloatArray]:
    """Give the coordinates of the given pair, then of random ones around it."""
    space = trials.space
    yield space.start
    sequence = qmc.Sobol(space.start.size, seed=np.random.default_rng(seed))
    # a power of two keeps the sequence balanced; the given pair takes the place of one
    places = sequence.random_base2((count - 1).bit_length())[: count - 1]
    for k, place in enumerate(space.first + places * space.width):
        yield space.start + _WAYS[k % len(_WAYS)] * (place - space.start)


class Search:
    """Search for the coordinates that follow the measured numbers best.

    The count is that of the particles of each shape at each condition in the last stage.
    """

    def __init__(self, evaluations: Evaluations, targets: Targets, count: int) -> None:
        self.evaluations, self.targets, self.count = evaluations, targets, count
        self._measured, self._accuracy = targets.array("measured"), targets.array("accuracy")
        self._bound = targets.array("bound") > 0.0

    def accuracy(self, x: FloatArray, count: int) -> FloatArray:
        """Compute the accuracy (m,) of a residual, with the chance error of the simulation."""
        _, errors = self.targets.pick(self.evaluations.moments(x, count))
        return np.hypot(self._accuracy, errors)

    def residuals(self, x: FloatArray, count: int) -> FloatArray:
        """Subtract the measured from the simulated numbers, (m,)."""
        values, _ = self.targets.pick(self.evaluations.moments(x, count))
        return values - self._measured

    def of_means(self, x: FloatArray) -> float:
        """Compute the root mean square of the residuals of the means over their accuracies."""
        means = self.targets.array("spread") == 0.0
        size = self.residuals(x, self.count)[means] / self._accuracy[means]
        return float(np.sqrt(np.mean(size**2)))

    def counts(self, residual: FloatArray) -> NDArray[np.bool_]:
        """Tell which numbers (m,) are no upper bounds, or exceed theirs."""
        return ~self._bound | (residual > 0.0)

    def weights(self, residual: FloatArray, accuracy: FloatArray) -> FloatArray:
        """Compute the weights (m,) of residuals in the cost."""
        return np.asarray(np.where(self.counts(residual), 1.0, _BELOW) / accuracy)

    def run(self, seed: int, on_stage: Callable[[Stage], None]) -> FloatArray:
        """Go through all stages, and give the best coordinates (p,).

        The seed is that of the random starts; ``on_stage`` is called before each stage.
        """
        found = list(random_starts(self.evaluations.trials, STAGES[0].starts, seed))
        for stage in STAGES:
            on_stage(stage)
            accuracy = self.accuracy(found[0], stage.count(self.count))
            ends = [self.end(x, stage, accuracy) for x in found[: stage.starts]]
            # starts of the same cost keep their order
            order = np.argsort([cost for cost, _ in ends], kind="stable")
            found = [ends[k][1] for k in order]
        return self._on_bounds(found[0])

    def end(self, x: FloatArray, stage: Stage, accuracy: FloatArray) -> tuple[float, FloatArray]:
        """Search from x in one stage, and give the cost and the coordinates at the end."""
        evaluations, space = self.evaluations, self.evaluations.trials.space
        count = stage.count(self.count)

        def weighted(y: FloatArray) -> FloatArray:
            residual = self.residuals(y, count)
            return residual * self.weights(residual, accuracy)

        def slopes(y: FloatArray) -> FloatArray:
            plain = evaluations.slopes(y, count, self.targets.pick, stage.central)
            return plain * self.weights(self.residuals(y, count), accuracy)[:, None]

        if stage.steps == 0:
            return 0.5 * float(np.sum(weighted(x) ** 2)), x
        solved = least_squares(
            weighted,
            x,
            slopes,
            bounds=(space.low, space.high),
            x_scale=space.width,
            ftol=1e-4,
            xtol=1e-5,
            gtol=None,
            max_nfev=stage.steps,
        )
        return float(solved.cost), solved.x

    def settle(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Take the last steps of a search, by slopes with less chance in them.

        The cost of a fit is rough on the scale of the standard errors. The optimiser stops where
        its slopes, from one set of random numbers, find no way down. These are means of two sets.
        Gives the coordinates (p,), the slopes (m, p), and half of the difference of both sets.
        """
        evaluations, space, count = self.evaluations, self.evaluations.trials.space, self.count
        both = evaluations, replace(evaluations, seed=evaluations.seed ^ _SEED_OF_SLOPES)
        one, other = (each.slopes(x, count, self.targets.pick, central=True) for each in both)
        slopes = 0.5 * (one + other)
        accuracy, width = self.accuracy(x, count), space.width
        free = (x > space.low) & (x < space.high)
        residual = self.residuals(x, count)
        weight = self.weights(residual, accuracy)
        residual *= weight
        inverse = np.linalg.pinv(slopes[:, free] * width[free] * weight[:, None], rcond=_OPEN)
        for _ in range(_LAST_STEPS):
            further = x.copy()
            further[free] -= width[free] * (inverse @ residual)
            further = np.clip(further, space.low, space.high)
            left = self.residuals(further, count)
            left *= self.weights(left, accuracy)
            if np.sum(left**2) > (1.0 + _TOLERATED) * np.sum(residual**2):
                break
            x, residual = further, left
        return self._on_bounds(x), slopes, 0.5 * (one - other)

    def _on_bounds(self, x: FloatArray) -> FloatArray:
        """Move coordinates next to a bound onto it, and leave out shapes of hardly any share."""
        space = self.evaluations.trials.space
        near = _AT_BOUND * space.width
        x = np.where(x - space.low < near, space.low, x)
        x = np.where(space.high - x < near, space.high, x)
        rest = 1.0
        for k in np.flatnonzero(self.evaluations.trials.of_shares):
            if rest * min(x[k], 1.0 - x[k]) < _LEAST_SHARE:
                x[k] = round(x[k]) if rest >= 2.0 * _LEAST_SHARE else 0.0
            rest *= 1.0 - x[k]
        return x
