"""Checks of samples of rebound states, before anything is computed from them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.errors import InputError
from sampler.formats.channels import STATE
from tablegen.model.float_array import FloatArray

#: Spread (largest minus smallest value) up to which a variable counts as constant. Variables
#: are of order one, so this is rounding.
CONSTANT_SPREAD = 1e-12


def as_sample(name: str, values: ArrayLike, rows: int = 2) -> FloatArray:
    """Coerce to a sample, or say why it cannot be one.

    Parameters
    ----------
    name : str
        What to call the values in an error message.
    values : array_like of float, shape (n, d)
    rows : int
        Least number of rows.

    Returns
    -------
    float64 array, shape (n, d)

    Raises
    ------
    InputError
        If the shape does not fit, there are too few rows, or a number is not finite.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 2 or array.shape[0] < rows or array.shape[1] < 1:
        raise InputError(f"{name}: got shape {array.shape}, allowed: (n, d) with n >= {rows}")
    if not np.isfinite(array).all():
        row, column = np.argwhere(~np.isfinite(array))[0]
        raise InputError(
            f"{name}: got {array[row, column]} at [{row}, {column}], allowed: finite numbers"
        )
    return array


def as_state(values: ArrayLike) -> FloatArray:
    """Coerce to rebound states.

    Parameters
    ----------
    values : array_like of float, shape (n, 6)
        Variables in the order of `sampler.formats.channels.STATE`.

    Returns
    -------
    float64 array, shape (n, 6)

    Raises
    ------
    InputError
        If the shape does not fit or a number is not finite.
    """
    array = as_sample("state", values, rows=1)
    if array.shape[1] != len(STATE):
        raise InputError(f"state: got shape {array.shape}, allowed: (n, {len(STATE)})")
    return array


def varies(values: FloatArray) -> NDArray[np.bool_]:
    """Tell which variables are more than rounding around one value.

    Parameters
    ----------
    values : float64 array, shape (n, d)

    Returns
    -------
    bool array, shape (d,)
    """
    return np.ptp(values, axis=0) > CONSTANT_SPREAD
