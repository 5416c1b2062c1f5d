"""Coordinates of a search: independent numbers from which those of a pair file follow.

In a pair file the allowed range of a number may depend on other numbers: a polynomial has to stay
between 0 and 1, shares add up to one, dynamic friction is at most static friction. An optimiser
with box bounds needs coordinates that do not depend on each other.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import comb

from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class Coordinates:
    """A transformation between coordinates and numbers of a pair file, both (k,) float64."""

    #: Computes the numbers from coordinates.
    values: Callable[[FloatArray], FloatArray]
    #: Computes the coordinates from numbers.
    coordinates: Callable[[FloatArray], FloatArray]


def _logarithms(values: FloatArray) -> FloatArray:
    """Compute logarithms; that of zero is minus infinity, which is out of all bounds."""
    with np.errstate(divide="ignore"):
        return np.log(values)


def _shares(x: FloatArray) -> FloatArray:
    """Compute shares from parts of the rest that the shares before leave."""
    left = np.concatenate([[1.0], np.cumprod(1.0 - x)[:-1]])
    return x * left


def _parts(values: FloatArray) -> FloatArray:
    """Compute parts of the rest from shares; 0 if nothing is left."""
    left = 1.0 - np.concatenate([[0.0], np.cumsum(values)[:-1]])
    return np.where(left > 1e-12, values / np.maximum(left, 1e-12), 0.0)


def _both(x: FloatArray) -> FloatArray:
    """Compute two numbers from the first and their ratio."""
    return np.array([x[0], x[0] * x[1]])


def _ratio(values: FloatArray) -> FloatArray:
    """Compute the ratio of two numbers beside the first; 1 for two zeros."""
    return np.array([values[0], values[1] / values[0] if values[0] > 0.0 else 1.0])


#: The numbers themselves.
PLAIN = Coordinates(np.asarray, np.asarray)

#: Logarithms, for positive numbers of unknown order of magnitude.
LOGARITHM = Coordinates(np.exp, _logarithms)

#: Shares of sum at most one: each as a part of the rest that those before it leave.
SHARES = Coordinates(_shares, _parts)

#: Two numbers, the second at most the first: the first, and their ratio.
DESCENDING = Coordinates(_both, _ratio)


def bernstein(count: int, end: float) -> Coordinates:
    """Make Bernstein coefficients of polynomials on [0, end].

    The numbers are the coefficients of powers, lowest power first. A polynomial lies between its
    least and its largest Bernstein coefficient. Source: R. T. Farouki, Comput. Aided Geom. Des. 29
    (2012) 379-419, sec. 3.
    """
    n = count - 1
    to_powers = np.zeros((count, count))
    for j in range(count):
        for k in range(j, count):
            sign = -1.0 if (k - j) % 2 else 1.0
            to_powers[k, j] = sign * comb(n, k) * comb(k, j) / end**k
    return Coordinates(
        lambda x: to_powers @ x,
        lambda values: np.asarray(np.linalg.solve(to_powers, values), dtype=np.float64),
    )
