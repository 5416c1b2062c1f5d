"""Checks of a table image, in the order and with the codes of the C header.

After them no draw can read outside the image or give NaN, whoever wrote it.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.formats.binary_layout import (
    ALIGNMENT,
    ARRAYS,
    HEADER_DTYPE,
    IMAGE_VERSION,
    MAGIC,
    MOST_BYTES,
    MOST_NAMES,
)
from sampler.formats.channels import CHANNELS, RANGES, VARIABLES, channels_for
from sampler.formats.fixed_point import MIXTURE_SCALE
from sampler.formats.packing import record_stride
from sampler.formats.table_arrays import ROUNDING

#: Bound on the numbers of a cubic, all together: no word gives a normal number above 6.4.
_CUBIC = 16.0
#: Bound on the numbers of nodes, in which 32 bits suffice.
_LARGEST_NUMBER = 1e6
#: Bound on mixture variates, which single precision holds.
_LARGEST_VARIATE = 1e6
#: How far the coordinate of a node may be from its number: it is interpolated between steps.
INDEX_ROUNDING = 0.02
#: Largest step of a quantile, and a rounding that may be added to it.
_LAST_STEP = 65535.0 * (1.0 + 1e-6)


class RefusedError(Exception):
    """An image is refused, for the reason of a code."""

    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code


def _need(holds: Any, code: int) -> None:
    if not holds:
        raise RefusedError(code)


def check_start(data: NDArray[np.uint8]) -> None:
    """Refuse what is no image, another version or of another size than it says."""
    _need(data[: len(MAGIC)].tobytes() == MAGIC, -14)
    _need(data.size >= HEADER_DTYPE.itemsize, -16)
    header = data[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)[0]
    _need(header["major"] == IMAGE_VERSION[0], -15)
    _need(header["file_bytes"] == data.size and data.size < MOST_BYTES, -16)


def lengths_of(header: np.void) -> dict[str, int]:
    """Length of every named dimension."""
    names = {dim for array in ARRAYS for dim in array.dims if isinstance(dim, str)}
    lengths = {name: int(header[name]) for name in names - {"n_cells"}}
    cells = max(lengths["n_alpha"] - 1, 1) * max(lengths["n_speed"] - 1, 1)
    return lengths | {"n_cells": cells}


def check_header(header: np.void) -> None:
    """Refuse sizes, names, offsets and axes that do not fit together."""
    _check_dimensions(header)
    _check_names(header)
    _check_offsets(header)
    _check_axes(header)


def _check_dimensions(header: np.void) -> None:
    for name, least, most in (
        ("n_alpha", 1, 65536),
        ("n_speed", 1, 65536),
        ("n_alpha_grid", 2, 2**24),
        ("n_speed_grid", 2, 2**24),
        ("n_knots", 2, 65536),
        ("n_components", 1, 65536),
        ("n_classes", 1, 65536),
        ("n_channels", 1, MOST_NAMES),
        ("n_marginals", 1, MOST_NAMES),
        ("n_columns", 1, MOST_NAMES),
    ):
        _need(least <= header[name] <= most, -18)
    _need(header["stride"] == record_stride(int(header["n_channels"])), -18)


def _check_names(header: np.void) -> None:
    channels = [int(k) for k in header["channels"]]
    marginals = [int(k) for k in header["marginals"]]
    columns = [int(k) for k in header["columns"]]
    n_channels, n_columns = int(header["n_channels"]), int(header["n_columns"])
    for numbers, n in ((channels, n_channels), (columns, n_columns)):
        _need(all(0 <= k < MOST_NAMES for k in numbers[:n]), -19)
        _need(len(set(numbers[:n])) == n and set(numbers[n:]) <= {-1}, -19)
    _need(set(marginals[n_channels:]) <= {-1}, -19)
    held = [k for k in marginals[:n_channels] if k != -1]
    _need(held == list(range(int(header["n_marginals"]))), -19)
    with_quantiles = [
        CHANNELS[c] for c, m in zip(channels, marginals, strict=True) if c >= 0 and m >= 0
    ]
    needed = channels_for(VARIABLES[k] for k in columns[:n_columns])
    _need(set(with_quantiles) == set(needed), -19)


def _check_offsets(header: np.void) -> None:
    lengths, size = lengths_of(header), int(header["file_bytes"])
    for array in ARRAYS:
        shape = (lengths[d] if isinstance(d, str) else d for d in array.dims)
        needed = (math.prod(shape) + array.extra) * np.dtype(array.dtype).itemsize
        start = int(header[f"at_{array.name}"])
        _need(start % ALIGNMENT == 0 and start >= HEADER_DTYPE.itemsize, -20)
        _need(start <= size and needed <= size - start, -20)


def _check_axes(header: np.void) -> None:
    for name, largest in (("alpha", 0.5 * math.pi * (1.0 + ROUNDING)), ("speed", math.inf)):
        first, last, origin, scale = (
            float(header[f"{name}_{part}"]) for part in ("first", "last", "origin", "scale")
        )
        _need(all(math.isfinite(x) for x in (first, last, origin, scale)), -21)
        _need(0.0 < first <= last <= largest and origin <= first and scale >= 0.0, -21)
        _need((header[f"n_{name}"] == 1) == (first == last), -21)
        _need(scale > 0.0 or (first == last == origin and header[f"{name}_offset"] == 0), -21)
        end = (last - origin) * scale
        _need(end <= (float(header[f"n_{name}_grid"]) - 1.0) * (1.0 + 1e-9), -21)
    variate_max = float(header["variate_max"])
    _need(1e-3 <= variate_max <= _LARGEST_VARIATE, -21)


def check_values(header: np.void, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Refuse numbers that would lead a draw astray."""
    for name in ("alpha", "speed"):
        _check_coordinate(header, name, arrays[f"{name}_coordinate"])
    # negated comparisons refuse NaN as well
    _need((np.abs(arrays["normals"]).sum(axis=1, dtype=np.float64) <= _CUBIC).all(), -23)
    _need(((arrays["alias"] & 0xFFFF) < header["n_components"]).all(), -24)
    first = arrays["first_of_class"]
    _need((first[..., 0] == 0).all() and (first <= header["n_components"]).all(), -25)
    _need((first[..., 1:] >= first[..., :-1]).all(), -25)
    _check_components(int(header["n_channels"]), arrays["components"])
    _check_spans(header, arrays["spans"])
    steps = arrays["quantiles"]
    _need((steps[..., 1:, :] >= steps[..., :-1, :]).all(), -28)


