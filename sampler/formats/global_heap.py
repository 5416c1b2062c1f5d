"""A look at the global heaps of an HDF5 file before the library follows them.

HDF5 keeps texts of variable length, as the attributes of a table, in collections: 16 bytes of
header (``GCOL``, version 1, three reserved bytes, size of the collection), then objects, each with
16 bytes of header (number, count of references, four reserved bytes, size) and its bytes, padded to
a multiple of 8. Number 0 is free space, whose size counts its header. The library (2.0.0) steps
from object to object by sizes that it takes as they are, and for ever where one is 0. See "Disk
Format: Level 1E", HDF5 File Format Specification.
"""

import struct

from sampler.errors import TableError

_SIGNATURE = b"GCOL\1"
_HEADER = 16


def check_global_heaps(image: bytes) -> None:
    """Refuse an HDF5 file with a collection that cannot be stepped through.

    Every place is looked at where a collection may begin, whatever refers to it. In all, no more
    steps are taken than a file of this length can have objects.
    """
    steps = len(image) // _HEADER
    start = image.find(_SIGNATURE)
    while start >= 0:
        (size,) = struct.unpack_from("<Q", image[start : start + _HEADER].ljust(_HEADER, b"\0"), 8)
        # the library refuses those that do not fit into the file
        if start + size <= len(image):
            steps = _walk(image, start, start + size, steps)
        start = image.find(_SIGNATURE, start + 1)


def _walk(image: bytes, start: int, end: int, steps: int) -> int:
    """Step through one collection; the steps that are left."""
    at = start + _HEADER
    while end - at >= _HEADER:
        number, size = struct.unpack_from("<H6xQ", image, at)
        step = _HEADER + -(-size // 8) * 8 if number else size
        steps -= 1
        if not _HEADER <= step <= end - at or steps < 0:
            raise TableError(
                f"global heap: got an object of {size} bytes, allowed: what fits into it"
            )
        at += step
    return steps
