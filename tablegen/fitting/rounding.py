"""Coefficients rounded to few bits, one after another: the next make up for the error of each.

The features of a condition are correlated, most of all where one expert is likely. If a coefficient
changes by its rounding, others can undo most of what that does to the sum. Measured on leaves of
prisms: the mean error by rounding, as large as all others, falls to a tenth. Source: the optimal
brain surgeon of Hassibi, Stork and Wolff, IEEE Int. Conf. Neural Networks (1993) 293-299.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tablegen.model.float_array import FloatArray

_LARGEST = np.iinfo(np.int16).max

#: Part of the mean weight that is added to each: coefficients that change no sum must not grow.
_RIDGE = 1e-3


def rounded(values: FloatArray, unit: int, step: int) -> NDArray[np.int16]:
    """Round values in units of the file to multiples of a step."""
    whole = step * np.rint(values * unit / step)
    largest = step * (_LARGEST // step)
    return np.clip(whole, -largest, largest).astype(np.int16)


def rounded_together(
    values: FloatArray, weight: FloatArray, unit: int, steps: NDArray[np.int64]
) -> NDArray[np.int16]:
    """Round rows of coefficients with the least change of what they are for.

    From the last feature to the first, each is rounded, and those before it move to where the
    quadratic form of the errors is least.

    Parameters
    ----------
    values : (n, rows, f) float64
    weight : (n, f, f) float64
        Quadratic form by which errors of the rows of each n count.
    unit : int
    steps : (f,) int64
    """
    left, features = values.copy(), values.shape[-1]
    whole = np.zeros(values.shape, dtype=np.int16)
    mean = np.trace(weight, axis1=1, axis2=2) / features
    form: NDArray[Any] = weight + (_RIDGE * mean + 1e-9)[:, None, None] * np.eye(features)
    for k in range(features - 1, -1, -1):
        whole[..., k] = rounded(left[..., k], unit, int(steps[k]))
        error = left[..., k] - whole[..., k] / unit
        moved = np.linalg.solve(form[:, :k, :k], form[:, :k, k, None])[..., 0]
        left[..., :k] += error[..., None] * moved[:, None]
    return whole
