"""Moments of rebounds, each shape on its own, and those of any mixture of the shapes.

A mixture is stratified by shape: each has equally many particles whatever its weight. So raw
moments are exactly linear in the weights, and their chance errors are those of the strata alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tablegen.measured.records import QUANTITIES
from tablegen.model.float_array import FloatArray

#: Variables of a rebound whose moments are kept: u and v over V, the angle from the wall in the
#: impact plane and that out of it, in degrees, and omega_z a/V.
N_VARIABLES = 5
_U, _V = 0, 1

#: Variable of each quantity.
_VARIABLE = dict(zip(QUANTITIES, (_V, _U, 2, 3, 4), strict=True))


def variables_of(state: FloatArray) -> FloatArray:
    """Variables of rebound states.

    Parameters
    ----------
    state : (m, 6) float64

    Returns
    -------
    (m, N_VARIABLES) float64
    """
    u, v, w = state[:, 0], state[:, 1], state[:, 2]
    in_plane = np.degrees(np.arctan2(v, u))
    out_of_plane = np.degrees(np.arctan2(w, np.hypot(u, v)))
    return np.column_stack((u, v, in_plane, out_of_plane, state[:, 5]))


@dataclass(frozen=True)
class CentralMoments:
    """Means and central moments of variables of some rebounds; arrays of shape (..., variables)."""

    count: int
    mean: FloatArray
    #: Mean second, third and fourth powers of the deviations from the mean.
    second: FloatArray
    third: FloatArray
    fourth: FloatArray
    #: Shape (...). Covariance of u and v.
    covariance: FloatArray


def central_moments(variables: FloatArray) -> CentralMoments:
    """Moments of the variables (m, N_VARIABLES) of m rebounds."""
    mean = variables.mean(axis=0)
    y = variables - mean
    square = y * y
    return CentralMoments(
        count=len(variables),
        mean=mean,
        second=square.mean(axis=0),
        third=(square * y).mean(axis=0),
        fourth=(square * square).mean(axis=0),
        covariance=(y[:, _U] * y[:, _V]).mean(),
    )


def merged(first: CentralMoments, second: CentralMoments) -> CentralMoments:
    """Moments of two samples together.

    Updated from the step between the means, so that nothing cancels. Source: Pebay, "Formulas for
    robust, one-pass parallel computation of covariances and arbitrary-order statistical moments",
    Sandia report SAND2008-6212 (2008), eqs. 2.1 and 3.1.
    """
    count = first.count + second.count
    p, q = first.count / count, second.count / count
    d = second.mean - first.mean
    return CentralMoments(
        count=count,
        mean=first.mean + q * d,
        second=p * first.second + q * second.second + p * q * d**2,
        third=p * first.third
        + q * second.third
        + 3.0 * p * q * d * (second.second - first.second)
        + p * q * (p - q) * d**3,
        fourth=p * first.fourth
        + q * second.fourth
        + 4.0 * p * q * d * (second.third - first.third)
        + 6.0 * p * q * d**2 * (p * second.second + q * first.second)
        + p * q * (p**3 + q**3) * d**4,
        covariance=p * first.covariance + q * second.covariance + p * q * d[_U] * d[_V],
    )


@dataclass(frozen=True)
class SimulatedMoments:
    """Simulated means and standard deviations at n conditions, and their chance errors.

    Each maps a name of `QUANTITIES` to an array of shape (n,); NaN where the quantity is not
    defined. The errors are one standard deviation of what another seed would give.
    """

    mean: Mapping[str, FloatArray]
    std: Mapping[str, FloatArray]
    mean_error: Mapping[str, FloatArray]
    std_error: Mapping[str, FloatArray]


@dataclass(frozen=True)
class Strata:
    """Moments at n conditions of s shapes, each simulated on its own.

    Attributes
    ----------
    alpha_deg : (n,) float64
    shares : (s,) float64
        Shares of the shapes in the population; their sum is 1.
    moments : CentralMoments
        Arrays of shape (n, s, N_VARIABLES); ``count`` is of each shape at each condition.
    """

    alpha_deg: FloatArray
    shares: FloatArray
    moments: CentralMoments

    def mixed(self, shares: ArrayLike | None = None) -> SimulatedMoments:
        """Moments of a mixture of the shapes.

        Parameters
        ----------
        shares : (s,) array, optional
            Shares of the shapes, of sum 1; those of the population if left out.

        Returns
        -------
        SimulatedMoments
        """
        given = np.asarray(self.shares if shares is None else shares, dtype=np.float64)
        weight = given[None, :, None]
        part, count = self.moments, self.moments.count
        mean = (weight * part.mean).sum(axis=1)
        d = part.mean - mean[:, None, :]
        variance = (weight * (part.second + d**2)).sum(axis=1)
        mean_error = np.sqrt((weight**2 * part.second).sum(axis=1) / count)
        # Variance of (x - mean)^2 in a stratum. The mean's own error does not count: at the mean
        # the spread is least.
        of_squares = part.fourth + 4 * d * part.third + 4 * d**2 * part.second - part.second**2
        error2 = (weight**2 * np.maximum(of_squares, 0.0)).sum(axis=1) / count
        std = np.sqrt(variance)
        std_error = 0.5 * np.sqrt(error2) / np.where(std > 0.0, std, np.inf)
        angle_error = self._angle_error(given, mean)
        return self._named(mean, std, mean_error, std_error, angle_error)

    def _angle_error(self, shares: FloatArray, mean: FloatArray) -> FloatArray:
        """Chance error of the angle of the mean velocity [degrees], (n,)."""
        u, v = mean[:, None, _U], mean[:, None, _V]
        part = self.moments
        across = u**2 * part.second[..., _V] + v**2 * part.second[..., _U]
        across = np.maximum(across - 2.0 * u * v * part.covariance, 0.0)
        total = np.sqrt((shares**2 * across).sum(axis=1) / part.count)
        error: FloatArray = np.degrees(total / (u**2 + v**2)[:, 0])
        return error

    def _named(
        self,
        mean: FloatArray,
        std: FloatArray,
        mean_error: FloatArray,
        std_error: FloatArray,
        angle_error: FloatArray,
    ) -> SimulatedMoments:
        """Moments of the quantities from those of the variables, (n, N_VARIABLES)."""
        alpha = np.radians(self.alpha_deg)
        # none at normal impact
        cosine = np.where(self.alpha_deg < 90.0, np.cos(alpha), np.nan)
        scale = {"e_n": 1.0 / np.sin(alpha), "e_t": 1.0 / cosine}

        def named(values: FloatArray) -> dict[str, FloatArray]:
            return {name: scale.get(name, 1.0) * values[:, k] for name, k in _VARIABLE.items()}

        means, errors = named(mean), named(mean_error)
        means["rebound_angle_deg"] = np.degrees(np.arctan2(mean[:, _V], mean[:, _U]))
        errors["rebound_angle_deg"] = angle_error
        return SimulatedMoments(means, named(std), errors, named(std_error))
