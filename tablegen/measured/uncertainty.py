"""Standard errors of fitted numbers, and warnings of what the data leave open.

To first order the coordinates of the fit err by dx = G e, with the errors e of the residuals and
the weighted pseudo-inverse G of their slopes (Gauss and Newton). So their covariance is
G (D + S) G', with D of the measured and S of the simulated numbers. Means and spreads of one row
come from the same particles, so their errors are correlated. Chance in the slopes A looks like
information: A'A is too large by what two sets of random numbers differ. The cost is rough, so the
search ends near the least one: the step that is left counts as an error, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from tablegen.measured.measurements import Measurements
from tablegen.measured.moments import covariances, influences
from tablegen.measured.parameters import Space, in_words
from tablegen.measured.search import Search, Targets
from tablegen.measured.trials import TrialPairs
from tablegen.model.float_array import FloatArray

#: Standard error of a combination of parameters, in units of the widths of their searches, from
#: which the data leave it open.
_OPEN = 0.5

#: Most of the information of slopes that counts as chance, so that errors stay finite.
_MOST_CHANCE = 0.5

#: Least part of the largest singular value; smaller ones are rounding.
_SMALLEST = 1e-6

#: Least component of a parameter that is named.
_NAMED = 0.3

#: Standard errors below this are the rounding of those at a bound.
_NO_ERROR = 1e-7


@dataclass(frozen=True)
class Problem:
    """A least-squares fit at its end, of m numbers by p coordinates."""

    names: tuple[str, ...]
    #: Coordinates (p,), and derivatives (m, p) of the simulated numbers by them, with their chance.
    x: FloatArray
    space: Space
    slopes: FloatArray
    chance: FloatArray
    #: Simulated less measured numbers (m,), and their weights.
    residual: FloatArray
    accuracy: FloatArray
    #: Whether the accuracy follows from a count of particles, (m,).
    counted: NDArray[np.bool_]
    #: Covariances (m, m) of errors.
    measured: FloatArray
    simulated: FloatArray


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of the coordinates of a fit."""

    #: Shape (p, p); zero for those at a bound.
    covariance: FloatArray
    #: Root of the weighted sum of squares of the residuals over the degrees of freedom; NaN without
    #: degrees of freedom.
    scatter: float
    freedom: int
    warnings: tuple[str, ...]


def uncertainty(problem: Problem) -> Uncertainty:
    """Compute the covariance of the coordinates, and warnings.

    Without a count of particles the error of a number is its assumed accuracy times the scatter.
    With counts the errors follow from the counts; they are also multiplied by the scatter if the
    residuals are clearly larger.
    """
    x, space = problem.x, problem.space
    low, high = x <= space.low, x >= space.high
    free = np.flatnonzero(~(low | high))
    warnings = [
        f"at the {side} bound, without a standard error: {', '.join(problem.names[k] for k in at)}"
        for side, at in (("lower", np.flatnonzero(low)), ("upper", np.flatnonzero(high)))
        if at.size
    ]
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
    errors = factor**2 * problem.measured + problem.simulated
    covariance = np.zeros((len(x), len(x)))
    if free.size:
        width = space.width[free]
        scaled, chance = (
            part[:, free] * width / problem.accuracy[:, None]
            for part in (problem.slopes, problem.chance)
        )
        inverse = _inverse(scaled, chance)
        relative = errors / np.outer(problem.accuracy, problem.accuracy)
        left = inverse @ (problem.residual / problem.accuracy)
        unit = inverse @ relative @ inverse.T + np.outer(left, left)
        covariance[np.ix_(free, free)] = unit * np.outer(width, width)
        names = [problem.names[k] for k in free]
        warnings += _open_combinations(scaled, names, factor)
    return Uncertainty(covariance, scatter, freedom, tuple(warnings))


def _inverse(scaled: FloatArray, chance: FloatArray) -> FloatArray:
    """Compute the inverse (p, m) of A'A - C'C times A', of slopes A and their chance C.

    Undetermined combinations get huge errors.
    """
    left, values, right = np.linalg.svd(scaled, full_matrices=False)
    floor = max(_SMALLEST * float(values.max(initial=0.0)), 1e-300)
    basis = right.T / np.maximum(values, floor)
    part = chance @ basis
    shares, axes = np.linalg.eigh(part.T @ part)
    return np.asarray(basis @ (axes / (1.0 - np.minimum(shares, _MOST_CHANCE))) @ axes.T @ left.T)


