"""Texts of variable length among the attributes of an HDF5 object, found without the library.

HDF5 keeps such texts in global heaps, and the library (2.0.0) takes on trust what it finds there:
it steps from object to object for ever where one has the size 0, and sets aside as many bytes as
an attribute says that its text has, up to 4 GiB. Here every step is checked.

An attribute is a message in the object header of the group; its value is the length of the text
(4 bytes), the address of a collection (8) and the number of an object in it (4). A collection has
a header of 16 bytes (``GCOL``, version, size), then objects, each with 16 bytes of header (number,
count of references, size) and its bytes, padded to a multiple of 8; number 0 is free space, whose
size counts its header. See "Object Headers", "The Attribute Message" and "Global Heap" in the HDF5
File Format Specification; version 1 of the header is what h5py writes unless told otherwise.
"""

import struct
from collections.abc import Iterator

from sampler.errors import TableError

_ATTRIBUTE, _CONTINUATION = 0x0C, 0x10
#: Bytes of the header of a collection, and of that of an object in it.
_HEADER = 16


def _damaged(what: str) -> TableError:
    return TableError(f"{what}: is damaged, or stored as h5py does only with another libver")


def _numbers(layout: str, image: bytes, at: int) -> tuple[int, ...]:
    """Numbers at a place in the file."""
    if at + struct.calcsize(layout) > len(image):
        raise _damaged("HDF5 object")
    return struct.unpack_from(layout, image, at)


def _padded(size: int) -> int:
    return -(-size // 8) * 8


class Texts:
    """Texts of variable length among the attributes of one object.

    Parameters
    ----------
    image : bytes
        An HDF5 file with addresses and lengths of 8 bytes.
    header : int
        Address of the header of the object.
    """

    def __init__(self, image: bytes, header: int) -> None:
        self._image = image
        #: Bytes of headers and collections that may be walked through, which may overlap.
        self._left = 2 * len(image)
        self._places = dict(self._attributes(header))
        self._collections: dict[int, dict[int, tuple[int, int]]] = {}

    def __getitem__(self, name: str) -> str:
        """Text of an attribute; raises `TableError` if it cannot be found."""
        if name not in self._places:
            raise _damaged(name)
        length, collection, number = _numbers("<IQI", self._image, self._places[name])
        if length == 0:
            return ""
        if collection not in self._collections:
            self._collections[collection] = dict(self._objects(collection))
        start, size = self._collections[collection].get(number, (0, 0))
        if length > size:
            raise _damaged(name)
        return self._image[start : start + length].partition(b"\0")[0].decode()

    def _walk(self, size: int) -> None:
        self._left -= size
        if self._left < 0:
            raise _damaged("HDF5 object")

    def _messages(self, header: int) -> Iterator[tuple[int, int]]:
        """Kind and begin of each message in an object header."""
        version, length = _numbers("<B7xI", self._image, header)
        blocks = [(header + _HEADER, length)] if version == 1 else []
        for start, length in blocks:
            self._walk(length)
            at, end = start, start + length
            while at + 8 <= end:
                kind, size = _numbers("<HH4x", self._image, at)
                at += 8
                if kind == _CONTINUATION:
                    following, length = _numbers("<QQ", self._image, at)
                    blocks.append((following, length))
                yield kind, at
                at += size

    def _attributes(self, header: int) -> Iterator[tuple[str, int]]:
        """Name of each attribute and where its value stands."""
        for kind, start in self._messages(header):
            if kind == _ATTRIBUTE:
                version, *sizes = _numbers("<BxHHH", self._image, start)
                name = start + (9 if version == 3 else 8)
                text = self._image[name : name + sizes[0]].partition(b"\0")[0]
                # name, type and dimensions, then the value
                parts = map(_padded, sizes) if version == 1 else sizes
                yield text.decode(errors="replace"), name + sum(parts)

    def _objects(self, collection: int) -> Iterator[tuple[int, tuple[int, int]]]:
        """Walk through a collection: number, begin and size of each object."""
        signature, version, length = _numbers("<4sB3xQ", self._image, collection)
        if (signature, version) != (b"GCOL", 1):
            raise _damaged("global heap")
        self._walk(length)
        at, end = collection + _HEADER, collection + length
        while end - at >= _HEADER:
            number, size = _numbers("<H6xQ", self._image, at)
            step = _HEADER + _padded(size) if number else size
            if not _HEADER <= step <= end - at:
                raise _damaged("global heap")
            yield number, (at + _HEADER, size)
            at += step
