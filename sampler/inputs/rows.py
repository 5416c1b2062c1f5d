"""What a user passes, turned into what a kernel takes.

A scalar becomes an array of one, which kernels read for every row: nothing is copied n times.
"""

import operator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.errors import InputError


def _numeric(name: str, values: ArrayLike, kinds: str, allowed: str) -> NDArray[Any]:
    """Array of one of the dtype kinds; an empty array has no kind yet and passes."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(f"{name}: got rows of unequal length, allowed: {allowed}") from None
    if array.size and array.dtype.kind not in kinds:
        raise InputError(f"{name}: got {array.dtype.name} values, allowed: {allowed}")
    return array


def as_reals(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Real numbers, shape () or (n,), as float64 of shape (1,) or (n,).

    Raises
    ------
    InputError
        If they are no real numbers or have more dimensions.
    """
    array = _numeric(name, values, "fiu", "real numbers")
    if array.ndim > 1:
        raise InputError(f"{name}: got shape {array.shape}, allowed: a scalar or shape (n,)")
    return np.ascontiguousarray(np.atleast_1d(array), dtype=np.float64)


def as_vectors(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Vectors, shape (3,) or (n, 3), as float64 of shape (1, 3) or (n, 3).

    Raises
    ------
    InputError
        If they are no real numbers or have another shape.
    """
    array = _numeric(name, values, "fiu", "real numbers")
    if array.ndim not in (1, 2) or array.shape[-1] != 3:
        raise InputError(f"{name}: got shape {array.shape}, allowed: (3,) or (n, 3)")
    return np.ascontiguousarray(np.atleast_2d(array), dtype=np.float64)


def as_keys(name: str, values: ArrayLike, bits: int) -> NDArray[Any]:
    """Keys of random numbers, shape () or (n,), as uint32 or uint64 of shape (1,) or (n,).

    Parameters
    ----------
    name : str
    values : array of int
    bits : int
        32 or 64.

    Raises
    ------
    InputError
        If they are no integers, or do not fit.
    """
    allowed = f"integers from 0 to 2**{bits} - 1"
    array = _numeric(name, values, "iu", allowed)
    if array.ndim > 1:
        raise InputError(f"{name}: got shape {array.shape}, allowed: a scalar or shape (n,)")
    array = np.atleast_1d(array)
    if array.size:
        refused = array < 0
        if array.dtype.itemsize * 8 > bits:
            refused |= array > 2**bits - 1
        if refused.any():
            k = int(refused.argmax())
            raise InputError(f"{name}: got {array[k]} at index {k}, allowed: {allowed}")
    return np.ascontiguousarray(array, dtype=np.dtype(f"u{bits // 8}"))


def as_integer(name: str, value: Any, low: int, high: int, allowed: str) -> int:
    """Integer from low to high.

    Raises
    ------
    InputError
        If it is none.
    """
    try:
        number = operator.index(value)
    except TypeError:
        raise InputError(f"{name}: got {value!r}, allowed: {allowed}") from None
    if isinstance(value, bool) or not low <= number <= high:
        raise InputError(f"{name}: got {value!r}, allowed: {allowed}")
    return number


def as_seed(value: Any) -> np.uint64:
    """Seed as uint64; raises `InputError` if it does not fit."""
    return np.uint64(as_integer("seed", value, 0, 2**64 - 1, "an integer from 0 to 2**64 - 1"))


def common_length(**arrays: NDArray[Any]) -> int:
    """Return the number of rows of arrays that have either that many or one.

    Raises
    ------
    InputError
        If two arrays differ and neither has one row.
    """
    n, owner = 1, ""
    for name, array in arrays.items():
        if len(array) == 1 or len(array) == n:
            continue
        if owner:
            raise InputError(
                f"{name}: got {len(array)} rows, allowed: 1 or {n}, the number in {owner}"
            )
        n, owner = len(array), name
    return n


def as_output(out: NDArray[Any] | None, shape: tuple[int, int]) -> NDArray[Any]:
    """Array to write states to: the one given, if it fits, or a new one.

    Raises
    ------
    InputError
        If it is not a writable C-contiguous float64 or float32 array of that shape.
    """
    if out is None:
        return np.empty(shape)
    fits = isinstance(out, np.ndarray) and out.dtype in (np.float64, np.float32)
    if not (fits and out.shape == shape and out.flags.c_contiguous and out.flags.writeable):
        given = f"{out.dtype} {out.shape}" if isinstance(out, np.ndarray) else type(out).__name__
        raise InputError(
            f"out: got {given}, allowed: a writable contiguous float64 or float32 array {shape}"
        )
    return out
