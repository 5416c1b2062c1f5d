"""Attributes and datasets of the bytes of a table file, none of which can hurt.

Nothing is read before the sizes of all datasets are known and bounded by the size of the file.
"""

import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from sampler.errors import TableError
from sampler.formats.hdf5_attributes import check_units, shown
from sampler.formats.hdf5_image import Image, damaged, objects
from sampler.formats.hdf5_values import (
    Array,
    Values,
    WrongTypeError,
    attribute,
    attributes,
    dataset,
    read,
)
from sampler.formats.layout import (
    ATTRIBUTES,
    FORMAT,
    FORMAT_VERSION,
    OPTIONAL_ATTRIBUTES,
    layout_of,
)
from sampler.formats.table_shapes import check_shapes

#: Bytes of the datasets that a file of any size may have, and further ones for each of its bytes.
#: Shipped tables have 1.3 for each.
FREE_BYTES, MOST_EXPANSION = 2**24, 8


def read_container(data: bytes) -> tuple[dict[str, Any], dict[str, Array]]:
    """Root attributes by name, and datasets by path, of the bytes of an HDF5 file.

    Datasets that the layout does not know, of a later minor version, count in the checksum and are
    among them.

    Raises
    ------
    TableError
        If the bytes cannot be read, are no table or of a newer major version, or if attributes or
        shapes and types of datasets are not as the layout says.
    """
    image = Image(data)
    try:
        found = dict(objects(image))
        places = attributes(image, found.pop(""))
        return _read_attributes(image, places), _read_datasets(image, found)
    except TableError:
        raise
    except (ValueError, OverflowError, struct.error, zlib.error) as error:
        raise damaged(str(error).partition("\n")[0]) from error


def _value(image: Image, places: Mapping[str, int], name: str) -> Any:
    """Value of an attribute."""
    try:
        return attribute(image, places[name])
    except WrongTypeError as error:
        raise TableError(f"{name}: got {error}, allowed: text or numbers") from None


def _check_version(image: Image, places: Mapping[str, int]) -> None:
    """Refuse what is no table, or one of a newer major version."""
    if "format" not in places or _value(image, places, "format") != FORMAT:
        raise TableError(f'format: is not "{FORMAT}", so this is some other HDF5 file')
    version = _value(image, places, "format_version") if "format_version" in places else None
    if not (isinstance(version, list) and [type(v) for v in version] == [int, int]):
        raise TableError(f"format_version: got {shown(version)}, allowed: two integers")
    if version[0] != FORMAT_VERSION[0]:
        raise TableError(
            f"format_version: got {version[0]}.{version[1]}, "
            f"allowed: {FORMAT_VERSION[0]}.x (a newer file needs a newer rebound-tables)"
        )


def _read_attributes(image: Image, places: Mapping[str, int]) -> dict[str, Any]:
    """Root attributes, after format and version were found to be ours."""
    _check_version(image, places)
    values = {name: _value(image, places, name) for name in places}
    for name, (kind, meaning) in {**ATTRIBUTES, **OPTIONAL_ATTRIBUTES}.items():
        if name not in values:
            if name in OPTIONAL_ATTRIBUTES:
                continue
            raise TableError(f"{name}: is missing, allowed: {meaning}")
        wrong = name == "speed_independent" and values[name] != 1
        if wrong or type(values[name]) is not kind:
            raise TableError(f"{name}: got {shown(values[name])}, allowed: {meaning}")
    return values


def _read_datasets(image: Image, found: Mapping[str, Any]) -> dict[str, Array]:
    """All datasets by path; all is checked that can be before any values are read."""
    described: dict[str, Values] = {}
    for path, messages in found.items():
        values = dataset(image, path, messages)
        if values is not None:
            described[path] = values
    check_shapes({path: values.shape for path, values in described.items()})
    for known in layout_of(described):
        got, allowed = described[known.path].dtype, np.dtype(known.dtype)
        if got.str != known.dtype:
            order = "big-endian " if got.str[0] == ">" else ""
            raise TableError(f"{known.path}: got {order}{got.name}, allowed: {allowed.name}")
        places = attributes(image, found[known.path])
        if "units" in places:
            units = _value(image, places, "units")
            check_units(known.path, units, known.units)
    size, most = sum(v.nbytes for v in described.values()), FREE_BYTES + MOST_EXPANSION * len(image)
    if size > most:
        raise TableError(
            f"datasets: got {size} bytes, allowed: at most {most} in a file of {len(image)}"
        )
    return {path: read(image, path, values) for path, values in described.items()}
