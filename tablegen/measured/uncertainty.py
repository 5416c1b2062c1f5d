"""Standard errors of fitted numbers, and what the data leave open.

To first order the coordinates of the fit err by dx = G e, with e the errors of the residuals and G
the weighted pseudo-inverse of their slopes (Gauss and Newton). So their covariance is G (D + S) G',
with D of the measured and S of the simulated numbers.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tablegen.model.float_array import FloatArray

#: Standard error of a combination of parameters, in units of their ranges of search, from which the
#: data are said to leave it open.
_OPEN = 0.5

#: Singular values are taken to be at least this part of the largest: beyond it is rounding.
_SMALLEST = 1e-6

#: Least component of a parameter in a combination that names it.
_NAMED = 0.3

#: Correlation of two parameters from which the data are said not to tell them apart.
_CORRELATED = 0.95


@dataclass(frozen=True)
class Problem:
    """A least-squares fit at its end, for m numbers and p coordinates.

    Attributes
    ----------
    names : tuple of p str
        Of the coordinates, for warnings.
    x, low, high, width : (p,) float64
        Coordinates, their bounds, and the width of the range in which they were searched.
    slopes : (m, p) float64
        Of the simulated numbers by the coordinates.
    residual, accuracy : (m,) float64
        Simulated less measured numbers, and what they were weighted by.
    counted : (m,) bool
        Whether the accuracy follows from a count of particles.
    measured, simulated : (m, m) float64
        Covariances of errors; that of measured numbers without a count is zero here.
    """

    names: tuple[str, ...]
    x: FloatArray
    low: FloatArray
    high: FloatArray
    width: FloatArray
    slopes: FloatArray
    residual: FloatArray
    accuracy: FloatArray
    counted: NDArray[np.bool_]
    measured: FloatArray
    simulated: FloatArray


@dataclass(frozen=True)
class Uncertainty:
    """What is known of the coordinates of a fit.

    Attributes
    ----------
    covariance : (p, p) float64
        Zero for those at a bound.
    at_bound : (p,) bool
    scatter : float
        Root of the weighted sum of squares over its degrees of freedom: how many times larger
        residuals are than the accuracies. NaN where there are none.
    freedom : int
        Degrees of freedom.
    warnings : tuple of str
    """

    covariance: FloatArray
    at_bound: NDArray[np.bool_]
    scatter: float
    freedom: int
    warnings: tuple[str, ...]


def uncertainty(problem: Problem) -> Uncertainty:
    """Covariance of the coordinates, and warnings.

    Where no count of particles is stated the accuracy of a number is unknown, and its error is
    taken from the residuals: the stated accuracy times the scatter. With counts the errors are
    theirs; they are scaled as well where the residuals are clearly larger than they allow.
    """
    at_bound = _at_bound(problem)
    free = np.flatnonzero(~at_bound)
    warnings = [_bound_warning(problem, int(k)) for k in np.flatnonzero(at_bound)]
    freedom = len(problem.residual) - len(free)
    squares = float(np.sum((problem.residual / problem.accuracy) ** 2))
    scatter = float(np.sqrt(squares / freedom)) if freedom > 0 else float("nan")
    factor = 1.0
    if not np.isfinite(scatter):
        warnings.append(
            "as many free parameters as measured numbers: nothing is left to judge the fit by, and "
            "errors of numbers without a count are those that were assumed"
        )
    elif not problem.counted.all():
        factor = scatter
    elif scatter**2 > 1.0 + 5.0 * np.sqrt(2.0 / freedom):
        factor = scatter
        warnings.append(
            f"the pair does not follow the measurements: residuals are {scatter:.1f} times their "
            "errors, and standard errors are enlarged by that"
        )
    uncounted = np.where(problem.counted, 0.0, problem.accuracy**2)
    errors = factor**2 * (problem.measured + np.diag(uncounted)) + problem.simulated
    covariance = np.zeros((len(problem.x), len(problem.x)))
    if free.size:
        scaled = problem.slopes[:, free] * problem.width[free] / problem.accuracy[:, None]
        inverse = _inverse(scaled)
        relative = errors / np.outer(problem.accuracy, problem.accuracy)
        unit = inverse @ relative @ inverse.T
        covariance[np.ix_(free, free)] = unit * np.outer(problem.width[free], problem.width[free])
        names = [problem.names[k] for k in free]
        warnings += _open_combinations(scaled, names, factor)
        warnings += _correlated(unit, names)
    return Uncertainty(covariance, at_bound, scatter, freedom, tuple(warnings))


def _inverse(scaled: FloatArray) -> FloatArray:
    """Pseudo-inverse (p, m) in which what the data say nothing of has huge errors, and not none."""
    left, values, right = np.linalg.svd(scaled, full_matrices=False)
    floor = max(_SMALLEST * float(values.max(initial=0.0)), 1e-300)
    return np.asarray(right.T @ (left.T / np.maximum(values, floor)[:, None]))


def _at_bound(problem: Problem) -> NDArray[np.bool_]:
    return np.asarray((problem.x <= problem.low) | (problem.x >= problem.high))


def _bound_warning(problem: Problem, k: int) -> str:
    low = problem.x[k] - problem.low[k] < problem.high[k] - problem.x[k]
    end = "lower" if low else "upper"
    return f"{problem.names[k]} is at its {end} bound, and has no standard error"


def _open_combinations(scaled: FloatArray, names: Sequence[str], factor: float) -> list[str]:
    """Warnings of combinations of parameters that the data leave open."""
    _, values, rows = np.linalg.svd(scaled, full_matrices=True)
    values = np.concatenate([values, np.zeros(len(names) - len(values))])
    found = []
    for value, row in zip(values, rows, strict=True):
        if value * _OPEN < factor:
            row = row * np.sign(row[np.argmax(np.abs(row))])
            named = [k for k in np.argsort(-np.abs(row)) if abs(row[k]) >= _NAMED]
            terms = " ".join(f"{row[k]:+.2f} {names[k]}" for k in named)
            found.append(
                f"the data do not determine {terms.removeprefix('+')} (each over the width of its "
                "search): fix one of them, or measure more"
            )
    return found


def _correlated(covariance: FloatArray, names: Sequence[str]) -> list[str]:
    """Warnings of pairs of parameters that the data do not tell apart."""
    correlation = correlations(covariance)
    return [
        f"{names[j]} and {names[k]} are correlated by {correlation[j, k]:+.2f}"
        for j in range(len(names))
        for k in range(j + 1, len(names))
        if abs(correlation[j, k]) > _CORRELATED
    ]


def correlations(covariance: FloatArray) -> FloatArray:
    """Correlation matrix of a covariance; zero where there is no variance."""
    size = np.sqrt(np.diag(covariance))
    safe = np.where(size > 0.0, size, 1.0)
    return np.asarray(covariance / np.outer(safe, safe))
