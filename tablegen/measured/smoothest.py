"""The smoothest laws that give measured means: bounded least squares with a penalty on roughness.

The method is that of Gauss and Newton, with common random numbers. The weight of the penalty falls
until every mean is within its tolerance, and stops there (discrepancy principle). Source: P. C.
Hansen, Rank-Deficient and Discrete Ill-Posed Problems (1998), ch. 7.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog, lsq_linear

from tablegen.measured.free_numbers import FreeNumbers
from tablegen.model.float_array import FloatArray

#: Weights of the penalty, one after another, and most steps with each.
_WEIGHTS, _STEPS = (10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01, 0.003), 4

#: A mean is held by the search within this part of its tolerance: the rest is for chance.
_SEARCH_SHARE = 0.8

#: Steps are tried at these lengths; one that lowers the cost by less than this part is the last.
_LENGTHS, _LEAST_GAIN = (1.0, 0.5, 0.2), 0.05

#: After more than `_PATIENCE` weights that leave the worst mean above `_IMPROVEMENT` of the best so
#: far, the grains cannot give it.
_PATIENCE, _IMPROVEMENT = 2, 0.97

#: Weights after which a search may be given up, and the worst mean over its tolerance, by the
#: slopes there, from which it is. The slopes at the start promise too little.
_TRIED, HOPELESS = 2, 2.0

#: Largest second difference of restitution between neighbouring angles of a smooth law.
_LARGEST_BEND = 0.25

#: Samples of the rows for standard errors.
_SAMPLES = 200

#: Computes simulated less measured means over their tolerances, (m,), from coordinates (p,).
Misses = Callable[[FloatArray], FloatArray]


class Solution(NamedTuple):
    """The end of a search."""

    #: Coordinates (p,), misses (m,) there, and their slopes (m, p).
    x: FloatArray
    misses: FloatArray
    slopes: FloatArray
    #: Weight of the penalty, and largest second difference of restitution.
    weight: float
    bend: float

    @property
    def worst(self) -> float:
        """Largest miss of a mean, over its tolerance."""
        return float(np.abs(self.misses).max())

    @property
    def rank(self) -> tuple[float, float]:
        """Order of solutions: laws smooth enough come first, then those nearest to the means."""
        return max(self.bend, _LARGEST_BEND), self.worst

    @property
    def holds(self) -> bool:
        """Whether a smooth law holds all means, with room for chance."""
        return self.rank <= (_LARGEST_BEND, _SEARCH_SHARE)


class Penalty:
    """Roughness of laws at coordinates, as rows of least squares."""

    def __init__(self, numbers: FreeNumbers) -> None:
        self._low, self._high, self._rows = numbers.low, numbers.high, numbers.smoothness
        # differences are wanted to be 0, and distances from the start
        p = numbers.start.size
        self._wanted = np.zeros(len(self._rows))
        self._wanted[-p:] = self._rows[-p:] @ numbers.start

    def at(self, x: FloatArray) -> FloatArray:
        """Compute all rows, (r,)."""
        return self._rows @ x - self._wanted

    def cost(self, x: FloatArray, misses: FloatArray, weight: float) -> float:
        """Compute the sum of squares that a search lowers."""
        return float(misses @ misses + weight * np.sum(self.at(x) ** 2))

    def step(
        self, x: FloatArray, misses: FloatArray, slopes: FloatArray, weight: float
    ) -> FloatArray:
        """Solve the linear problem within the bounds, (p,)."""
        root = np.sqrt(weight)
        matrix = np.vstack([slopes, root * self._rows])
        wanted = -np.concatenate([misses, root * self.at(x)])
        slack = 1e-12
        bounds = (self._low - x - slack, self._high - x + slack)
        return np.asarray(lsq_linear(matrix, wanted, bounds=bounds).x)

    def least_worst(self, solution: Solution) -> float:
        """Compute how small the worst miss can get within the bounds, if the slopes stay."""
        (m, p), misses = solution.slopes.shape, solution.misses
        sides = np.vstack([solution.slopes, -solution.slopes])
        rows = np.hstack([sides, -np.ones((2 * m, 1))])
        bounds = [*zip(self._low - solution.x, self._high - solution.x, strict=True), (0.0, None)]
        cost = np.append(np.zeros(p), 1.0)
        least = linprog(cost, rows, np.concatenate([-misses, misses]), bounds=bounds)
        return float(least.fun) if least.success else 0.0

    def clipped(self, x: FloatArray) -> FloatArray:
        """Move coordinates within their bounds."""
        return np.clip(x, self._low, self._high)

    def determined(self, solution: Solution) -> FloatArray:
        """Tell how far the data determine each coordinate, 0 to 1, (p,); 0 at a bound."""
        free = (solution.x > self._low) & (solution.x < self._high)
        slopes, rows = solution.slopes[:, free], self._rows[:, free]
        by_data, parts = slopes.T @ slopes, np.zeros(free.size)
        whole = by_data + solution.weight * rows.T @ rows
        parts[free] = np.diagonal(np.linalg.solve(whole, by_data))
        return parts


def slopes_at(numbers: FreeNumbers, misses: Misses, x: FloatArray, here: FloatArray) -> FloatArray:
    """Compute difference quotients (m, p) by the coordinates, to the side that has room."""
    columns = []
    for k, step in enumerate(numbers.step):
        moved = x.copy()
        moved[k] += step if x[k] + step <= numbers.high[k] else -step
        columns.append((misses(moved) - here) / (moved[k] - x[k]))
    return np.array(columns).T


def smoothest(numbers: FreeNumbers, misses: Misses, give_up: bool = False) -> Solution:
    """Find the smoothest laws that hold all means, or those that come nearest.

    With ``give_up``, the search ends early where even laws of any roughness would miss a mean by
    `HOPELESS` tolerances: these are most of its time.
    """
    penalty, x = Penalty(numbers), numbers.start
    here = misses(x)
    best = Solution(x, here, slopes_at(numbers, misses, x, here), _WEIGHTS[0], numbers.bend(x))
    waited, now = 0, best
    for tried, weight in enumerate(_WEIGHTS, 1):
        now = _descended(numbers, misses, penalty, now._replace(weight=weight))
        waited = 0 if now.rank < (best.rank[0], _IMPROVEMENT * best.worst) else waited + 1
        best = min(best, now, key=lambda one: one.rank)
        if best.holds or waited > _PATIENCE:
            break
        if give_up and tried >= _TRIED and penalty.least_worst(now) > HOPELESS:
            break
    return best


def _descended(numbers: FreeNumbers, misses: Misses, penalty: Penalty, now: Solution) -> Solution:
    """Go down with one weight of the penalty until the means are held or a step gains little."""
    weight, fresh = now.weight, False
    for _ in range(_STEPS):
        cost = penalty.cost(now.x, now.misses, weight)
        step = penalty.step(now.x, now.misses, now.slopes, weight)
        for length in _LENGTHS:
            x = penalty.clipped(now.x + length * step)
            there = misses(x)
            lower = penalty.cost(x, there, weight)
            if lower < cost:
                break
        else:
            if fresh:
                return now
            fresh = True
            now = now._replace(slopes=slopes_at(numbers, misses, now.x, now.misses))
            continue
        # slopes follow the step as Broyden has it, and are computed anew where it gains little
        moved = x - now.x
        off = there - now.misses - now.slopes @ moved
        slopes = now.slopes + np.outer(off, moved) / max(float(moved @ moved), 1e-12)
        now, fresh = Solution(x, there, slopes, weight, numbers.bend(x)), False
        if now.holds:
            return now
        if cost - lower < _LEAST_GAIN * cost:
            now = now._replace(slopes=slopes_at(numbers, misses, x, there))
            fresh = True
    return now


def polished(numbers: FreeNumbers, misses: Misses, solution: Solution, steps: int) -> Solution:
    """Take some steps with other random numbers and the slopes of a search."""
    penalty, best = Penalty(numbers), solution._replace(misses=misses(solution.x))
    for _ in range(steps):
        if best.holds:
            break
        x = penalty.clipped(best.x + penalty.step(best.x, best.misses, best.slopes, best.weight))
        moved = best._replace(x=x, misses=misses(x), bend=numbers.bend(x))
        best = min(best, moved, key=lambda one: one.rank)
    return best


def bootstrapped(
    numbers: FreeNumbers, solution: Solution, rows: Sequence[int], seed: int
) -> FloatArray:
    """Draw coordinates (samples, p) of refits to rows drawn with replacement.

    A refit is one step from the solution with its slopes; ``rows`` (m,) are those of the means.
    """
    penalty, rng = Penalty(numbers), np.random.default_rng(seed)
    measured_rows, row_of_mean = np.unique(rows, return_inverse=True)
    refits = []
    for _ in range(_SAMPLES):
        count = measured_rows.size
        times = rng.multinomial(count, np.full(count, 1.0 / count))
        root = np.sqrt(times[row_of_mean])
        slopes = root[:, None] * solution.slopes
        step = penalty.step(solution.x, root * solution.misses, slopes, solution.weight)
        refits.append(penalty.clipped(solution.x + step))
    return np.array(refits)
