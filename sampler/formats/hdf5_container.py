"""The HDF5 container of a table, read so that no file can hurt.

What HDF5 offers and a table does not use is refused before the library follows it: storage in other
files, virtual datasets, filters but gzip and shuffle, and attributes that are neither text nor
numbers; links to other places are not followed. Nothing is read before the sizes of all datasets
are known and bounded by the size of the file. The library takes lengths of texts and of unpacked
chunks on trust: chunks are read here, texts by `sampler.formats.hdf5_texts`.
"""

import itertools
import math
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import h5py
import numpy as np
from h5py import h5d, h5f, h5o, h5s, h5t, h5z
from numpy.typing import NDArray

from sampler.errors import TableError
from sampler.formats.hdf5_attributes import check_units, shown
from sampler.formats.hdf5_layout import (
    ATTRIBUTES,
    DATASETS,
    FORMAT,
    FORMAT_VERSION,
    OPTIONAL_ATTRIBUTES,
    Dataset,
)
from sampler.formats.hdf5_texts import Texts
from sampler.formats.table_shapes import check_shapes

Array = NDArray[Any]

#: Bytes of the datasets that a file of any size may have, and further ones for each of its bytes.
#: Shipped tables have 1.3 for each.
FREE_BYTES, MOST_EXPANSION = 2**24, 8

#: Most root attributes, and most datasets.
MOST_OBJECTS = 1000

_LAYOUTS = (h5d.COMPACT, h5d.CONTIGUOUS, h5d.CHUNKED)
_FILTERS: tuple[list[int], ...] = (
    [],
    [h5z.FILTER_DEFLATE],
    [h5z.FILTER_SHUFFLE],
    [h5z.FILTER_SHUFFLE, h5z.FILTER_DEFLATE],
)


def read_container(image: bytes) -> tuple[dict[str, Any], dict[str, Array]]:
    """Root attributes by name, and datasets by path, of the bytes of an HDF5 file.

    Datasets that the layout does not know, of a later minor version, count in the checksum and are
    among them.

    Raises
    ------
    TableError
        If the bytes cannot be read, are no table or of a newer major version, or if attributes or
        shapes and types of datasets are not as the layout says.
    """
    with _one_line_errors(), h5py.File(h5f.open_file_image(image), "r") as file:
        if file.id.get_create_plist().get_sizes() != (8, 8) or file.userblock_size:
            raise TableError("addresses: got others, allowed: 8 bytes, counted from the begin")
        texts = Texts(image, h5o.get_info(file.id).addr)
        return _read_attributes(file, texts, len(image)), _read_datasets(file, image)


@contextmanager
def _one_line_errors() -> Iterator[None]:
    """Turn what h5py raises on foreign or damaged files, errors of any type, into one line.

    The library opens some truncated files without complaint and fails on reading.
    """
    try:
        yield
    except TableError:
        raise
    except Exception as error:
        reason = str(error).strip("'\"").partition("\n")[0] or type(error).__name__
        raise TableError(f"cannot be read as HDF5, truncated or damaged? ({reason})") from error


def _read_attribute(
    node: h5py.Group | h5py.Dataset, name: str, texts: Texts, most_bytes: int
) -> Any:
    """Attribute as Python's own type, for JSON; None if there is none."""
    if name not in node.attrs:
        return None
    attribute = node.attrs.get_id(name)
    kind, shape_kind = attribute.get_type(), attribute.get_space().get_simple_extent_type()
    is_text = kind.get_class() == h5t.STRING and shape_kind == h5s.SCALAR
    is_numbers = kind.get_class() in (h5t.INTEGER, h5t.FLOAT) and shape_kind != h5s.NULL
    if is_text and kind.is_variable_str():
        return texts[name]
    if not (is_text or is_numbers) or attribute.get_storage_size() > most_bytes:
        raise TableError(f"{name}: got another type or size, allowed: text or numbers")
    value = node.attrs[name]
    if isinstance(value, bytes):
        return value.decode()
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def _check_version(file: h5py.File, texts: Texts, most_bytes: int) -> None:
    """Refuse what is no table, or one of a newer major version."""
    if _read_attribute(file, "format", texts, most_bytes) != FORMAT:
        raise TableError(f'format: is not "{FORMAT}", so this is some other HDF5 file')
    version = _read_attribute(file, "format_version", texts, most_bytes)
    if not (isinstance(version, list) and [type(v) for v in version] == [int, int]):
        raise TableError(f"format_version: got {version!r}, allowed: two integers")
    if version[0] != FORMAT_VERSION[0]:
        raise TableError(
            f"format_version: got {version[0]}.{version[1]}, "
            f"allowed: {FORMAT_VERSION[0]}.x (a newer file needs a newer rebound-tables)"
        )


def _read_attributes(file: h5py.File, texts: Texts, file_bytes: int) -> dict[str, Any]:
    """Root attributes, after format and version were found to be ours."""
    _check_version(file, texts, file_bytes)
    if len(file.attrs) > MOST_OBJECTS:
        raise TableError(f"got {len(file.attrs)} attributes, allowed: at most {MOST_OBJECTS}")
    attributes: dict[str, Any] = {}
    left = file_bytes
    for name in file.attrs:
        attributes[name] = value = _read_attribute(file, name, texts, left)
        # attributes of a hostile file may share their text
        left -= len(str(value))
        if left < 0:
            raise TableError(f"{name}: got more text than the file has bytes")
    for name, (kind, meaning) in {**ATTRIBUTES, **OPTIONAL_ATTRIBUTES}.items():
        if name not in attributes:
            if name in OPTIONAL_ATTRIBUTES:
                continue
            raise TableError(f"{name}: is missing, allowed: {meaning}")
        wrong = name == "speed_independent" and attributes[name] != 1
        if wrong or type(attributes[name]) is not kind:
            raise TableError(f"{name}: got {shown(attributes[name])}, allowed: {meaning}")
    return attributes


