"""Coordinates in which parameters are searched: between fixed bounds, whatever the others are.

A pair file has numbers whose allowed range depends on other numbers: the coefficients of a
polynomial that stays between 0 and 1, shares that add up to one, a dynamic friction that is at
most the static one. An optimiser with box bounds needs coordinates that are free of each other.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import comb

from tablegen.model.float_array import FloatArray


class Coordinates(Protocol):
    """How some numbers of a pair file follow from coordinates, and back."""

    def values(self, x: FloatArray) -> FloatArray:
        """Numbers of the file for coordinates."""

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Coordinates of numbers of the file."""


class Plain:
    """The numbers themselves."""

    def values(self, x: FloatArray) -> FloatArray:
        """Give the same numbers."""
        return x

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Give the same numbers."""
        return values


class Logarithm:
    """Natural logarithms, for positive numbers of which only the order of size is known."""

    def values(self, x: FloatArray) -> FloatArray:
        """Exponentials."""
        return np.exp(x)

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Logarithms; minus infinity for zero, which lies out of all bounds."""
        with np.errstate(divide="ignore"):
            return np.log(values)


@dataclass(frozen=True)
class Bernstein:
    """Polynomials on [0, end] by their Bernstein coefficients.

    A polynomial lies between the least and the largest of them, so coefficients from 0 to 1 give
    one that stays there. Source: R. T. Farouki, Comput. Aided Geom. Des. 29 (2012) 379-419, sec. 3.
    """

    count: int
    end: float

    def _to_power(self) -> FloatArray:
        """Matrix from Bernstein coefficients to those of powers, lowest power first."""
        n = self.count - 1
        matrix = np.zeros((self.count, self.count))
        for j in range(self.count):
            for k in range(j, self.count):
                sign = -1.0 if (k - j) % 2 else 1.0
                matrix[k, j] = sign * comb(n, k) * comb(k, j) / self.end**k
        return matrix

    def values(self, x: FloatArray) -> FloatArray:
        """Coefficients of powers."""
        return self._to_power() @ x

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Bernstein coefficients."""
        return np.asarray(np.linalg.solve(self._to_power(), values), dtype=np.float64)


class Shares:
    """Shares of k kinds, which add up to at most one: each as a part of what those before left."""

    def values(self, x: FloatArray) -> FloatArray:
        """Shares."""
        left = np.concatenate([[1.0], np.cumprod(1.0 - x)[:-1]])
        return x * left

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Parts; 0 where nothing is left."""
        left = 1.0 - np.concatenate([[0.0], np.cumsum(values)[:-1]])
        return np.where(left > 1e-12, values / np.maximum(left, 1e-12), 0.0)


class Descending:
    """Two numbers of which the second is at most the first: the first, and their ratio."""

    def values(self, x: FloatArray) -> FloatArray:
        """Both numbers."""
        return np.array([x[0], x[0] * x[1]])

    def coordinates(self, values: FloatArray) -> FloatArray:
        """First number and ratio; 1 for two zeros."""
        return np.array([values[0], values[1] / values[0] if values[0] > 0.0 else 1.0])
