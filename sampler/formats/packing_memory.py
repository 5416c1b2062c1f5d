"""Memory of the arrays of kernels: where they begin, and what numba takes them for."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def aligned(shape: tuple[int, ...], dtype: type) -> NDArray:
    """Zeros that begin on a cache line."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    buffer = np.zeros(size + 63, dtype=np.uint8)
    start = -buffer.ctypes.data % 64
    return buffer[start : start + size].view(dtype).reshape(shape)


def repacked(value: Any) -> Any:
    """Arrays in nested tuples as the kernels were compiled for and are fast on.

    An array that has been pickled may be read-only, which is another type to numba, and begin
    anywhere: it is copied. One that is writable and begins on a cache line is taken as it is.
    """
    if isinstance(value, tuple):
        parts = [repacked(part) for part in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    if not isinstance(value, np.ndarray):
        return value
    if value.flags.writeable and value.ctypes.data % 64 == 0:
        return value
    copy = aligned(value.shape, value.dtype.type)
    copy[...] = value
    return copy
