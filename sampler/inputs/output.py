"""What a call returns, or writes to an array of the user's, which an error leaves as it was."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import Rows, Shape
from sampler.errors import InputError
from sampler.formats.bounds import ROUNDING, TableArrays

#: Numbers of states that are copied in less time than it takes to look at their rows.
_SOONER_COPIED = 10_000


class Rebound(NamedTuple):
    """What `Table.rebound` returns.

    Attributes
    ----------
    velocity : float64 array, shape (..., 3)
        Velocity after the rebound, m/s, lab frame.
    omega : float64 array, shape (..., 3)
        Angular velocity after the rebound, rad/s, lab frame.
    """

    velocity: NDArray[np.float64]
    omega: NDArray[np.float64]


def as_output(out: NDArray[Any] | None, shape: Shape) -> NDArray[Any]:
    """Array to write states to: the one given, if it fits, or a new one.

    Raises
    ------
    InputError
        If it is not a writable C-contiguous float64 or float32 array of that shape.
    """
    if out is None:
        return np.empty(shape)
    plain = isinstance(out, np.ndarray) and not isinstance(out, np.ma.MaskedArray)
    fits = plain and out.dtype in (np.float64, np.float32)
    if not (fits and out.shape == shape and out.flags.c_contiguous and out.flags.writeable):
        given = f"{out.dtype} {out.shape}" if plain else type(out).__name__
        raise InputError(
            f"out: got {given}, allowed: a writable contiguous float64 or float32 array {shape}"
        )
    return out


def _all_within(values: NDArray[np.float64], low: float, high: float) -> bool:
    """Whether all numbers lie from low to high; NaN does not."""
    return bool(values.min() >= low and values.max() <= high)


def _none_refused(rows: Rows, arrays: TableArrays, outside: str) -> bool:
    """Whether each row has a condition that can be drawn."""
    alpha, speed = rows.values["alpha1"], rows.values["speed"]
    if outside == "raise":
        low, high = arrays.alpha.low, arrays.alpha.high
        least, most = arrays.speed.low, arrays.speed.high
    else:  # smallest and largest numbers that the kernel takes
        low, high = math.ulp(0.0), 0.5 * math.pi + ROUNDING
        least, most = math.ulp(0.0), np.finfo(np.float64).max
    return _all_within(alpha, low, high) and _all_within(speed, least, most)


def where_to_draw(
    states: NDArray[Any], rows: Rows, arrays: TableArrays, outside: str
) -> NDArray[Any]:
    """Array in which a kernel draws: the user's, or a new one to be copied where that may fail.

    A kernel writes row by row until it meets one that it refuses. So it writes to the user's array
    only if it will refuse none, and if it overwrites nothing that it has yet to read.

    Parameters
    ----------
    states : array, shape (..., n_columns)
    rows : Rows
        Angles and speeds, and keys.
    arrays : TableArrays
    outside : {"clamp", "raise"}
        As of `Table`.
    """
    # a draw with a spin can be refused for more reasons than are looked at here
    if states.size > _SOONER_COPIED and "spin" not in rows.values:
        read = (*rows.values.values(), *rows.keys[1:])
        shared = any(np.may_share_memory(states, values) for values in read)
        if not shared and _none_refused(rows, arrays, outside):
            return states
    return np.empty_like(states)
