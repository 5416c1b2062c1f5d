"""The bytes of an HDF5 file, and the numbers, objects and links in them.

Tables are not read by the HDF5 library (2.0.0): a few changed bytes make it loop for ever, deaf to
Ctrl-C, set aside 4 GiB, or crash. What h5py writes by default needs few structures, all described
in the HDF5 File Format Specification: superblock (version 0), object headers (version 1), B-trees
(version 1), symbol table nodes and local heaps of groups. They are followed here, within the bytes
of the file, and others are refused. Addresses and lengths have 8 bytes.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from sampler.errors import TableError

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
#: Address of what is not stored.
NOWHERE = 2**64 - 1

#: Most groups and datasets of a file, and most bytes of what describes them; the shipped table has
#: 23 and 16 kB.
MOST_OBJECTS, MOST_STRUCTURE = 1000, 2**22

#: Kinds of messages in object headers.
SPACE, TYPE, EXTERNAL, LAYOUT, FILTERS, ATTRIBUTE = 0x01, 0x03, 0x07, 0x08, 0x0B, 0x0C
_LINK_INFO, _LINK, _CONTINUATION, _SYMBOL_TABLE = 0x02, 0x06, 0x10, 0x11
_GROUP_TREE = 0
#: Of links that are messages, and of entries of a symbol table.
_HARD_LINK, _SOFT_LINK = 0, 2


def damaged(what: str) -> TableError:
    """Error for a file of which a part cannot be followed."""
    return TableError(f"cannot be read as HDF5, truncated or damaged? ({what})")


class Image:
    """Bytes of an HDF5 file, read by steps that are checked.

    In a hostile file, structures overlap and refer to each other in circles. So there is an end to
    what is read: twice the bytes of the file in all, and `MOST_STRUCTURE` of them in numbers.

    Parameters
    ----------
    data : bytes
    """

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._left, self._structure_left = 2 * len(data), MOST_STRUCTURE

    def __len__(self) -> int:
        return len(self._data)

    def part(self, at: int, size: int) -> bytes:
        """Bytes at a place."""
        self._left -= size
        if at + size > len(self._data) or self._left < 0:
            raise damaged(f"{size} bytes at {at}")
        return self._data[at : at + size]

    def numbers(self, layout: str, at: int) -> tuple[int, ...]:
        """Numbers at a place, little-endian."""
        size = struct.calcsize(f"<{layout}")
        self._structure_left -= size
        if self._structure_left < 0:
            raise TableError(f"got more than {MOST_STRUCTURE} bytes of structures")
        return struct.unpack(f"<{layout}", self.part(at, size))

    def signed(self, signature: bytes, at: int) -> int:
        """Place behind a signature, which must stand here."""
        if self.part(at, len(signature)) != signature:
            raise damaged(f"no {signature.decode(errors='replace')} at {at}")
        return at + len(signature)

    def text(self, at: int, end: int) -> str:
        """Name that ends with a zero byte before a place; as `name`."""
        stop = self._data.find(b"\0", at, end)
        if stop < 0:
            raise damaged(f"name at {at}")
        return self.name(at, stop - at)

    def name(self, at: int, size: int) -> str:
        """Name of a length; one that can be shown in a message."""
        name = self.part(at, size).decode(errors="replace")
        if not name.isprintable():
            raise damaged(f"name at {at}")
        return name

    def root(self) -> int:
        """Address of the object header of the root group."""
        if not self._data.startswith(_SIGNATURE):
            raise damaged("no HDF5 signature")
        version, *sizes = self.numbers("B4xBB", len(_SIGNATURE))
        if version != 0 or sizes != [8, 8]:
            raise TableError(
                f"cannot be read as HDF5: got superblock version {version} and addresses of "
                f"{sizes[0]} bytes, allowed: version 0 and 8 bytes, as h5py writes by default"
            )
        base, _, end, _, _, root = self.numbers("6Q", 24)
        if base != 0 or end > len(self._data):
            raise damaged(f"the file has {len(self._data)} of {end} bytes")
        return root


@dataclass(frozen=True, slots=True)
class Message:
    """A message in an object header: its kind, and where it lies."""

    kind: int
    start: int
    size: int


def messages(image: Image, header: int) -> list[Message]:
    """Messages of an object header."""
    version, length = image.numbers("B7xI", header)
    if version != 1:
        raise damaged(f"object header of version {version}")
    found, blocks = [], [(header + 16, length)]
    for start, length in blocks:
        at, end = start, start + length
        while at + 8 <= end:
            kind, size, flags = image.numbers("HHB3x", at)
            at += 8
            if kind == _CONTINUATION:
                address, more = image.numbers("QQ", at)
                blocks.append((address, more))
            elif flags & 2:
                raise damaged("shared message")
            elif kind:
                found.append(Message(kind, at, size))
            at += size
    return found


def tree(image: Image, address: int, kind: int, key_bytes: int) -> Iterator[tuple[int, int]]:
    """Leaves of a B-tree: where their keys stand, and their addresses.

    Parameters
    ----------
    image : Image
    address : int
    kind : int
        0 for groups, 1 for chunks.
    key_bytes : int
    """
    nodes: list[tuple[int, int | None]] = [(address, None)]
    while nodes:
        at, expected = nodes.pop()
        at = image.signed(b"TREE", at)
        found, level, count = image.numbers("BBH16x", at)
        if found != kind or level != (level if expected is None else expected):
            raise damaged("B-tree")
        keys = [at + 20 + k * (key_bytes + 8) for k in range(count)]
        children = [(key, image.numbers("Q", key + key_bytes)[0]) for key in keys]
        if level:
            nodes.extend((child, level - 1) for _, child in reversed(children))
        else:
            yield from children


def links(image: Image, found: list[Message]) -> Iterator[tuple[str, int]]:
    """Names and header addresses of the members of a group, of which the messages were found.

    Soft links are left out, and nothing comes of what is no group.
    """
    for message in found:
        if message.kind == _LINK_INFO:
            flags, *places = image.numbers("xBQQ", message.start)
            # two addresses, which a number may precede: that of a heap of links comes first
            if places[flags & 1] != NOWHERE:
                raise damaged("more links than h5py writes by default")
        elif message.kind == _LINK:
            yield from _link(image, message.start)
        elif message.kind == _SYMBOL_TABLE:
            btree, heap = image.numbers("QQ", message.start)
            heap = image.signed(b"HEAP\0", heap)
            size, _, names = image.numbers("3x3Q", heap)
            for _, address in tree(image, btree, _GROUP_TREE, 8):
                node = image.signed(b"SNOD\1", address)
                (count,) = image.numbers("xH", node)
                for k in range(count):
                    name, header, cached = image.numbers("QQI4x", node + 3 + 40 * k)
                    if cached != _SOFT_LINK:
                        yield image.text(names + name, names + size), header


def _link(image: Image, at: int) -> Iterator[tuple[str, int]]:
    """Name and header address of a hard link that is a message; nothing for other links.

    h5py makes messages of the links of a group that has got a link to another file.
    """
    (flags,) = image.numbers("xB", at)
    # optional: type, number of creation, character set
    kind = image.numbers("B", at + 2)[0] if flags & 8 else _HARD_LINK
    at += 2 + bool(flags & 8) + 8 * bool(flags & 4) + bool(flags & 16)
    length_bytes = 1 << (flags & 3)
    (length,) = image.numbers("BHIQ"[flags & 3], at)
    name = at + length_bytes
    if kind == _HARD_LINK:
        yield image.name(name, length), image.numbers("Q", name + length)[0]


def objects(image: Image) -> Iterator[tuple[str, list[Message]]]:
    """Path and messages of every object, the root first, each by the first name that leads there.

    Names come in order, and what is below a group before what follows it, as the library does it.
    """
    root = image.root()
    found = messages(image, root)
    yield "", found
    seen, groups = {root}, [("", links(image, found))]
    while groups:
        path, members = groups[-1]
        name, header = next(members, (None, root))
        if name is None:
            groups.pop()
        elif header not in seen:
            seen.add(header)
            if len(seen) > MOST_OBJECTS:
                raise TableError(f"got more than {MOST_OBJECTS} datasets and groups")
            found = messages(image, header)
            yield f"{path}{name}", found
            groups.append((f"{path}{name}/", links(image, found)))
