"""Chance errors of measured and of simulated moments, and how they go together within a row.

Means and spreads of one row come from the same particles, so their errors are correlated: where
restitution is skew its mean and spread err together, and e_n with e_t. To first order a moment errs
by the mean of its influence function over the particles: x - mean for a mean, and
((x - mean)^2 - variance) / (2 spread) for a spread. Source: F. R. Hampel, J. Am. Stat. Assoc. 69
(1974) 383-393.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from tablegen.measured.records import QUANTITIES
from tablegen.measured.targets import Targets
from tablegen.model.float_array import FloatArray

#: Columns of `tablegen.measured.strata.variables_of`.
_V, _U = 1, 0
_COLUMN = dict(zip(QUANTITIES, (_V, _U, 2, 3, 4), strict=True))


def influences(
    variables: Sequence[FloatArray], shares: FloatArray, alpha: float, columns: Sequence[str]
) -> list[FloatArray]:
    """Influence functions of moments of a mixture of shapes.

    Parameters
    ----------
    variables : sequence of (q, 5) float64
        Of particles of each shape, as `tablegen.measured.strata.variables_of` gives them.
    shares : (s,) float64
    alpha : float
        Impact angle [rad].
    columns : sequence of str
        Names of the moments, with ``_std`` behind those of spreads.

    Returns
    -------
    list of (q, k) float64
        For each shape, a column for each moment.
    """
    mean = sum(w * x.mean(axis=0) for w, x in zip(shares, variables, strict=True))
    square = sum(w * ((x - mean) ** 2).mean(axis=0) for w, x in zip(shares, variables, strict=True))
    scale = {"e_n": 1.0 / np.sin(alpha), "e_t": 1.0 / np.cos(alpha)}

    def one(x: FloatArray, column: str) -> FloatArray:
        name = column.removesuffix("_std")
        deviation = x - mean
        if column == "rebound_angle_deg":
            u, v = mean[_U], mean[_V]
            across = u * deviation[:, _V] - v * deviation[:, _U]
            return np.degrees(across / (u * u + v * v))
        k = _COLUMN[name]
        found = deviation[:, k]
        if column != name:
            # a spread of zero has no error
            found = (found**2 - square[k]) / max(2.0 * np.sqrt(square[k]), 1e-300)
            found = found if square[k] > 0.0 else np.zeros_like(found)
        return np.asarray(scale.get(name, 1.0) * found)

    return [np.column_stack([one(x, column) for column in columns]) for x in variables]


def covariances(found: Sequence[FloatArray], shares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Covariances (k, k) of moments, for one particle.

    Returns
    -------
    measured : (k, k) float64
        Of particles drawn from the mixture; over n it is that of moments of n particles.
    simulated : (k, k) float64
        Of strata with one particle each; over n it is that of n of each shape.
    """
    within = [np.cov(x, rowvar=False, bias=True).reshape(x.shape[1], -1) for x in found]
    means = [x.mean(axis=0) for x in found]
    measured = sum(w * (c + np.outer(m, m)) for w, c, m in zip(shares, within, means, strict=True))
    simulated = sum(w * w * c for w, c in zip(shares, within, strict=True))
    return np.asarray(measured), np.asarray(simulated)


def error_covariances(
    targets: Targets,
    variables: Sequence[Sequence[FloatArray]],
    shares: FloatArray,
    alpha_deg: FloatArray,
    counts: FloatArray,
    simulated_count: int,
) -> tuple[FloatArray, FloatArray]:
    """Covariances (m, m) of the errors of measured and of simulated numbers.

    Parameters
    ----------
    targets : Targets
    variables : sequence of n sequences
        Of each row, variables of particles of each shape.
    shares : (s,) float64
    alpha_deg : (n,) float64
    counts : (n,) float64
        Measured particles; NaN where they are not stated, so that the error is zero here.
    simulated_count : int
        Of each shape at each condition.

    Returns
    -------
    tuple of two (m, m) float64
    """
    measured, simulated = [], []
    columns = np.array(targets.columns)
    for row in range(len(alpha_deg)):
        names = list(columns[targets.row == row])
        if names:
            found = influences(variables[row], shares, np.radians(alpha_deg[row]), names)
            one, other = covariances(found, shares)
            measured.append(one / counts[row] if counts[row] > 1.0 else 0.0 * one)
            simulated.append(other / simulated_count)
    return block_diag(*measured), block_diag(*simulated)
