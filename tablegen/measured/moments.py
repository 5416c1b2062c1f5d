"""Moments of the rebounds of each shape and of mixtures of shapes, with their chance errors.

Each shape of a mixture has the same number of particles, whatever its weight. So raw moments are
exactly linear in the weights, and their chance errors are those of the shapes alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tablegen.accuracy.descriptive import scattering_angles
from tablegen.measured.measurements import QUANTITIES
from tablegen.model.float_array import FloatArray

#: Columns of `variables_of` that hold u and v.
_U, _V = 0, 1


def variables_of(state: FloatArray) -> FloatArray:
    """Compute the variables (m, 5) whose moments are kept, from states (m, 6) of rebounds.

    They are u and v over V, the angles from the wall in the impact plane and out of it [degrees],
    and omega_z a/V.
    """
    angles = np.degrees(scattering_angles(state))
    return np.column_stack((state[:, :2], *angles, state[:, 5]))


class CentralMoments(NamedTuple):
    """Means and central moments of variables of rebounds; arrays of shape (..., 5)."""

    mean: FloatArray
    #: Mean second, third and fourth powers of the deviations from the mean.
    second: FloatArray
    third: FloatArray
    fourth: FloatArray
    #: Shape (...). Covariance of u and v.
    covariance: FloatArray


def central_moments(variables: FloatArray) -> CentralMoments:
    """Compute the moments of variables (m, 5) of m rebounds."""
    mean = variables.mean(axis=0)
    y = variables - mean
    square = y * y
    return CentralMoments(
        mean=mean,
        second=square.mean(axis=0),
        third=(square * y).mean(axis=0),
        fourth=(square * square).mean(axis=0),
        covariance=(y[:, _U] * y[:, _V]).mean(),
    )


@dataclass(frozen=True)
class SimulatedMoments:
    """Simulated means and standard deviations at n conditions, and their chance errors.

    Each maps a name of `QUANTITIES` to an array of shape (n,); NaN if the quantity is undefined.
    An error is one standard deviation of the results of other seeds.
    """

    mean: Mapping[str, FloatArray]
    std: Mapping[str, FloatArray]
    mean_error: Mapping[str, FloatArray]
    std_error: Mapping[str, FloatArray]


@dataclass(frozen=True)
class Strata:
    """Moments at n conditions of s shapes."""

    #: Impact angles, degrees, (n,).
    alpha_deg: FloatArray
    #: Shares of the shapes in the population, of sum 1, (s,).
    shares: FloatArray
    #: Number of particles of each shape at each condition.
    count: int
    #: Arrays of shape (n, s, 5).
    moments: CentralMoments

    def mixed(self, shares: ArrayLike | None = None) -> SimulatedMoments:
        """Compute the moments of a mixture with other shares (s,) of sum 1."""
        given = np.asarray(self.shares if shares is None else shares, dtype=np.float64)
        weight = given[None, :, None]
        part = self.moments
        mean = (weight * part.mean).sum(axis=1)
        d = part.mean - mean[:, None, :]
        variance = (weight * (part.second + d**2)).sum(axis=1)
        mean_error = np.sqrt((weight**2 * part.second).sum(axis=1) / self.count)
        # Variance of (x - mean)^2 in a stratum. The error of the mean does not contribute: at the
        # mean the spread is least.
        of_squares = part.fourth + 4 * d * part.third + 4 * d**2 * part.second - part.second**2
        error2 = (weight**2 * np.maximum(of_squares, 0.0)).sum(axis=1) / self.count
        std = np.sqrt(variance)
        std_error = 0.5 * np.sqrt(error2) / np.where(std > 0.0, std, np.inf)
        means, mean_errors = self._by_name(mean), self._by_name(mean_error)
        means["rebound_angle_deg"] = np.degrees(np.arctan2(mean[:, _V], mean[:, _U]))
        mean_errors["rebound_angle_deg"] = self._angle_error(given, mean)
        return SimulatedMoments(means, self._by_name(std), mean_errors, self._by_name(std_error))

    def _angle_error(self, shares: FloatArray, mean: FloatArray) -> FloatArray:
        """Compute the chance error of the angle of the mean velocity [degrees], (n,)."""
        u, v = mean[:, None, _U], mean[:, None, _V]
        part = self.moments
        across = u**2 * part.second[..., _V] + v**2 * part.second[..., _U]
        across = np.maximum(across - 2.0 * u * v * part.covariance, 0.0)
        total = np.sqrt((shares**2 * across).sum(axis=1) / self.count)
        error: FloatArray = np.degrees(total / (u**2 + v**2)[:, 0])
        return error

    def _by_name(self, values: FloatArray) -> dict[str, FloatArray]:
        """Scale values (n, 5) of the variables to those of the quantities."""
        alpha = np.radians(self.alpha_deg)
        cosine = np.where(self.alpha_deg < 90.0, np.cos(alpha), np.nan)
        scale = {"e_n": 1.0 / np.sin(alpha), "e_t": 1.0 / cosine}
        return {
            name: scale.get(name, 1.0) * values[:, q.variable] for name, q in QUANTITIES.items()
        }
