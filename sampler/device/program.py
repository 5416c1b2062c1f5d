"""The program that a GPU runs: the C header and its kernels, as CuPy compiles them."""

import re
from functools import cache
from typing import Any

from sampler.errors import InputError
from sampler.files import include_directory

#: Types that numbers on the device can have, and their names in C.
REALS = {"float64": "double", "float32": "float"}


@cache
def source() -> str:
    """Text of the program, whole: CuPy keeps what it compiled by this text."""
    folder = include_directory()
    texts = [
        (folder / name).read_text(encoding="utf-8")
        for name in ("rebound_sampler.h", "rebound_device.h")
    ]
    return "".join(["#define REBOUND_SAMPLER_IMPLEMENTATION\n", *texts])


@cache
def bits() -> dict[str, int]:
    """Bit of each argument of which one row stands for all, from the program."""
    found = re.findall(r"#define RBT_ONE_(\w+) (\d+)u", source())
    return {name.lower(): int(bit) for name, bit in found}


def options(dtype: str) -> tuple[str, ...]:
    """Options of the compiler: the type of numbers; no fused products, for the bits of the host.

    Parameters
    ----------
    dtype : {"float64", "float32"}

    Raises
    ------
    InputError
        If it is another.
    """
    if not isinstance(dtype, str) or dtype not in REALS:
        allowed = ", ".join(f"'{name}'" for name in REALS)
        raise InputError(f"dtype: got {dtype!r}, allowed: {allowed}")
    return ("-fmad=false", f"-DRBT_REAL={REALS[dtype]}")


def cupy_with_gpu() -> Any:
    """Import CuPy; raises `InputError` where it or a GPU is missing."""
    try:
        import cupy
    except ImportError:
        allowed = "after: pip install 'rebound-tables[cuda]'"
        raise InputError(f"to_device: CuPy is not installed, allowed {allowed}") from None
    try:
        devices = cupy.cuda.runtime.getDeviceCount()
        reason = ""
    except RuntimeError as error:  # CuPy's, where there is no driver or no device
        devices, reason = 0, f" ({str(error).partition(':')[0]})"
    if devices == 0:
        raise InputError(f"to_device: got no GPU{reason}, allowed: one that CuPy can use")
    return cupy
