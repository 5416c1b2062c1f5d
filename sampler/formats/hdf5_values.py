"""Values in an HDF5 file: attributes and datasets, from the messages that describe them.

See the messages "Dataspace", "Datatype", "Data Layout", "Filter Pipeline" and "Attribute", "Global
Heap", and the B-trees of chunks in the HDF5 File Format Specification. What a table does not need
is refused: values in other files, virtual datasets, filters but gzip and shuffle, and types but
text and plain numbers.
"""

import itertools
import math
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.errors import TableError
from sampler.formats.hdf5_image import (
    ATTRIBUTE,
    EXTERNAL,
    FILTERS,
    LAYOUT,
    NOWHERE,
    SPACE,
    TYPE,
    Image,
    Message,
    damaged,
    tree,
)

Array = NDArray[Any]
Shape = tuple[int, ...] | None

_MOST_DIMENSIONS = 32
_INTEGER, _REAL, _TEXT, _LONG = 0, 1, 3, 9
_OTHER_TYPES = {
    2: "times",
    4: "bit fields",
    5: "opaque bytes",
    6: "compounds",
    7: "references",
    8: "enumerations",
    9: "sequences",
    10: "arrays",
    11: "complex numbers",
}
_COMPACT, _CONTIGUOUS, _CHUNKED = 0, 1, 2
_CHUNK_TREE = 1
_GZIP, _SHUFFLE = 1, 2
#: Position of the sign and properties of IEEE numbers of 2, 4 and 8 bytes.
_IEEE = {
    2: (15, (0, 16, 10, 5, 0, 10, 15)),
    4: (31, (0, 32, 23, 8, 0, 23, 127)),
    8: (63, (0, 64, 52, 11, 0, 52, 1023)),
}


def _shape(image: Image, at: int) -> Shape:
    """Shape that a dataspace message says; None if it has no values."""
    version, count, _, kind = image.numbers("4B", at)
    if version not in (1, 2) or count > _MOST_DIMENSIONS:
        raise damaged("dataspace")
    if version == 2 and kind == 2:
        return None
    return image.numbers(f"{count}Q", at + (8 if version == 1 else 4))


class WrongTypeError(Exception):
    """Values of a type that tables do not have; the message names it."""


@dataclass(frozen=True)
class _Text:
    """Type of texts with so many bytes, or of any length."""

    nbytes: int | None


def _type(image: Image, at: int) -> np.dtype | _Text:
    """Type that a message describes."""
    kind, low, high, size = image.numbers("BBBxI", at)
    kind &= 0x0F
    if kind == _TEXT:
        return _Text(size)
    if kind == _LONG and low & 0x0F == 1:
        return _Text(None)
    order = "<>"[low & 1]
    if kind == _INTEGER and size in (1, 2, 4, 8) and image.numbers("HH", at + 8) == (0, 8 * size):
        return np.dtype(f"{order}{'i' if low & 8 else 'u'}{size}")
    real = kind == _REAL and size in _IEEE and low & 0x70 == 0x20
    if real and (high, image.numbers("HH4BI", at + 8)) == _IEEE[size]:
        return np.dtype(f"{order}f{size}")
    raise WrongTypeError(_OTHER_TYPES.get(kind, "numbers of another kind"))


def _count(shape: Iterable[int]) -> int:
    return math.prod(shape)  # in Python's integers, which do not overflow


def attributes(image: Image, found: Sequence[Message]) -> dict[str, int]:
    """Where the attributes of an object are described, by name."""
    places = {}
    for message in found:
        if message.kind == ATTRIBUTE:
            version, size = image.numbers("BxH", message.start)
            name = message.start + (9 if version == 3 else 8)
            places[image.text(name, name + size)] = message.start
    return places