def _open_combinations(scaled: FloatArray, names: Sequence[str], factor: float) -> list[str]:
    """Warn of combinations of parameters that the data leave open."""
    _, values, rows = np.linalg.svd(scaled, full_matrices=True)
    values = np.concatenate([values, np.zeros(len(names) - len(values))])
    found = []
    for value, row in zip(values, rows, strict=True):
        if value * _OPEN < factor:
            row = row * np.sign(row[np.argmax(np.abs(row))])
            named = [k for k in np.argsort(-np.abs(row)) if abs(row[k]) >= _NAMED]
            more = " and ".join(names[k] for k in named if row[k] > 0.0)
            less = " and ".join(names[k] for k in named if row[k] < 0.0)
            change = f"more {more}" + (f" and less {less}" if less else "")
            which = "one of them" if len(named) > 1 else "it"
            found.append(f"the fit is as good with {change}: fix {which}, or measure more")
    return found


def correlations(covariance: FloatArray) -> FloatArray:
    """Compute the correlation matrix of a covariance; zero without a variance."""
    size = np.sqrt(np.diag(covariance))
    safe = np.where(size > 0.0, size, 1.0)
    return np.asarray(covariance / np.outer(safe, safe))


def uncertainty_of_fit(
    measurements: Measurements, search: Search, x: FloatArray, *slopes: FloatArray
) -> Uncertainty:
    """Compute the uncertainty of the coordinates, with the slopes that `Search.settle` gives."""
    targets, trials, count = search.targets, search.evaluations.trials, search.count
    variables = search.evaluations.rows(x).variables(count)
    measured, simulated = _covariances(targets, measurements, variables, trials.shares(x))
    # a measured spread holds more than that of shapes, and so do the errors of its row
    moments = measurements.moments
    known = [np.isfinite(moments[one.quantity].std[one.row]) for one in targets]
    least = np.where(known, targets.array("accuracy"), targets.array("assumed"))
    measured += np.diag(np.maximum(least**2 - np.diag(measured), 0.0))
    residual = search.residuals(x, count)
    k = np.flatnonzero(search.counts(residual))
    return uncertainty(
        Problem(
            names=tuple(in_words(trials.config, label) for label in trials.labels),
            x=x,
            space=trials.space,
            slopes=slopes[0][k],
            chance=slopes[1][k],
            residual=residual[k],
            accuracy=search.accuracy(x, count)[k],
            counted=targets.array("counted")[k] > 0.0,
            measured=measured[np.ix_(k, k)],
            simulated=simulated[np.ix_(k, k)] / count,
        )
    )


def _covariances(
    targets: Targets,
    measurements: Measurements,
    variables: Sequence[Sequence[FloatArray]],
    shares: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Compute covariances (m, m) of measured numbers, and of simulated ones for one particle."""
    measured, simulated = [], []
    for row, (alpha_deg, count) in enumerate(
        zip(measurements.alpha_deg, measurements.count, strict=True)
    ):
        names = [target.column for target in targets if target.row == row]
        if names:
            found = influences(variables[row], shares, np.radians(alpha_deg), names)
            one, other = covariances(found, shares)
            measured.append(one / count if count > 1.0 else 0.0 * one)
            simulated.append(other)
    return block_diag(*measured), block_diag(*simulated)


def errors_of_numbers(
    trials: TrialPairs, x: FloatArray, found: Uncertainty
) -> tuple[FloatArray, FloatArray]:
    """Compute standard errors (p,), NaN at a bound, and correlations (p, p) of fitted numbers."""
    space = trials.space
    inside = np.clip(x, space.low + 1e-6 * space.step, space.high - 1e-6 * space.step)
    slopes = trials.slopes(inside)
    covariance = slopes @ found.covariance @ slopes.T
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    known = errors > _NO_ERROR
    correlation = correlations(covariance * np.outer(known, known))
    return np.where(known, errors, np.nan), correlation
