"""Conditions and outcomes of the spin law as the numbers that are fitted.

A grain that arrives with the spin s = a Omega / V and the inertia k about it, over m a^2, has the
energy m V^2 / 2 times E = 1 + k |s|^2. What it leaves with is a part of that energy: so much in
its velocity, so much in its rotation, and the rest is the loss. The outcomes p, o and kappa are
such that any values of them are a possible rebound (`sampler.formats.bounds.OUTCOMES`).
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

#: Signs of the first seven outcomes under reflection in the impact plane, and of the inputs.
OUTCOME_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0, 1.0])
INPUT_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0])

#: Column of sigma_x among the inputs.
_SIGMA_X = 2

#: Pairs of numbers of a condition whose products are features.
_PAIRS = np.triu_indices(N_CONDITIONS)


class SpeedCoordinate(NamedTuple):
    """The coordinate exp(-coefficient V_e^exponent) of a speed in m/s."""

    coefficient: float
    exponent: float

    def of(self, speed: FloatArray) -> FloatArray:
        """Compute the coordinate of speeds [m/s]."""
        return np.exp(-self.coefficient * speed**self.exponent)


class Moments(NamedTuple):
    """Largest and smallest moments of inertia of n grains over m a^2, (n,) each."""

    largest: FloatArray
    smallest: FloatArray

    @property
    def differ(self) -> NDArray[np.bool_]:
        """Tell of which grains the moments differ, (n,)."""
        return np.asarray(self.largest - self.smallest > EQUAL_MOMENTS * self.largest)


def kappa_of(inertia: FloatArray, moments: Moments) -> FloatArray:
    """Compute the place kappa of inertias between the moments of their grains, (n,).

    It is 0 for a grain that turns about its longest axis, 1 about its shortest, and 1/2 where all
    axes are equal. Near either end it grows with the angle between spin and axis.
    """
    high, low = 1.0 / moments.smallest, 1.0 / moments.largest
    span = np.where(moments.differ, high - low, 1.0)
    place = np.clip((high - 1.0 / inertia) / span, 0.0, 1.0)
    return np.where(moments.differ, kappa_at(place), 0.5)


def kappa_at(place: FloatArray) -> FloatArray:
    """Compute kappa at places from 0 to 1, (n,), of the reciprocal inertia between its ends."""
    first, second = np.sqrt(place), np.sqrt(1.0 - place)
    return first / (first + second)


def inertia_at(kappa: FloatArray, moments: Moments) -> FloatArray:
    """Compute the inertias over m a^2 at places kappa from 0 to 1, (n,)."""
    place = kappa**2 / (kappa**2 + (1.0 - kappa) ** 2)
    high, low = 1.0 / moments.smallest, 1.0 / moments.largest
    return np.where(moments.differ, 1.0 / (high - place * (high - low)), moments.largest)


def inputs_of(impacts: Impacts, moments: Moments, speed: SpeedCoordinate) -> FloatArray:
    """Compute the inputs of impacts, (n, 8).

    They are sqrt(alpha1), the coordinate of V_e, the coordinate sigma of the spin in wall axes,
    kappa of the inertia about it, and the ratios. sigma has the direction of the spin. Its size
    begins at `SPIN_CORE`, because the law depends on the direction of the slowest spin; it grows
    as a small spin does, and as the root of a large one, on which a law depends less.
    """
    spin = impacts.spin
    size = np.linalg.norm(spin, axis=1)
    turns = size > 0.0
    factor = SPIN_CORE / np.where(turns, size, 1.0) + 1.0 / np.sqrt(np.sqrt(1.0 + size * size))
    inertia = np.where(turns, impacts.inertia, moments.largest)
    return np.column_stack(
        [
            np.sqrt(impacts.alpha1),
            speed.of(effective_speed(impacts)),
            spin * factor[:, None],
            np.where(turns, kappa_of(inertia, moments), 0.0),
            impacts.grain[:, 1:],
        ]
    )


def turned_by_chance(inputs: FloatArray, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Choose conditions that are fitted as their mirror images, (n,), as a draw chooses them.

    So sigma_x becomes positive, but that near 0 a condition may be of either image.
    """
    chance = 0.5 + inputs[:, _SIGMA_X] * (0.5 / FOLD)
    return np.asarray(rng.random(len(inputs)) >= chance)


def reflected(values: FloatArray, turned: NDArray[np.bool_], signs: FloatArray) -> FloatArray:
    """Reflect the rows of values (n, d) that are ``turned``, (n,), in the impact plane.

    ``signs``, (d,), are `INPUT_SIGNS` of inputs, and `OUTCOME_SIGNS` of outcomes.
    """
    return np.where(turned[:, None], values * signs, values)


def outcomes_of(states: FloatArray, inertia: FloatArray, energy: FloatArray) -> FloatArray:
    """Compute the outcomes p and o of rebounds, (n, 6).

    States (n, 6) have velocities over V and angular velocities times a/V; the inertias (n,) are
    those about the spin after the rebound, the energies (n,) those before it. p is the velocity
    over the root of the energy that it leaves, and o the angular velocity, times the root of the
    inertia, over the root of the energy that both leave, which the wall takes.
    """
    left = energy - np.sum(states[:, :3] ** 2, axis=1)
    loss = left - inertia * np.sum(states[:, 3:] ** 2, axis=1)
    left, loss = (np.maximum(part, LEAST_REST * energy)[:, None] for part in (left, loss))
    return np.hstack(
        [states[:, :3] / np.sqrt(left), states[:, 3:] * np.sqrt(inertia[:, None] / loss)]
    )


def normal_share(works: FloatArray) -> FloatArray:
    """Compute the outcome a of works (n, 2), normal and shear: the sixth root of the normal share.

    At grazing incidence the share is so small that its sixth root is easier to interpolate.
    """
    taken = works.sum(axis=1)
    share = np.divide(works[:, 0], taken, out=np.zeros_like(taken), where=taken > 0.0)
    return np.cbrt(np.sqrt(np.clip(share, 0.0, 1.0)))


def features(t: FloatArray, dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """Compute the features (n, 30) of standardised inputs t (n, 8), and round them to a type.

    They are 1, t_i, and t_i t_j for i <= j < 6, less 1/2 where i = j.
    """
    phi = np.empty((len(t), N_FEATURES), dtype=dtype)
    phi[:, 0], phi[:, 1 : 1 + N_INPUTS] = 1.0, t
    for column, (i, j) in enumerate(zip(*_PAIRS, strict=True), 1 + N_INPUTS):
        phi[:, column] = t[:, i] * t[:, j] - 0.5 * (i == j)
    return phi


def used_features(varies: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Select the features, (30,), that vary if only some of the 8 inputs do, (8,)."""
    i, j = _PAIRS
    return np.concatenate([[True], varies, varies[i] & varies[j]])


#: Axes of a tree: the six conditions, |sigma|^2, then the ratios.
SPIN_AXIS = N_CONDITIONS
AXES = np.array([*range(N_CONDITIONS), *(N_CONDITIONS + 1 + k for k in range(len(RATIOS)))])
