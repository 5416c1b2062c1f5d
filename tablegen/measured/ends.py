"""What is worked out once the search has ended: errors of the fit, and every number once more."""

from typing import NamedTuple

import numpy as np

from tablegen.config.config import Config
from tablegen.measured.chance import error_covariances
from tablegen.measured.evaluations import Evaluations
from tablegen.measured.records import Measurements
from tablegen.measured.result import FittedNumber
from tablegen.measured.search import Search
from tablegen.measured.simulated_moments import SimulatedRows
from tablegen.measured.targets import Targets
from tablegen.measured.trial_pairs import TrialPairs
from tablegen.measured.uncertainty import Problem, Uncertainty, uncertainty
from tablegen.model.float_array import FloatArray

#: What the seed of the numbers that are reported differs by from that of the fit, whose
#: coordinates follow its own chance a little.
_OTHER_SEED = 0x5EED

#: And that of the second set of random numbers for slopes.
_SEED_OF_SLOPES = 0x510E

#: Standard errors below this are the rounding of those at a bound.
_NO_ERROR = 1e-7

#: Last steps at most, and the part by which one may raise the cost, which is rough.
_LAST_STEPS = 4
_TOLERATED = 0.01

#: Singular values below this part of the largest are not followed in the last steps.
_OPEN = 1e-2


class Rows(NamedTuple):
    """Rows of measurements with their simulations and their numbers."""

    measurements: Measurements
    #: Their places in the file.
    at: list[int]
    evaluations: Evaluations
    targets: Targets


def particles_of_end(trials: TrialPairs, count: int) -> int:
    """Particles of each shape and condition that are simulated after a search, at most."""
    free = int(np.count_nonzero(~trials.of_shares))
    return (2 * (1 + 2 * free) + _LAST_STEPS) * count


def settled(rows: Rows, search: Search, x: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Go the last steps of a search by slopes that have less chance in them.

    The cost of a fit is rough on the scale of the standard errors, and the optimiser stops where
    its slopes, of one set of random numbers, find no way down. Here they are means of two sets.

    Returns
    -------
    x : (p,) float64
    slopes : (m, p) float64
    """
    evaluations, trials = rows.evaluations, rows.evaluations.trials
    both = evaluations, evaluations.with_seed(evaluations.seed ^ _SEED_OF_SLOPES)
    slopes: FloatArray = np.mean(
        [one.slopes(x, count, rows.targets.pick, central=True) for one in both], axis=0
    )
    accuracy, width = search.accuracy(x, count), trials.last - trials.first
    free = (x > trials.low) & (x < trials.high)
    inverse = np.linalg.pinv(slopes[:, free] * width[free] / accuracy[:, None], rcond=_OPEN)
    residual = search.residuals(x, count) / accuracy
    for _ in range(_LAST_STEPS):
        further = x.copy()
        further[free] -= width[free] * (inverse @ residual)
        further = np.clip(further, trials.low, trials.high)
        left = search.residuals(further, count) / accuracy
        if np.sum(left**2) > (1.0 + _TOLERATED) * np.sum(residual**2):
            break
        x, residual = further, left
    return search.on_bounds(x), slopes


def errors_of_fit(
    rows: Rows, search: Search, x: FloatArray, slopes: FloatArray, count: int
) -> Uncertainty:
    """Covariance of the coordinates and warnings, at the end of a search."""
    evaluations, targets = rows.evaluations, rows.targets
    trials = evaluations.trials
    measured, simulated = error_covariances(
        targets,
        evaluations.variables(x, count),
        trials.shares(x),
        rows.measurements.alpha_deg,
        rows.measurements.count,
        count,
    )
    return uncertainty(
        Problem(
            names=trials.labels,
            x=x,
            low=trials.low,
            high=trials.high,
            width=trials.last - trials.first,
            slopes=slopes,
            residual=search.residuals(x, count),
            accuracy=search.accuracy(x, count),
            counted=targets.counted,
            measured=measured,
            simulated=simulated,
        )
    )


def numbers_beside(
    rows: Rows, config: Config, x: FloatArray, covariance: FloatArray, count: int, held_out: bool
) -> list[FittedNumber]:
    """Every measured number beside that of the fitted pair, simulated with other random numbers."""
    if not rows.at:
        return []
    evaluations, targets = rows.evaluations, rows.targets
    made = SimulatedRows(
        config.pair,
        config.population,
        *evaluations.conditions,
        seed=evaluations.seed ^ _OTHER_SEED,
        numerics=config.model,
        wall_tilt_deg=evaluations.trials.wall_tilt_deg(x),
        threads=evaluations.threads,
    ).moments(count)
    values, chances = targets.pick(made)
    slopes = evaluations.slopes(x, count, targets.pick, central=True)
    variance = np.einsum("mp,pq,mq->m", slopes, covariance, slopes)
    predicted = np.sqrt(np.maximum(variance, 0.0) + chances**2)
    stated = rows.measurements.speed
    return [
        FittedNumber(
            row=rows.at[row],
            alpha_deg=float(rows.measurements.alpha_deg[row]),
            speed=float(stated[row]) if np.isfinite(stated[row]) else None,
            column=column,
            measured=float(targets.measured[k]),
            accuracy=float(targets.accuracy[k]),
            simulated=float(values[k]),
            chance=float(chances[k]),
            predicted=float(predicted[k]),
            held_out=held_out,
        )
        for k, (row, column) in enumerate(zip(targets.row, targets.columns, strict=True))
    ]


def errors_of_numbers(
    trials: TrialPairs, x: FloatArray, found: Uncertainty
) -> tuple[FloatArray, FloatArray]:
    """Give standard errors (k,) of the fitted numbers, NaN where unknown, and covariance (k, k)."""
    inside = np.clip(x, trials.low + 1e-6 * trials.step, trials.high - 1e-6 * trials.step)
    slopes = trials.slopes(inside)
    covariance = slopes @ found.covariance @ slopes.T
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    known = errors > _NO_ERROR
    return np.where(known, errors, np.nan), covariance * np.outer(known, known)
