"""Means and spreads of the rebounds of a mixture of shapes, with their chance errors.

Each shape of a mixture has the same number of particles, whatever its weight.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tablegen.accuracy.descriptive import scattering_angles
from tablegen.measured.measurements import QUANTITIES
from tablegen.model.float_array import FloatArray

#: Columns of `variables_of` that hold u and v.
_U, _V = 0, 1

#: Variable of each quantity.
_ORDER = [quantity.variable for quantity in QUANTITIES.values()]


def variables_of(state: FloatArray) -> FloatArray:
    """Compute the variables (m, 5) whose moments are kept, from states (m, 6) of rebounds.

    They are u and v over V, the angles from the wall in the impact plane and out of it [degrees],
    and omega_z a/V.
    """
    angles = np.degrees(scattering_angles(state))
    return np.column_stack((state[:, :2], *angles, state[:, 5]))


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

    @classmethod
    def from_rows(cls, rows: Sequence[FloatArray]) -> "SimulatedMoments":
        """Put together the `mixed_moments` of n rows."""
        stacked = np.array(rows)
        return cls(*(dict(zip(QUANTITIES, part.T, strict=True)) for part in stacked.swapaxes(0, 1)))


def mixed_moments(
    parts: Sequence[FloatArray], shares: Sequence[float], alpha_deg: float
) -> FloatArray:
    """Compute mean, standard deviation and their chance errors of each of q quantities, (4, q).

    Takes the variables (m, 5) of the particles of each shape, and the shares of the shapes, of sum
    1, at an impact angle in degrees.
    """

    def average(function: Callable[[FloatArray], FloatArray]) -> FloatArray:
        total = sum(w * function(x).mean(axis=0) for w, x in zip(shares, parts, strict=True))
        return np.asarray(total)

    def chance_error(function: Callable[[FloatArray], FloatArray]) -> FloatArray:
        variances = (
            w**2 * function(x).var(axis=0) / len(x) for w, x in zip(shares, parts, strict=True)
        )
        return np.asarray(np.sqrt(sum(variances)))

    mean = average(np.asarray)
    std = np.sqrt(average(lambda x: (x - mean) ** 2))
    # the error of the mean does not contribute: at the mean the spread is least
    std_error = 0.5 * chance_error(lambda x: (x - mean) ** 2) / np.where(std > 0.0, std, np.inf)
    moments = np.array([mean, std, chance_error(np.asarray), std_error])[:, _ORDER]
    alpha, (u, v), names = np.radians(alpha_deg), mean[[_U, _V]], list(QUANTITIES)
    moments[:, names.index("e_n")] /= np.sin(alpha)
    moments[:, names.index("e_t")] /= np.cos(alpha) if alpha_deg < 90.0 else np.nan
    # the angle of the mean velocity errs by what is across it
    across = chance_error(lambda x: u * x[:, _V] - v * x[:, _U]) / (u**2 + v**2)
    angle = [np.arctan2(v, u), across]
    moments[[0, 2], names.index("rebound_angle_deg")] = np.degrees(angle)
    return moments