def _filters(node: h5py.Dataset) -> list[int]:
    """Codes of the filters that a dataset's chunks have gone through, in their order."""
    plan = node.id.get_create_plist()
    return [plan.get_filter(k)[0] for k in range(plan.get_nfilters())]


def _check_storage(path: str, node: h5py.Dataset) -> None:
    """Refuse a dataset that is not stored in the file, or by other filters."""
    plan, filters = node.id.get_create_plist(), _filters(node)
    if plan.get_layout() not in _LAYOUTS or plan.get_external_count():
        raise TableError(
            f"{path}: is virtual or in another file, allowed: values in the file itself"
        )
    if filters not in _FILTERS:
        raise TableError(f"{path}: got filters {filters}, allowed: gzip, shuffle")


def _check_type(path: str, node: h5py.Dataset) -> None:
    """Refuse anything but an array of plain numbers."""
    if node.shape is None:
        raise TableError(f"{path}: got no values, allowed: numbers")
    # Datasets of a later minor version count in the checksum, which is over plain numbers.
    if node.dtype.kind not in "biuf" or not node.id.get_type().equal(h5t.py_create(node.dtype)):
        raise TableError(f"{path}: got {node.dtype.name} values, allowed: numbers")


def _find_datasets(file: h5py.File) -> dict[str, h5py.Dataset]:
    """All datasets by path, each of plain numbers in the file itself."""
    found: dict[str, h5py.Dataset] = {}

    def visit(path: str, node: h5py.Group | h5py.Dataset) -> None:
        if isinstance(node, h5py.Dataset):
            _check_storage(path, node)  # first: to look at a virtual dataset may open others
            found[path] = node
            if len(found) > MOST_OBJECTS:
                raise TableError(f"got more than {MOST_OBJECTS} datasets, allowed: at most so many")

    file.visititems(visit)
    for path, node in found.items():
        _check_type(path, node)
    return found


def _check_units(dataset: Dataset, node: h5py.Dataset, image: bytes) -> None:
    """Refuse other units than those of the layout."""
    texts = Texts(image, h5o.get_info(node.id).addr)
    units = _read_attribute(node, "units", texts, len(image))
    check_units(dataset.path, units, dataset.units)


def _read_datasets(file: h5py.File, image: bytes) -> dict[str, Array]:
    """All datasets by path; all is checked that can be before any values are read."""
    found, file_bytes = _find_datasets(file), len(image)
    check_shapes({path: node.shape for path, node in found.items()})
    for dataset in DATASETS:
        if found[dataset.path].dtype.str != dataset.dtype:
            got, allowed = found[dataset.path].dtype, np.dtype(dataset.dtype).name
            order = "big-endian " if got.str[0] == ">" else ""
            raise TableError(f"{dataset.path}: got {order}{got.name}, allowed: {allowed}")
        _check_units(dataset, found[dataset.path], image)
    # in Python's integers, which do not overflow
    size = sum(math.prod(node.shape) * node.dtype.itemsize for node in found.values())
    most = FREE_BYTES + MOST_EXPANSION * file_bytes
    if size > most:
        raise TableError(
            f"datasets: got {size} bytes, allowed: at most {most} in a file of {file_bytes}"
        )
    return {
        path: node[()] if node.chunks is None else _chunked(path, node, file_bytes)
        for path, node in found.items()
    }


def _chunked(path: str, node: h5py.Dataset, file_bytes: int) -> Array:
    """Values of a dataset that is stored in chunks."""
    values, chunk = np.empty(node.shape, node.dtype), node.chunks
    starts = [range(0, n, step) for n, step in zip(node.shape, chunk, strict=True)]
    count, stored = math.prod(map(len, starts)), node.id.get_num_chunks()
    # neither many chunks, if they are all there, nor large ones: the dataset has a bounded size
    if stored != count or math.prod(chunk) > max(values.size, 1):
        raise TableError(f"{path}: got {stored} chunks {chunk}, allowed: {count} in the dataset")
    filters, size = _filters(node), math.prod(chunk) * node.dtype.itemsize
    for start in itertools.product(*starts):
        if node.id.get_chunk_info_by_coord(start).size > file_bytes:
            raise TableError(f"{path}: got a chunk that is larger than the file")
        skipped, data = node.id.read_direct_chunk(start)
        if h5z.FILTER_DEFLATE in filters:
            data = zlib.decompressobj().decompress(data, size)
        if skipped or len(data) != size:
            raise TableError(f"{path}: got a damaged chunk at {start}")
        if h5z.FILTER_SHUFFLE in filters:
            data = _unshuffled(data, node.dtype.itemsize)
        block = np.frombuffer(data, node.dtype).reshape(chunk)
        held = values[tuple(slice(a, a + n) for a, n in zip(start, chunk, strict=True))]
        held[...] = block[tuple(slice(n) for n in held.shape)]
    return values


def _unshuffled(data: bytes, item_bytes: int) -> Array:
    """Numbers of which all first bytes were stored together, then all second ones, and so on."""
    planes = np.frombuffer(data, np.uint8).reshape(item_bytes, -1)
    numbers = planes[0].astype(f"<u{item_bytes}")
    for k in range(1, item_bytes):
        numbers |= planes[k].astype(numbers.dtype) << (8 * k)
    return numbers
