"""Compute the numbers that the spin law is fitted to: inputs from conditions, outcomes of rebounds.

A grain arrives with the spin s = a Omega / V and the inertia k about it, over m a^2. Its energy is
m V^2 / 2 times E = 1 + k |s|^2. The rebound divides E between translation, rotation and the wall.
The outcomes p, o and kappa are coordinates of a rebound in which any values are possible: whatever
values a table draws, the grain gains no energy, and its inertia is one that it may have.

Units: angles in rad, speeds in m/s, spins in V/a, inertias over m a^2, energies over m V^2 / 2.
Docstrings name the formulae; `tables/FORMAT.md` has them once more, in the order of a draw.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from sampler.formats.bounds import (
    EQUAL_MOMENTS,
    FOLD,
    LEAST_REST,
    N_CONDITIONS,
    N_FEATURES,
    N_INPUTS,
    RATIOS,
    SPIN_CORE,
)
from tablegen.model.float_array import FloatArray
from tablegen.simulation.impact_chains import Impacts, effective_speed

#: Sizes of the spin over V/a that a law covers.
SPIN_RANGE = (0.0, 10.0)

#: Signs under reflection in the impact plane: of the first seven outcomes, and of the inputs.
OUTCOME_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0, 1.0])
INPUT_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0])

#: Column of sigma_x among the inputs.
_SIGMA_X = 2

#: Pairs of numbers of a condition whose products are features.
_PAIRS = np.triu_indices(N_CONDITIONS)


class SpeedCoordinate(NamedTuple):
    """The coordinate exp(-coefficient V_e^exponent) of an effective speed V_e in m/s."""

    coefficient: float
    exponent: float

    def transform(self, speed: FloatArray) -> FloatArray:
        """Compute the coordinate of speeds [m/s]."""
        return np.exp(-self.coefficient * speed**self.exponent)


class Moments(NamedTuple):
    """Largest and smallest moments of inertia of n grains over m a^2, (n,) each."""

    largest: FloatArray
    smallest: FloatArray

    @property
    def differ(self) -> NDArray[np.bool_]:
        """Whether the two moments of each grain differ, (n,)."""
        return np.asarray(self.largest - self.smallest > EQUAL_MOMENTS * self.largest)


def kappa_from_inertia(inertia: FloatArray, moments: Moments) -> FloatArray:
    """Compute the place kappa of inertias k between the moments J of their grains, (n,).

    With q = (1 / J_smallest - 1 / k) / (1 / J_smallest - 1 / J_largest),

        kappa = sqrt(q) / (sqrt(q) + sqrt(1 - q)).

    kappa is 0 for a grain that turns about its longest axis, 1 for one that turns about its
    shortest axis, and 1/2 if both moments are equal. Near 0 and near 1 it changes in proportion to
    the angle between spin and axis.
    """
    high, low = 1.0 / moments.smallest, 1.0 / moments.largest
    span = np.where(moments.differ, high - low, 1.0)
    place = np.clip((high - 1.0 / inertia) / span, 0.0, 1.0)
    return np.where(moments.differ, kappa_from_place(place), 0.5)


def kappa_from_place(place: FloatArray) -> FloatArray:
    """Compute kappa from the place q, from 0 to 1, of a reciprocal inertia between its ends."""
    first, second = np.sqrt(place), np.sqrt(1.0 - place)
    return first / (first + second)


def inertia_from_kappa(kappa: FloatArray, moments: Moments) -> FloatArray:
    """Compute the inertias over m a^2 at places kappa from 0 to 1, (n,)."""
    place = kappa**2 / (kappa**2 + (1.0 - kappa) ** 2)
    high, low = 1.0 / moments.smallest, 1.0 / moments.largest
    return np.where(moments.differ, 1.0 / (high - place * (high - low)), moments.largest)


def impact_inputs(impacts: Impacts, moments: Moments, speed: SpeedCoordinate) -> FloatArray:
    """Compute the inputs of impacts, (n, 8).

    The inputs are sqrt(alpha1), the coordinate of V_e, the vector sigma in wall axes, kappa of the
    inertia, b/a and c/b. The vector

        sigma = s (SPIN_CORE / |s| + (1 + |s|^2)^(-1/4))

    has the direction of the spin s. Its size begins at `SPIN_CORE`, because the law depends on the
    direction of even the slowest spin. It grows in proportion to a small spin, and with the root of
    a large one, on which the law depends less. Without spin, sigma and kappa are 0.
    """
    spin = impacts.spin
    size = np.linalg.norm(spin, axis=1)
    has_spin = size > 0.0
    factor = SPIN_CORE / np.where(has_spin, size, 1.0) + 1.0 / np.sqrt(np.sqrt(1.0 + size * size))
    inertia = np.where(has_spin, impacts.inertia, moments.largest)
    return np.column_stack(
        [
            np.sqrt(impacts.alpha1),
            speed.transform(effective_speed(impacts)),
            spin * factor[:, None],
            np.where(has_spin, kappa_from_inertia(inertia, moments), 0.0),
            impacts.grain[:, 1:],
        ]
    )


def choose_reflected(inputs: FloatArray, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Choose the conditions that are fitted as their mirror images, (n,), as a draw does.

    Conditions with negative sigma_x are reflected, so that the law is fitted once for both signs.
    Within `FOLD` of 0 the choice is random: the law would otherwise jump at sigma_x = 0.
    """
    keep_probability = 0.5 + inputs[:, _SIGMA_X] * (0.5 / FOLD)
    return np.asarray(rng.random(len(inputs)) >= keep_probability)