def attribute(image: Image, at: int) -> Any:
    """Value of an attribute as Python's own type: text, a number, or lists; or `WrongTypeError`."""
    version, flags, *sizes = image.numbers("BB3H", at)
    if version not in (1, 2, 3) or (version > 1 and flags):
        raise WrongTypeError("a type of another place")
    if version == 1:  # name, type and shape are padded
        sizes = [-(-size // 8) * 8 for size in sizes]
    *_, kind, space, value = itertools.accumulate(sizes, initial=at + (9 if version == 3 else 8))
    said, shape = _type(image, kind), _shape(image, space)
    if shape is None:
        raise WrongTypeError("nothing")
    if isinstance(said, np.dtype):
        data = image.part(value, _count(shape) * said.itemsize)
        return np.frombuffer(data, said).reshape(shape).tolist()
    if shape != ():
        raise WrongTypeError("several texts")
    text = _long_text(image, value) if said.nbytes is None else image.part(value, said.nbytes)
    return text.partition(b"\0")[0].decode()


def _long_text(image: Image, at: int) -> bytes:
    """Text of variable length: its length, a collection of objects, and the number of one of them.

    A collection has a header of 16 bytes, then objects, each with 16 bytes of header (number, count
    of references, size) and its bytes, padded to a multiple of 8; number 0 is free space.
    """
    length, collection, wanted = image.numbers("IQI", at)
    if length == 0:
        return b""
    at = image.signed(b"GCOL\1", collection) + 11
    (size,) = image.numbers("Q", at - 8)
    end = collection + size
    while at + 16 <= end:
        number, size = image.numbers("H6xQ", at)
        if number == wanted and length <= size:
            return image.part(at + 16, length)
        if number in (0, wanted):
            break  # free space is last
        at += 16 + -(-size // 8) * 8
    raise damaged("text of an attribute")


@dataclass(frozen=True)
class Values:
    """A dataset that has not been read yet.

    Attributes
    ----------
    shape : tuple of int
    dtype : numpy.dtype
    filters : list of int
        Codes of what its chunks went through.
    layout : int
        Where the message on its layout begins.
    """

    shape: tuple[int, ...]
    dtype: np.dtype
    filters: list[int]
    layout: int

    @property
    def nbytes(self) -> int:
        """Bytes of the values."""
        return _count(self.shape) * self.dtype.itemsize


def dataset(image: Image, path: str, found: Sequence[Message]) -> Values | None:
    """Gather what the messages of an object describe, if it is a dataset.

    Raises
    ------
    TableError
        If its values are not plain numbers in the file itself, stored as h5py does by default.
    """
    starts = {message.kind: message.start for message in found}
    if LAYOUT not in starts:
        return None
    if SPACE not in starts or TYPE not in starts:
        raise damaged(path)
    shape, dtype = _shape(image, starts[SPACE]), _numbers(image, path, starts[TYPE])
    if shape is None:
        raise TableError(f"{path}: got no values, allowed: numbers")
    if image.numbers("B", starts[LAYOUT]) != (3,) or EXTERNAL in starts:
        raise TableError(f"{path}: is virtual or external, allowed: values in the file itself")
    filters = _filters(image, starts[FILTERS]) if FILTERS in starts else []
    if filters not in ([], [_GZIP], [_SHUFFLE], [_SHUFFLE, _GZIP]):
        raise TableError(f"{path}: got filters {filters}, allowed: gzip, shuffle")
    return Values(shape, dtype, filters, starts[LAYOUT])


def _numbers(image: Image, path: str, at: int) -> np.dtype:
    """Type of the numbers of a dataset."""
    try:
        dtype = _type(image, at)
    except WrongTypeError as error:
        raise TableError(f"{path}: got {error}, allowed: numbers") from None
    if isinstance(dtype, _Text):
        raise TableError(f"{path}: got text, allowed: numbers")
    return dtype


def _filters(image: Image, at: int) -> list[int]:
    """Codes of the filters of a pipeline, in their order."""
    version, count = image.numbers("BB", at)
    if version != 1:
        raise damaged("filters")
    codes, at = [], at + 8
    for _ in range(count):
        code, name, parameters = image.numbers("HH2xH", at)
        codes.append(code)
        at += 8 + -(-name // 8) * 8 + 4 * (parameters + parameters % 2)
    return codes


def read(image: Image, path: str, values: Values) -> Array:
    """Values of a dataset; its size is the caller's concern."""
    if values.nbytes == 0:
        return np.empty(values.shape, values.dtype)
    (kind,) = image.numbers("xB", values.layout)
    if kind == _CHUNKED:
        return _chunked(image, path, values)
    if kind == _CONTIGUOUS:
        at, size = image.numbers("QQ", values.layout + 2)
    else:
        at, (size,) = values.layout + 4, image.numbers("H", values.layout + 2)
    if kind not in (_COMPACT, _CONTIGUOUS) or values.filters or size != values.nbytes:
        raise damaged(path)
    # a copy, which can be written to: to numba, others are of another type
    return np.frombuffer(image.part(at, size), values.dtype).reshape(values.shape).copy()


def _chunked(image: Image, path: str, values: Values) -> Array:
    """Values of a dataset that is stored in chunks."""
    rank = len(values.shape)
    if image.numbers("B", values.layout + 2) != (rank + 1,):
        raise damaged(path)
    root, *chunk = image.numbers(f"Q{rank}I", values.layout + 3)
    block_bytes = _count(chunk) * values.dtype.itemsize
    if not 0 < block_bytes <= values.nbytes or root == NOWHERE:
        raise TableError(f"{path}: got chunks {chunk}, allowed: at most {list(values.shape)}")
    result, starts = np.empty(values.shape, values.dtype), set()
    for key, address in tree(image, root, _CHUNK_TREE, 16 + 8 * rank):
        size, skipped, *start = image.numbers(f"II{rank}Q", key)
        held = result[tuple(slice(a, a + n) for a, n in zip(start, chunk, strict=True))]
        usable = not skipped and held.size and not any(map(int.__mod__, start, chunk))
        # each place once: in a hostile file, many chunks may be one
        if not usable or tuple(start) in starts:
            raise damaged(f"{path}, chunk at {start}")
        starts.add(tuple(start))
        block = _unpacked(image.part(address, size), values, block_bytes).reshape(chunk)
        held[...] = block[tuple(slice(n) for n in held.shape)]
    expected = _count(-(-n // step) for n, step in zip(values.shape, chunk, strict=True))
    if len(starts) != expected:
        raise damaged(f"{path}: {len(starts)} chunks of {expected}")
    return result


def _unpacked(data: bytes, values: Values, size: int) -> Array:
    """Numbers of a chunk that has this size in bytes; no more of it is unpacked."""
    if _GZIP in values.filters:
        data = zlib.decompressobj().decompress(data, size)
    if len(data) != size:
        raise damaged(f"a chunk of {len(data)} bytes")
    item_bytes = values.dtype.itemsize
    plain = _unshuffled(data, item_bytes) if _SHUFFLE in values.filters else data
    return np.frombuffer(plain, values.dtype)


def _unshuffled(data: bytes, item_bytes: int) -> Array:
    """Numbers of which all first bytes were stored together, then all second ones, and so on."""
    planes = np.frombuffer(data, np.uint8).reshape(item_bytes, -1)
    numbers = planes[0].astype(f"<u{item_bytes}")
    for k in range(1, item_bytes):
        numbers |= planes[k].astype(numbers.dtype) << (8 * k)
    return numbers
