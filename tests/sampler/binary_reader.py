"""Header and arrays of a binary table (.rbt), by the description that its writer follows."""

import math
from pathlib import Path

import numpy as np

from sampler.formats.binary_layout import ARRAYS, HEADER_DTYPE
from sampler.formats.bounds import expert_stride


def read_binary(path):
    """Header, and flat arrays by name; nothing is checked, as `rbt_open` does that."""
    data = Path(path).read_bytes()
    header = np.frombuffer(data[: HEADER_DTYPE.itemsize], HEADER_DTYPE)[0]
    cells = max(int(header["n_alpha"]) - 1, 1) * max(int(header["n_speed"]) - 1, 1)
    known = {"n_cells": cells, "expert_stride": expert_stride(int(header["n_outcomes"]))}
    arrays = {}
    for array in (array for array in ARRAYS if header[array.count]):
        dims = (
            known[d] if d in known else header[d] if isinstance(d, str) else d for d in array.dims
        )
        numbers = math.prod(map(int, dims)) + array.extra
        arrays[array.name] = np.frombuffer(
            data, array.dtype, numbers, int(header[f"at_{array.name}"])
        )
    return header, arrays
