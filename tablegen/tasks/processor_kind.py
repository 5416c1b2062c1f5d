"""The kind of processor that this runs on, as far as it decides the last digits of a result.

Libraries choose code by the processor, and sum in another order or fuse other products and sums.
Three of them do so in tasks: numpy, the linear algebra of numpy and scipy, and the
elementary functions of the C library. Compiled kernels do not: they never fuse or reorder by
themselves (`tablegen.model.jit`).
"""

import hashlib
import math
import struct
from functools import cache

import numpy as np
import scipy.linalg  # noqa: F401  (loads scipy's own linear algebra library)
from threadpoolctl import threadpool_info

#: Functions of the C library that are compared; the code of each is chosen by the processor.
_FUNCTIONS = (math.exp, math.log, math.sin, math.cos, math.tan, math.atan, math.asin, math.erfc)

#: Arguments of each: fractions with few bits, so that they are the same numbers everywhere.
_ARGUMENTS = tuple((2 * k + 1) / 4096 for k in range(2048))


def _numpy() -> str:
    found = np.show_config(mode="dicts")["SIMD Extensions"]
    return "numpy " + " ".join(found.get("found", ()) or ("as built",))


def _linear_algebra() -> str:
    kinds = {
        f"{library['internal_api']} {library.get('architecture', '')}".strip()
        for library in threadpool_info()
        if library["user_api"] == "blas"
    }
    return " and ".join(sorted(kinds)) or "linear algebra unknown"


def _c_library() -> str:
    digest = hashlib.sha256()
    for function in _FUNCTIONS:
        digest.update(struct.pack(f"<{len(_ARGUMENTS)}d", *map(function, _ARGUMENTS)))
    for x, y in zip(_ARGUMENTS, reversed(_ARGUMENTS), strict=True):
        digest.update(struct.pack("<2d", math.atan2(x, y), math.pow(x, y)))
    return f"libm {digest.hexdigest()[:8]}"


@cache
def processor_kind() -> str:
    """Kind of processor, in one line.

    Returns
    -------
    str
        Instruction sets that numpy uses beyond those that it was built for; the type of processor
        for which the linear algebra library chose its code; and the first digits of a checksum of
        values of the C library's functions. Processors with the same line, and the same
        `tablegen.tasks.software.software`, make the same bytes.
    """
    return "; ".join((_numpy(), _linear_algebra(), _c_library()))
