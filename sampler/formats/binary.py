"""Images of a table (.rbt), which programs in C and Fortran map into memory; written and read.

The layout is in `sampler.formats.binary_layout`. Equal tables give equal bytes on one machine.
"""

import hashlib
import math
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError, TableError
from sampler.files.atomic import atomic_output
from sampler.formats.binary_checks import (
    RefusedError,
    check_header,
    check_start,
    check_values,
    lengths_of,
)
from sampler.formats.binary_layout import (
    ALIGNMENT,
    ARRAYS,
    HEADER_DTYPE,
    IMAGE_VERSION,
    MAGIC,
    MOST_BYTES,
    MOST_NAMES,
    REASONS,
    SPEED_INDEPENDENT,
    field_offset,
)
from sampler.formats.hdf5 import TableContents
from sampler.formats.packing import aligned, table_arrays
from sampler.formats.table_arrays import ANY_SPEED, ROUNDING, Axis, TableArrays

_CHECKSUM_AT = field_offset("sha256")
_CHECKSUM = slice(_CHECKSUM_AT, _CHECKSUM_AT + 32)


class Image(NamedTuple):
    """What an image holds.

    Attributes
    ----------
    arrays : TableArrays
    pair : str
        Name of the material pair.
    content_sha256 : str
        Checksum of the table that it was made from.
    """

    arrays: TableArrays
    pair: str
    content_sha256: str


def checksum(data: NDArray[np.uint8]) -> bytes:
    """SHA-256 of everything in an image but its own field."""
    digest = hashlib.sha256(data[: _CHECKSUM.start].data)
    digest.update(data[_CHECKSUM.stop :].data)
    return digest.digest()


def _padded(numbers: tuple[int, ...]) -> list[int]:
    return [*numbers, *[-1] * (MOST_NAMES - len(numbers))]


def _arrays_by_name(arrays: TableArrays) -> dict[str, NDArray[Any]]:
    named = {
        "alpha_coordinate": arrays.alpha.coordinate,
        "speed_coordinate": arrays.speed.coordinate,
    }
    return {a.name: named[a.name] if a.name in named else getattr(arrays, a.name) for a in ARRAYS}


def _header(contents: TableContents, arrays: TableArrays) -> NDArray[np.void]:
    """Header without offsets, size and checksum."""
    pair = contents.pair.encode()
    if len(pair) >= HEADER_DTYPE["pair"].itemsize or b"\0" in pair:
        raise InputError(f"pair: got {len(pair)} bytes, allowed: at most 127, none of them 0")
    header = np.zeros((), HEADER_DTYPE)
    header["magic"], header["pair"] = MAGIC, pair
    header["major"], header["minor"] = IMAGE_VERSION
    header["header_bytes"] = HEADER_DTYPE.itemsize
    header["content_sha256"] = np.frombuffer(bytes.fromhex(contents.content_sha256), np.uint8)
    for name in ("n_knots", "n_components", "n_classes", "n_marginals", "stride", "variate_max"):
        header[name] = getattr(arrays, name)
    for name in ("channels", "marginals", "columns"):
        header[name] = _padded(getattr(arrays, name))
    header["flags"] = SPEED_INDEPENDENT if contents.speed_independent else 0
    header["n_channels"], header["n_columns"] = len(arrays.channels), len(arrays.columns)
    for name, axis in (("alpha", arrays.alpha), ("speed", arrays.speed)):
        header[f"n_{name}"], header[f"n_{name}_grid"] = axis.nodes, axis.coordinate.size
        for part in ("first", "last", "origin", "scale", "offset"):
            header[f"{name}_{part}"] = getattr(axis, part)
    return header


