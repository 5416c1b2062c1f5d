"""Conditions and outcomes of the spin law as the numbers that are fitted.

With spin s = a Omega / V before the impact, no body of half-size a has a moment of inertia above
2/3 m a^2, and so no more energy than m V_e^2 / 2, V_e = V sqrt(1 + 2/3 |s|^2). A grain with the
largest moment j_1 m a^2 has at most m V^2 E / 2, E = 1 + j_1 |s|^2. That bounds its speed after the
impact.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import LEAST_REST, N_CONDITIONS
from tablegen.model.float_array import FloatArray
from tablegen.simulation.impact_chains import energy_factor

#: Sizes of the spin over V/a that a law covers.
SPIN_RANGE = (0.0, 10.0)

#: Signs of the outcomes, and of the numbers of a condition, under reflection in the impact plane.
OUTCOME_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
CONDITION_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, 1.0])

#: Pairs of numbers of a condition whose products are features.
_PAIRS = np.triu_indices(N_CONDITIONS)


class SpeedCoordinate(NamedTuple):
    """The coordinate exp(-coefficient V_e^exponent) of a speed in m/s."""

    coefficient: float
    exponent: float

    def of(self, speed: FloatArray) -> FloatArray:
        """Compute the coordinate of speeds [m/s]."""
        return np.exp(-self.coefficient * speed**self.exponent)


def coordinates(conditions: FloatArray, speed: SpeedCoordinate) -> FloatArray:
    """Compute the coordinates q of impacts: sqrt(alpha1), that of V_e, and tau of the spin.

    Conditions, (n, 5), are the impact angle [rad], V [m/s] and the spin s over V/a in wall axes.
    tau = s / (1 + |s|^2)^(1/4) is s where that is small, and grows with the root of a large one, on
    which a law depends less. Larger spins than `SPIN_RANGE` have the tau of the largest.
    """
    spin = conditions[:, 2:]
    square = np.sum(spin * spin, axis=1)
    most = SPIN_RANGE[1] ** 2
    scale = np.sqrt(np.where(square > most, most / np.maximum(square, most), 1.0))
    scale /= np.sqrt(np.sqrt(1.0 + np.minimum(square, most)))
    return np.column_stack(
        [
            np.sqrt(conditions[:, 0]),
            speed.of(conditions[:, 1] * energy_factor(spin)),
            spin * scale[:, None],
        ]
    )


def outcomes(states: FloatArray, energy: FloatArray) -> FloatArray:
    """Compute the outcomes x of rebounds from states (n, 6) and energies E before, (n,).

    Velocities over V sqrt(E) become w / sqrt(1 - |w|^2), so that only the positive normal velocity
    is bounded. Angular velocities are times a / (V sqrt(E)).
    """
    scaled = states / np.sqrt(energy)[:, None]
    rest = np.maximum(1.0 - np.sum(scaled[:, :3] ** 2, axis=1), LEAST_REST)
    return np.column_stack([scaled[:, :3] / np.sqrt(rest)[:, None], scaled[:, 3:]])


def work_shares(
    states: FloatArray, works: FloatArray, energy: FloatArray, least: FloatArray
) -> FloatArray:
    """Compute the outcomes a and b of works over m V^2 / 2, (n, 2).

    The works have the share b of what states (n, 6) leave of the energies E before, (n,), if they
    rotate about the axes of the least moments of inertia (n,); the normal work has a^6 of that.
    At grazing incidence it is so small that its sixth root is easier to interpolate.
    """
    left = energy - np.sum(states[:, :3] ** 2, axis=1) - least * np.sum(states[:, 3:] ** 2, axis=1)
    taken = works.sum(axis=1)
    share = np.divide(works[:, 0], taken, out=np.zeros_like(taken), where=taken > 0.0)
    part = np.divide(taken, left, out=np.zeros_like(taken), where=left > 0.0)
    return np.column_stack([np.cbrt(np.sqrt(np.clip(share, 0.0, 1.0))), np.clip(part, 0.0, 1.0)])


def folded(q: FloatArray, turned: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Reflect the conditions (n, 5) that are ``turned``, (n,), in the impact plane.

    Returns the conditions, and factors of the outcomes, (n, 6): `OUTCOME_SIGNS` for reflected
    conditions, else 1.
    """
    mirrored = turned[:, None]
    return np.where(mirrored, q * CONDITION_SIGNS, q), np.where(mirrored, OUTCOME_SIGNS, 1.0)


def features(t: FloatArray) -> FloatArray:
    """Compute the features (n, 23) of standardised conditions and ratios t (n, 7).

    They are 1, t_i, and t_i t_j for i <= j < 5, less 1/2 where i = j.
    """
    i, j = _PAIRS
    products = t[:, i] * t[:, j] - 0.5 * (i == j)
    return np.hstack([np.ones((len(t), 1)), t, products])


def used_features(varies: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Select the features, (23,), that vary if only some of the 7 inputs do, (7,)."""
    i, j = _PAIRS
    return np.concatenate([[True], varies, varies[i] & varies[j]])
