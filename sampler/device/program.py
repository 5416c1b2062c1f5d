"""What a GPU runs and reads: the C header with its kernels, and the arguments of calls.

Arrays that live on the device stay there; numbers and numpy arrays are checked on the host.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from sampler.arguments import (
    Call,
    as_keys,
    as_rows_of,
    check_keys,
    check_kind,
    check_vector,
    keys_of,
)
from sampler.errors import InputError
from sampler.files import include_directory

#: Types that numbers on the device can have, and their names in C.
REALS = {"float64": "double", "float32": "float"}


@cache
def source() -> str:
    """Read the text of the program, whole: CuPy keeps what it compiled by this text."""
    folder = include_directory()
    names = ("rebound_sampler.h", "rebound_device.h")
    texts = [(folder / name).read_text(encoding="utf-8") for name in names]
    return "".join(["#define REBOUND_SAMPLER_IMPLEMENTATION\n", *texts])


def options(dtype: str) -> tuple[str, ...]:
    """Give the options of the compiler: the type of numbers; no fused products, as on the host.

    Raises
    ------
    InputError
        If `dtype` is none of `REALS`.
    """
    if not isinstance(dtype, str) or dtype not in REALS:
        allowed = ", ".join(f"'{name}'" for name in REALS)
        raise InputError("dtype", repr(dtype), allowed)
    return ("-fmad=false", f"-DRBT_REAL={REALS[dtype]}")


def cupy_with_gpu() -> Any:
    """Import CuPy; raises `InputError` where it or a GPU is missing."""
    try:
        import cupy
    except ImportError:
        remedy = "run: pip install 'rebound-tables[cuda]'"
        raise InputError("to_device", problem="CuPy is not installed", remedy=remedy) from None
    problem, remedy = "CuPy finds no GPU", "run on a machine with a GPU and its driver"
    try:
        devices = cupy.cuda.runtime.getDeviceCount()
    except RuntimeError as error:  # CuPy's, where there is no driver or no device
        reason = f"{problem} ({error})"
        raise InputError("to_device", problem=reason, remedy=remedy) from error
    if devices == 0:
        raise InputError("to_device", problem=problem, remedy=remedy)
    return cupy


class DeviceArrays(NamedTuple):
    """Arrays that arguments become on the device; see `sampler.arguments.HostArrays`."""

    library: Any
    dtype: str

    def reals(self, name: str, values: Any) -> Any:
        """Coerce real numbers, or vectors where the name is that of one."""
        if not isinstance(values, self.library.ndarray):
            return self.library.asarray(as_rows_of(name, values).astype(self.dtype))
        check_kind(name, values, "fiu", "real numbers")
        check_vector(name, values.shape)
        return values.astype(self.dtype, copy=False)

    def keys(self, name: str, values: Any, bits: int) -> Any:
        """Coerce keys; signed integers on the device are searched for a negative one."""
        if not isinstance(values, self.library.ndarray):
            return self.library.asarray(as_keys(name, values, bits))
        kind = np.dtype(f"u{bits // 8}")
        if values.dtype != kind:
            check_kind(name, values, "iu", keys_of(bits))
            check_keys(name, values, bits)
        return values.astype(kind, copy=False)


class DeviceCall(Call):
    """Arguments of a call in arrays of the device; messages copy the row that they name."""

    def at(self, name: str, row: int) -> Any:
        """Give an argument of a row, on the host."""
        values = self.rows.arrays[name]
        numbers = values[row if len(values) > 1 else 0].get()
        return numbers if name == "index" else numbers.astype(np.float64)
