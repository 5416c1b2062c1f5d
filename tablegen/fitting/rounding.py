"""Round coefficients to few bits, one after another; the others make up for the error of each.

The features of a condition are correlated, most of all where one expert is likely. So if rounding
changes one coefficient, the other coefficients can undo most of the change of the sum. Measured on
leaves of prisms, the mean error by rounding falls to a tenth; without this it is as large as all
other errors together (EXPERIMENTS.md, "Spin law"). Source: the optimal brain surgeon of Hassibi,
Stork and Wolff, IEEE Int. Conf. Neural Networks (1993) 293-299.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tablegen.model.float_array import FloatArray

_LARGEST = np.iinfo(np.int16).max

#: This part of the mean weight is added to each weight. Otherwise coefficients that change no sum
#: could grow.
_RIDGE = 1e-3


def round_to_multiples(values: FloatArray, unit: int, step: int) -> NDArray[np.int16]:
    """Express values in units of a file, ``unit`` to one, and round them to multiples of a step."""
    integers = step * np.rint(values * unit / step)
    largest = step * (_LARGEST // step)
    return np.clip(integers, -largest, largest).astype(np.int16)


def round_together(
    values: FloatArray, weight: FloatArray, unit: int, steps: NDArray[np.int64]
) -> NDArray[np.int16]:
    """Round rows of coefficients so that a quadratic form of the errors stays small.

    The coefficients are rounded from the last one to the first. After each, the coefficients before
    it move to where the quadratic form is least.

    Parameters
    ----------
    values : (n, rows, f) float64
        Coefficients of f features.
    weight : (n, f, f) float64
        Quadratic form for all rows of each n.
    unit : int
        Units of the file in a coefficient of one.
    steps : (f,) int64
        Each coefficient becomes a multiple of its step, in units of the file.

    Returns
    -------
    (n, rows, f) int16
        Coefficients in units of the file.
    """
    remaining, features = values.copy(), values.shape[-1]
    integers = np.zeros(values.shape, dtype=np.int16)
    mean = np.trace(weight, axis1=1, axis2=2) / features
    form: NDArray[Any] = weight + (_RIDGE * mean + 1e-9)[:, None, None] * np.eye(features)
    for k in range(features - 1, -1, -1):
        integers[..., k] = round_to_multiples(remaining[..., k], unit, int(steps[k]))
        error = remaining[..., k] - integers[..., k] / unit
        correction = np.linalg.solve(form[:, :k, :k], form[:, :k, k, None])[..., 0]
        remaining[..., :k] += error[..., None] * correction[:, None]
    return integers
