"""Arguments of a call turned into arrays on the device, as `sampler.arguments` does on the host.

What lives on the device stays there; numbers and numpy arrays are checked on the host and copied.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from sampler.arguments import (
    VECTORS,
    Keys,
    Rows,
    Shape,
    as_keys,
    as_rows_of,
    as_seed,
    check_keys,
    check_kind,
    check_vector,
    common_shape,
    keys_of,
)


def _reals(cupy: Any, name: str, values: Any, dtype: str) -> Any:
    """Real numbers on the device, or vectors where the name is that of one."""
    if not isinstance(values, cupy.ndarray):
        return cupy.asarray(as_rows_of(name, values).astype(dtype))
    check_kind(name, values, "fiu", "real numbers")
    check_vector(name, values.shape)
    return values.astype(dtype, copy=False)


def _keys(cupy: Any, name: str, values: Any, bits: int) -> Any:
    """Keys on the device; signed integers there are looked through for one that is negative."""
    if not isinstance(values, cupy.ndarray):
        return cupy.asarray(as_keys(name, values, bits))
    kind = np.dtype(f"u{bits // 8}")
    if values.dtype != kind:
        check_kind(name, values, "iu", keys_of(bits))
        check_keys(name, values, bits)
    return values.astype(kind, copy=False)


def _flat(cupy: Any, array: Any, shape: Shape, tail: Shape) -> Any:
    """Rows of an array, shape (n, *tail), or (1, *tail) where one row stands for all."""
    if array.size != math.prod(tail) and array.shape != shape + tail:
        array = cupy.broadcast_to(array, shape + tail)
    return cupy.ascontiguousarray(array).reshape(-1, *tail)


def device_rows(cupy: Any, arguments: Mapping[str, Any], keys: Keys, dtype: str) -> Rows:
    """Rows of arguments and of their keys, in arrays of the device.

    Parameters
    ----------
    cupy : module
    arguments : mapping
        Arrays of CuPy, or what numpy takes, by name; all broadcast.
    keys : Keys
        Seed, index and hit.
    dtype : str
        Of the arguments' rows.

    Raises
    ------
    InputError
        If an argument has a wrong type or shape.
    """
    keys = keys.checked()
    arrays = {name: _reals(cupy, name, values, dtype) for name, values in arguments.items()}
    tails: dict[str, Shape] = {name: (3,) if name in VECTORS else () for name in arrays}
    shapes = {name: a.shape[: a.ndim - len(tails[name])] for name, a in arrays.items()}
    hit = _keys(cupy, "hit", 0 if keys.hit is None else keys.hit, 32)
    index, seed = _keys(cupy, "index", keys.index, 64), np.uint64(as_seed(keys.seed))
    shape = common_shape(shapes | {"hit": hit.shape, "index": index.shape})
    values = {name: _flat(cupy, a, shape, tails[name]) for name, a in arrays.items()}
    return Rows(shape, values, (seed, _flat(cupy, index, shape, ()), _flat(cupy, hit, shape, ())))


def row_on_host(cupy: Any, rows: Rows, row: int) -> Rows:
    """Copy one row to the host, where it stands for all rows of a message."""
    values = {
        name: cupy.asnumpy(array[row : row + 1] if len(array) > 1 else array).astype(np.float64)
        for name, array in rows.values.items()
    }
    if "velocity" in values:
        values.setdefault("wall_velocity", np.zeros((1, 3)))
    return rows._replace(values=values)