def _check_coordinate(header: np.void, name: str, values: NDArray[np.float64]) -> None:
    _need((np.abs(values) <= _LARGEST_NUMBER).all(), -22)
    if header[f"{name}_scale"] == 0.0:
        _need((values == 0.0).all(), -22)
        return
    _need((values[1:] > values[:-1]).all(), -22)
    offset, nodes = int(header[f"{name}_offset"]), int(header[f"n_{name}"])
    for end, number in (("first", offset), ("last", offset + nodes - 1)):
        distance = float(header[f"{name}_{end}"]) - float(header[f"{name}_origin"])
        position = min(distance * float(header[f"{name}_scale"]), values.size - 1.0)
        k = min(int(position), values.size - 2)
        found = values[k] + (position - k) * (values[k + 1] - values[k])
        _need(abs(found - number) <= INDEX_ROUNDING, -22)


def _check_components(channels: int, records: NDArray[np.int16]) -> None:
    reflection = records[..., 0]
    _need(((reflection >= 0) & (reflection <= MIXTURE_SCALE)).all(), -26)
    first = 1 + channels
    diagonal = [first + k * channels - k * (k - 1) // 2 for k in range(channels)]
    _need((records[..., diagonal] > 0).all(), -26)


def _check_spans(header: np.void, spans: NDArray[np.float64]) -> None:
    for channel, marginal in zip(header["channels"], header["marginals"], strict=True):
        if channel < 0 or marginal < 0:
            continue
        low, high = RANGES.get(CHANNELS[channel], (-math.inf, math.inf))
        least, step = spans[..., marginal, 0], spans[..., marginal, 1]
        with np.errstate(over="ignore", invalid="ignore"):
            most = least + step * _LAST_STEP
            _need((np.isfinite(least) & np.isfinite(step) & np.isfinite(most)).all(), -27)
            _need(((least > low) & (step >= 0.0) & (most < high)).all(), -27)
