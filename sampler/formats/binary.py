"""Binary tables (.rbt), which programs in C and Fortran map into memory: how they are written.

The layout is in `sampler.formats.binary_layout`. Equal tables give equal bytes. The reader, with
its checks, is `rbt_open` of the C header.
"""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from sampler.files import write_bytes
from sampler.formats.binary_layout import (
    ALIGNMENT,
    ARRAYS,
    BINARY_VERSION,
    HEADER_DTYPE,
    MAGIC,
    MINOR_WITHOUT_WORKS,
    MOST_BYTES,
    SPEED_INDEPENDENT,
    SPIN_ARRAYS,
    field_offset,
)
from sampler.formats.bounds import N_INPUTS, SpinArrays, TableArrays
from sampler.formats.channels import MOST_NAMES, has_works
from sampler.formats.hdf5 import TableContents
from sampler.formats.image import table_arrays
from sampler.formats.spin_buffer import law_in

_CHECKSUM_AT = field_offset("sha256")
_CHECKSUM = slice(_CHECKSUM_AT, _CHECKSUM_AT + 32)


def checksum(data: NDArray[np.uint8]) -> bytes:
    """SHA-256 of everything in a binary table but its own field."""
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


def _spin_arrays_by_name(spin: SpinArrays) -> dict[str, NDArray[Any]]:
    """Arrays of a spin law, or nothing if there is none; roots are those of the grains' shapes."""
    if spin.n_shapes == 0:
        return {}
    grains = spin.grains
    named: dict[str, NDArray[Any]] = {
        "shape_codes": grains.shape_codes,
        "shape_shares": grains.cumulative_weights,
        "shape_ratios": grains.fixed_ratios,
        "roots": spin.roots[np.searchsorted(spin.shape_codes, grains.shape_codes)],
    }
    return {
        a.name: named[a.name] if a.name in named else getattr(spin, a.name.removeprefix("spin_"))
        for a in SPIN_ARRAYS
    }


def _fill_spin_fields(header: NDArray[np.void], spin: SpinArrays) -> None:
    """Write the fields of a spin law."""
    header["n_shapes"] = spin.grains.shape_codes.size
    header["n_nodes"], header["n_spin_knots"] = spin.node_axis.size, spin.n_knots
    header["n_leaves"] = spin.inputs.size // (2 * N_INPUTS)
    header["spin_alpha"] = spin.alpha_first, spin.alpha_last
    header["spin_speed"] = spin.speed_first, spin.speed_last
    header["spin_coordinate"] = spin.speed_scale, spin.speed_exponent
    header["aspect"] = spin.grains.aspect.reshape(-1)


def _header(contents: TableContents, arrays: TableArrays) -> NDArray[np.void]:
    """Header without offsets, size and checksum."""
    header = np.zeros((), HEADER_DTYPE)
    header["magic"], header["pair"] = MAGIC, contents.pair.encode()
    header["major"], minor = BINARY_VERSION
    header["minor"] = minor if has_works(contents.variables) else MINOR_WITHOUT_WORKS
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
    header["valid_speed"] = arrays.valid_speed
    spin = law_in(arrays)
    if spin.n_shapes > 0:
        _fill_spin_fields(header, spin)
    return header


def binary_table(contents: TableContents, arrays: TableArrays | None = None) -> bytes:
    """Bytes of a binary table.

    Parameters
    ----------
    contents : TableContents
    arrays : TableArrays, optional
        Those of the contents, where they were made already or for other grains.

    Raises
    ------
    InputError
        If the table does not fit into the format, 2 GiB.
    """
    arrays = table_arrays(contents) if arrays is None else arrays
    header = _header(contents, arrays)
    given = _arrays_by_name(arrays) | _spin_arrays_by_name(law_in(arrays))
    stored = {
        array.name: np.ascontiguousarray(given[array.name], dtype=array.dtype)
        for array in (*ARRAYS, *SPIN_ARRAYS)
        if array.name in given
    }
    end = HEADER_DTYPE.itemsize
    for name, values in stored.items():
        header[f"at_{name}"] = start = -(-end // ALIGNMENT) * ALIGNMENT
        end = start + values.nbytes
    if end >= MOST_BYTES:
        raise InputError(f"table: got {end} bytes, allowed: below {MOST_BYTES} in a binary table")
    header["file_bytes"] = end
    data = np.zeros(end, np.uint8)
    data[: HEADER_DTYPE.itemsize] = np.frombuffer(header.tobytes(), np.uint8)
    for name, values in stored.items():
        start = int(header[f"at_{name}"])
        data[start : start + values.nbytes] = np.frombuffer(values.tobytes(), np.uint8)
    data[_CHECKSUM] = np.frombuffer(checksum(data), np.uint8)
    return data.tobytes()


def write_binary_table(path: str | Path, contents: TableContents) -> None:
    """Write a binary table, whole or not at all.

    Parameters
    ----------
    path : str or Path
        Ends in .rbt by custom; a file of that name is replaced.
    contents : TableContents

    Raises
    ------
    InputError
        If the table does not fit into the format, or the path cannot be written.
    """
    write_bytes(path, binary_table(contents))
