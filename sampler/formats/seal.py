r"""The seal of a table file: a checksum of all its bytes, which stands behind them.

A table file is HDF5, whose own structures (groups, B-trees, heaps) have no checksums: one flipped
bit can lead the HDF5 library anywhere, into loops without end for example. So the file ends with 40
bytes, ``\x89RBTSEAL`` and the SHA-256 of all bytes before them, and a reader looks there before
HDF5 does. HDF5 takes no notice of bytes behind its own. When it has had a file open
for writing, it cuts them off: an edited file has no seal, and neither do those written before
there were seals. They are read all the same (`sampler.formats.hdf5_container`).

Run ``python -m sampler.formats.seal FILE...`` to seal tables, after reading and checking them.
"""

import hashlib
import sys
from pathlib import Path

from sampler.errors import InputError, TableError
from sampler.files.atomic import atomic_output

_MAGIC = b"\x89RBTSEAL"
_BYTES = len(_MAGIC) + hashlib.sha256().digest_size


def sealed(image: bytes) -> bytes:
    """Add its seal to an HDF5 file."""
    return image + _MAGIC + hashlib.sha256(image).digest()


def unsealed(data: bytes) -> bytes:
    """Remove its seal from a file that has one; raises `TableError` if it is another file's."""
    end = data.rfind(_MAGIC, max(len(data) - _BYTES, 0))
    if end < 0:
        return data
    image, digest = data[:end], data[end + len(_MAGIC) :]
    if hashlib.sha256(image).digest() != digest:
        raise TableError("the bytes do not have the checksum at their end, so the file is damaged")
    return image


def main(paths: list[str]) -> int:
    """Seal the tables that the command line names."""
    from sampler.formats.hdf5 import read_table  # which needs this module

    try:
        for path in map(Path, paths):
            checksum = read_table(path).content_sha256
            data = sealed(unsealed(path.read_bytes()))
            with atomic_output(path) as temporary:
                temporary.write_bytes(data)
            print(f"{path}: sealed, contents {checksum}")
    except InputError as error:
        print(f"seal: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