def image_bytes(contents: TableContents) -> bytes:
    """Image of a table.

    Parameters
    ----------
    contents : TableContents

    Raises
    ------
    InputError
        If the table does not fit into an image: 2 GiB, and 127 bytes for the name of the pair.
    """
    arrays = table_arrays(contents)
    header = _header(contents, arrays)
    by_name = _arrays_by_name(arrays)
    end = HEADER_DTYPE.itemsize
    for name, values in by_name.items():
        header[f"at_{name}"] = start = -(-end // ALIGNMENT) * ALIGNMENT
        end = start + values.nbytes
    if end >= MOST_BYTES:
        raise InputError(f"table: got {end} bytes, allowed: below {MOST_BYTES} in an image")
    header["file_bytes"] = end
    data = np.zeros(end, np.uint8)
    data[: HEADER_DTYPE.itemsize] = np.frombuffer(header.tobytes(), np.uint8)
    for array in ARRAYS:
        values = np.ascontiguousarray(by_name[array.name], dtype=array.dtype)
        start = int(header[f"at_{array.name}"])
        data[start : start + values.nbytes] = np.frombuffer(values.tobytes(), np.uint8)
    data[_CHECKSUM] = np.frombuffer(checksum(data), np.uint8)
    return data.tobytes()


def write_image(path: str | Path, contents: TableContents) -> None:
    """Write the image of a table, whole or not at all.

    Parameters
    ----------
    path : str or Path
        Ends in .rbt by custom; a file of that name is replaced.
    contents : TableContents

    Raises
    ------
    InputError
        If the table does not fit into an image, or the path cannot be written.
    """
    data = image_bytes(contents)
    with atomic_output(path) as temporary:
        temporary.write_bytes(data)


def read_image(path: str | Path) -> Image:
    """Read an image and check everything in it, as `rbt_open` of the C header does.

    Parameters
    ----------
    path : str or Path

    Raises
    ------
    TableError
        If it is refused; with one of the texts of `sampler.formats.binary_layout.REASONS`.
    """
    source = Path(path)
    try:
        return _image_of(_bytes_of(source))
    except RefusedError as refused:
        raise TableError(f"{source}: {REASONS[refused.code]}") from None


def _bytes_of(path: Path) -> NDArray[np.uint8]:
    """Bytes of a file, from a cache line on."""
    try:
        size = os.stat(path).st_size
        data = aligned((size,), np.uint8)
        with open(path, "rb") as file:
            read = file.readinto(data.data)
    except IsADirectoryError:
        raise RefusedError(-11) from None
    except OSError:
        raise RefusedError(-10) from None
    return data[:read]


def _image_of(data: NDArray[np.uint8]) -> Image:
    check_start(data)
    if checksum(data) != data[_CHECKSUM].tobytes():
        raise RefusedError(-17)
    header = data[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)[0]
    check_header(header)
    lengths = lengths_of(header)
    found, whole = {}, {}
    for array in ARRAYS:
        shape = tuple(lengths[d] if isinstance(d, str) else d for d in array.dims)
        start = int(header[f"at_{array.name}"])
        numbers = math.prod(shape) + array.extra
        size = numbers * np.dtype(array.dtype).itemsize
        whole[array.name] = data[start : start + size].view(array.dtype)
        found[array.name] = whole[array.name][: math.prod(shape)].reshape(shape)
    check_values(header, found)
    pair = bytes(header["pair"]).decode(errors="replace")
    checksum_of_table = header["content_sha256"].tobytes().hex()
    return Image(_table_arrays(header, whole), pair, checksum_of_table)


def _axis(header: np.void, name: str, coordinate: NDArray[np.float64]) -> Axis:
    first, last = float(header[f"{name}_first"]), float(header[f"{name}_last"])
    low, high = first * (1.0 - ROUNDING), last * (1.0 + ROUNDING)
    if name == "speed" and header["flags"] & SPEED_INDEPENDENT:
        low, high = ANY_SPEED
    return Axis(
        first=first,
        last=last,
        low=low,
        high=high,
        origin=float(header[f"{name}_origin"]),
        scale=float(header[f"{name}_scale"]),
        offset=int(header[f"{name}_offset"]),
        nodes=int(header[f"n_{name}"]),
        coordinate=coordinate,
    )


def _table_arrays(header: np.void, found: dict[str, NDArray[Any]]) -> TableArrays:
    """Arrays of the kernels from a header and flat arrays that passed the checks."""
    variate_max, n_knots = float(header["variate_max"]), int(header["n_knots"])
    n_channels, n_columns = int(header["n_channels"]), int(header["n_columns"])
    return TableArrays(
        alpha=_axis(header, "alpha", found["alpha_coordinate"]),
        speed=_axis(header, "speed", found["speed_coordinate"]),
        variate_max=variate_max,
        variate_scale=(n_knots - 1) / (2.0 * variate_max),
        n_knots=n_knots,
        n_components=int(header["n_components"]),
        n_classes=int(header["n_classes"]),
        n_marginals=int(header["n_marginals"]),
        stride=int(header["stride"]),
        channels=tuple(int(k) for k in header["channels"][:n_channels]),
        marginals=tuple(int(k) for k in header["marginals"][:n_channels]),
        columns=tuple(int(k) for k in header["columns"][:n_columns]),
        normals=found["normals"].reshape(-1, 4),
        alias=found["alias"],
        first_of_class=found["first_of_class"],
        components=found["components"],
        spans=found["spans"],
        quantiles=found["quantiles"],
    )