def reflect(values: FloatArray, is_reflected: NDArray[np.bool_], signs: FloatArray) -> FloatArray:
    """Reflect some rows of inputs or outcomes in the impact plane.

    Parameters
    ----------
    values : (n, d) float64
    is_reflected : (n,) bool
    signs : (d,) float64
        `INPUT_SIGNS` for inputs, `OUTCOME_SIGNS` for outcomes.
    """
    return np.where(is_reflected[:, None], values * signs, values)


def rebound_outcomes(states: FloatArray, inertia: FloatArray, energy: FloatArray) -> FloatArray:
    """Compute the outcomes p and o of rebounds, (n, 6).

    With the velocity c over V and the spin s after the rebound, the inertia k about it, and the
    energy E before the rebound,

        p = c / sqrt(E - |c|^2),    o = s sqrt(k) / sqrt(E - |c|^2 - k |s|^2).

    The last root is that of the energy that the wall takes.

    Parameters
    ----------
    states : (n, 6) float64
        Velocities over V, and angular velocities times a/V, after the rebound.
    inertia : (n,) float64
        Inertias about the spin after the rebound, over m a^2.
    energy : (n,) float64
        Energies before the rebound, over m V^2 / 2.
    """
    velocity, spin = states[:, :3], states[:, 3:]
    remainder = energy - np.sum(velocity**2, axis=1)
    loss = remainder - inertia * np.sum(spin**2, axis=1)
    remainder, loss = (np.maximum(part, LEAST_REST * energy)[:, None] for part in (remainder, loss))
    return np.hstack([velocity / np.sqrt(remainder), spin * np.sqrt(inertia[:, None] / loss)])


def normal_work_outcome(works: FloatArray) -> FloatArray:
    """Compute the outcome a of normal and shear works (n, 2): the sixth root of the normal share.

    At grazing incidence the share is so small that its sixth root is easier to interpolate.
    """
    taken = works.sum(axis=1)
    share = np.divide(works[:, 0], taken, out=np.zeros_like(taken), where=taken > 0.0)
    return np.cbrt(np.sqrt(np.clip(share, 0.0, 1.0)))


def features(t: FloatArray, dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """Compute the features of standardised inputs t (n, 8): arrays (n, 30) of a type.

    The features are 1, the inputs t_i, the products t_i t_j for i < j < 6, and t_i^2 - 1/2 for
    i < 6, where the first six inputs are those of the impact and the last two are the ratios.
    """
    phi = np.empty((len(t), N_FEATURES), dtype=dtype)
    phi[:, 0], phi[:, 1 : 1 + N_INPUTS] = 1.0, t
    for column, (i, j) in enumerate(zip(*_PAIRS, strict=True), 1 + N_INPUTS):
        phi[:, column] = t[:, i] * t[:, j] - 0.5 * (i == j)
    return phi


def used_features(varies: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Find which of the 30 features are not constant, from which of the 8 inputs vary."""
    i, j = _PAIRS
    return np.concatenate([[True], varies, varies[i] & varies[j]])


#: Number of the axis |sigma|^2 of a tree: it follows the six inputs of the impact.
SPIN_AXIS = N_CONDITIONS
#: Number of the axis of a tree for each input; the ratios come last.
AXES = np.array([*range(N_CONDITIONS), *(N_CONDITIONS + 1 + k for k in range(len(RATIOS)))])
