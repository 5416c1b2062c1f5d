"""Files that hurt the HDF5 library, or would take memory or time, are refused in one line."""

import struct
import subprocess
import sys
import tracemalloc
import zlib

import h5py
import numpy as np
import pytest
from sampler.formats.image import pack_quantiles, table_arrays
from sampler.formats.layout import DATASETS
from synthetic_table import make_contents, make_datasets

from sampler import TableError
from sampler.files import data_directory
from sampler.formats.hdf5 import read_table, write_table
from sampler.formats.hdf5_container import FREE_BYTES, MOST_EXPANSION, read_container
from sampler.formats.hdf5_image import MOST_OBJECTS, MOST_STRUCTURE, Image, messages, tree
from sampler.formats.table_shapes import check_shapes

MEAN, SPEED = "dependence/mean", "axes/speed"


@pytest.fixture
def file(tmp_path, contents):
    path = tmp_path / "t.h5"
    write_table(path, contents)
    return path


def _edit(path, change):
    with h5py.File(path, "r+") as opened:
        change(opened)


def _by_library(path):
    """Attributes and datasets as the HDF5 library reads them."""
    datasets = {}

    def visit(name, node):
        if isinstance(node, h5py.Dataset):
            datasets[name] = node[()]

    with h5py.File(path) as opened:
        opened.visititems(visit)
        attributes = {
            name: value.tolist() if hasattr(value, "tolist") else value
            for name, value in opened.attrs.items()
        }
    return attributes, datasets


def _assert_read_as_by_library(path):
    attributes, datasets = read_container(path.read_bytes())
    expected_attributes, expected = _by_library(path)
    assert attributes == expected_attributes
    assert set(datasets) == set(expected)
    for name, values in expected.items():
        assert datasets[name].dtype == values.dtype
        np.testing.assert_array_equal(datasets[name], values)


@pytest.mark.parametrize("name", ["corundum-steel", "corundum-steel-compact"])
def test_shipped_tables_are_read_as_by_the_library(name):
    _assert_read_as_by_library(data_directory() / f"{name}.h5")


def _stored(path, **storage):
    def change(opened):
        values = opened[path][()]
        del opened[path]
        opened.create_dataset(path, data=values, **storage)

    return change


def _texts_removed(opened):
    for name in ("a", "b", "c"):
        opened.attrs[name] = name * 99
    for name in ("b", "a"):
        del opened.attrs[name]


#: What h5py may do to a file unless told otherwise.
EDITS = {
    "nothing": lambda f: None,
    "other chunks": _stored(MEAN, chunks=(2, 2, 3, 4), compression="gzip"),
    "shuffle only": _stored(MEAN, chunks=(1, 3, 5, 6), shuffle=True),
    "one chunk": _stored(MEAN, chunks=(3, 3, 5, 6)),
    "many chunks": _stored(MEAN, chunks=(1, 1, 1, 1)),
    "contiguous": _stored(MEAN),
    "big-endian": lambda f: f.create_dataset("later/x", data=np.arange(7, dtype=">f8")),
    "one number": lambda f: f.create_dataset("later/x", data=1.5),
    "small": lambda f: f.create_dataset("later/x", data=np.arange(9, dtype="f2")),
    "empty": lambda f: f.create_dataset("later/x", data=np.empty((0, 3))),
    "many attributes": lambda f: [f.attrs.__setitem__(f"a{k}", k) for k in range(200)],
    "long attribute": lambda f: f.attrs.__setitem__("note", "α text " * 10_000),
    "fixed text": lambda f: f.attrs.__setitem__("note", np.bytes_("text")),
    "resizable and empty": lambda f: f.create_dataset("x", (0, 3), maxshape=(None, 3)),
    "texts replaced": lambda f: [
        f.attrs.__setitem__(name, name * k) for k in (90, 2, 500, 7) for name in ("pair", "a", "b")
    ],
    "texts removed": _texts_removed,
    "list of numbers": lambda f: f.attrs.__setitem__("note", np.arange(6.0).reshape(2, 3)),
    "many groups": lambda f: [f.create_group(f"a/b{k}/c") for k in range(100)],
    "loop": lambda f: f.__setitem__("axes/loop", f["/"]),
    "second name": lambda f: f.__setitem__("zzz", f[SPEED]),
    "external link": lambda f: f.__setitem__("s", h5py.ExternalLink("/dev/zero", "/x")),
    "soft link": lambda f: f.__setitem__("s", h5py.SoftLink("/axes/speed")),
}


@pytest.mark.parametrize("edit", EDITS)
def test_edited_files_are_read_as_by_the_library(edit, file):
    _edit(file, EDITS[edit])
    if edit == "fixed text":
        attributes, _ = read_container(file.read_bytes())
        assert attributes["note"] == "text"  # which the library gives as bytes
        _edit(file, lambda f: f.attrs.__delitem__("note"))
    _assert_read_as_by_library(file)


def test_a_file_copied_by_h5py_is_the_same_table(file, tmp_path):
    with h5py.File(file) as old, h5py.File(tmp_path / "copy.h5", "w") as new:
        for name in old:
            old.copy(name, new)
        new.attrs.update(old.attrs)
    assert read_table(tmp_path / "copy.h5").content_sha256 == read_table(file).content_sha256


def _attribute(value, **how):
    return lambda f: f.attrs.create("note", value, **how)


def _external(name):
    return lambda f: f.create_dataset(
        name, (8,), "u1", external=[("/dev/zero", 0, h5py.h5f.UNLIMITED)]
    )


def _virtual(f):
    layout = h5py.VirtualLayout((3,), "f8")
    layout[:] = h5py.VirtualSource("/dev/zero", "x", shape=(3,))
    f.create_virtual_dataset("later", layout)


def _bomb(f):
    """A chunk of 60 bytes that unpacks to 50 MB."""
    values = f.create_dataset("later", (60,), "u1", chunks=(60,), compression="gzip")
    values.id.write_direct_chunk((0,), zlib.compress(b"x" * 50_000_000))


def _cut_chunk(f):
    values = f.create_dataset("later", (60,), "u1", chunks=(60,), compression="gzip")
    values.id.write_direct_chunk((0,), zlib.compress(b"x" * 60)[:-9])


HOSTILE = {
    "list of bytes": (
        _attribute([b"a", b"b"]),
        "note: got several texts, allowed: text or numbers",
    ),
    "list of texts": (_attribute(["a", "b"]), "note: got several texts"),
    "complex": (_attribute(1j), "note: got .*, allowed: text or numbers"),
    "compound": (_attribute(np.zeros(2, "f8,i4")), "note: got compounds"),
    "reference": (lambda f: f.attrs.__setitem__("note", f.ref), "note: got references"),
    "no value": (_attribute(h5py.Empty("f8")), "note: got nothing"),
    "void": (_attribute(np.void(b"abc")), "note: got opaque bytes"),
    "truth": (_attribute(True), "note: got enumerations"),
    "sequence": (
        _attribute(np.array([np.arange(3), None], object)[:1], dtype=h5py.vlen_dtype("i4")),
        "note: got sequences",
    ),
    "odd format": (lambda f: f.attrs.__setitem__("format", [b"a", b"b"]), "format: got several"),
    "name of two lines": (lambda f: f.attrs.__setitem__("a\nb", 1), "damaged. .name at"),
    "name with an escape": (lambda f: f.create_group("\x1b[31mred"), "damaged. .name at"),
    "long list for a text": (
        lambda f: f.attrs.__setitem__("pair", np.arange(5000)),
        r"pair: got \[0, 1, .{,90}\.\.\., allowed: name",
    ),
    "null dataset": (
        lambda f: (f.__delitem__(SPEED), f.create_dataset(SPEED, dtype="f8")),
        f"{SPEED}: got no values, allowed: numbers",
    ),
    "unknown null dataset": (lambda f: f.create_dataset("x", dtype="f8"), "x: got no values"),
    "4 GiB that are not stored": (
        lambda f: f.create_dataset("later", (2**32,), "u1"),
        "datasets: got 42950.* bytes, allowed: at most 17.* in a file of",
    ),
    "more than numbers can say": (
        lambda f: f.create_dataset("later", (2**31, 2**31), "f8", chunks=(10, 10)),
        "datasets: got 368934.* bytes, allowed",
    ),
    "not stored": (lambda f: f.create_dataset("later", (9,), "f8"), "truncated or damaged"),
    "chunks not stored": (
        lambda f: f.create_dataset("later", (9,), "f8", chunks=(2,)),
        "later: got chunks",
    ),
    "some chunks": (
        lambda f: f.create_dataset("later", (9,), "f8", chunks=(2,)).__setitem__(0, 1.0),
        "later: 1 chunks of 5",
    ),
    "cut chunk": (_cut_chunk, "truncated or damaged"),
    "external": (_external("later"), "later: is virtual or external, allowed: values in the file"),
    "external axis": (
        lambda f: (f.__delitem__(SPEED), _external(SPEED)(f)),
        f"{SPEED}: is virtual or external",
    ),
    "virtual": (_virtual, "later: is virtual or external"),
    "lzf": (_stored(MEAN, compression="lzf"), f"{MEAN}: got filters .*, allowed: gzip, shuffle"),
    "scale and offset": (_stored(MEAN, scaleoffset=0), f"{MEAN}: got filters"),
    "fletcher": (_stored(MEAN, fletcher32=True, chunks=True), f"{MEAN}: got filters"),
    "complex values": (lambda f: f.create_dataset("x", data=[1j]), "x: got .*, allowed: numbers"),
    "flags": (lambda f: f.create_dataset("x", data=[True]), "x: got enumerations"),
    "many groups": (
        lambda f: [f.create_group(f"g{k}") for k in range(MOST_OBJECTS)],
        f"got more than {MOST_OBJECTS} datasets and groups",
    ),
    "newer groups": (lambda f: f.create_group("later", track_order=True), "truncated or damaged"),
    "links in a heap": (
        lambda f: [f.__setitem__(f"s{k}", h5py.ExternalLink("/dev/zero", "/x")) for k in range(9)],
        "more links than h5py writes by default",
    ),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_files_are_refused(case, file):
    change, reason = HOSTILE[case]
    _edit(file, change)
    with pytest.raises(TableError, match=reason) as refusal:
        read_table(file)
    assert str(refusal.value).startswith(str(file))
    assert "\n" not in str(refusal.value)


def test_files_of_newer_structures_are_refused(file, tmp_path):
    with h5py.File(file) as old, h5py.File(tmp_path / "new.h5", "w", libver="latest") as new:
        new.attrs.update(old.attrs)
    with pytest.raises(TableError, match=r"superblock version 3 .*, as h5py writes by default"):
        read_table(tmp_path / "new.h5")


@pytest.mark.parametrize("kind", ["far too long", "empty"])
def test_size_of_a_file(kind, tmp_path):
    path = tmp_path / "t.h5"
    with open(path, "wb") as opened:
        opened.truncate(0 if kind == "empty" else 2**31 + 1)  # which takes no room on a disk
    with pytest.raises(
        TableError, match="no HDF5 signature" if kind == "empty" else "of 2147483649 bytes"
    ):
        read_table(path)


#: What makes the HDF5 library loop for ever, or set aside 4 GiB: written over a file at a place.
HEAP_DAMAGES = {
    "object without a size": (0, bytes(16)),
    "object of nearly 2**64 bytes": (8, (2**64 - 16).to_bytes(8, "little")),
    "free space without a size": (0, b"\0\0"),
}

READ_ALL = """
import sys
from sampler.formats.hdf5 import read_table
for path in sys.argv[1:]:
    try:
        read_table(path)
    except ValueError as error:
        print(error)
"""


def test_damaged_texts_neither_hang_nor_take_memory(file, tmp_path):
    """Read by a process of their own, because where the defect is there is no end."""
    whole = file.read_bytes()
    heap = whole.index(b"GCOL")
    damages = {name: (heap + 16 + at, data) for name, (at, data) in HEAP_DAMAGES.items()}
    # the length of a text stands before the address of the heap
    reference = whole.index(heap.to_bytes(8, "little"), whole.index(b"config\0")) - 4
    damages["4 GiB of text"] = (reference, (2**32 - 10).to_bytes(4, "little"))
    paths = []
    for name, (at, data) in damages.items():
        paths.append(tmp_path / f"{name}.h5")
        paths[-1].write_bytes(whole[:at] + data + whole[at + len(data) :])
    command = [sys.executable, "-c", READ_ALL, *map(str, paths)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert [line.partition(": ")[0] for line in done.stdout.splitlines()] == list(map(str, paths))
    assert done.stdout.count("truncated or damaged? (text of an attribute)") == len(paths)


def test_a_chunk_of_two_places_is_refused(file):
    """Before it is unpacked: a file of a megabyte has room for a thousand times the same."""
    _edit(file, lambda f: f.create_dataset("later", data=np.arange(9.0), chunks=(2,)))
    whole = bytearray(file.read_bytes())
    # the keys of the B-tree: size and filters of a chunk, its place and 0, then its address
    second = next(
        at
        for at in range(len(whole) - 24)
        if whole[at : at + 24] == struct.pack("<IIQQ", 16, 0, 2, 0)
    )
    whole[second + 8] = 0
    file.write_bytes(whole)
    with pytest.raises(TableError, match=r"later, chunk at \[0\]"):
        read_table(file)


def test_overlapping_structures_are_read_only_so_often():
    image = Image(bytes(100))
    assert image.part(0, 100) == image.part(0, 100)
    with pytest.raises(TableError, match="truncated or damaged"):
        image.part(0, 1)


def test_structures_without_end_are_given_up():
    """An object header of a gigabyte of empty messages, and a B-tree that is its own child."""
    image = Image(bytes([1, *bytes(7), 0, 0, 0, 64, *bytes(12)]) + bytes(MOST_STRUCTURE))
    with pytest.raises(TableError, match="got more than 4194304 bytes of structures"):
        messages(image, 0)
    node = b"TREE" + bytes([1, 0, 1, 0, *bytes(16)]) + bytes(24) + bytes(8)
    assert list(tree(Image(node), 0, 1, 24)) == [(24, 0)]
    upper = node[:5] + b"\1" + node[6:]
    with pytest.raises(TableError, match="B-tree"):
        list(tree(Image(upper), 0, 1, 24))


def _equal_nodes(n_alpha, n_speed):
    """A valid table of which a small file comes, because all nodes are the same."""
    datasets = make_datasets()
    for path, values in datasets.items():
        if path.startswith(("marginals/quantiles", "dependence/")):
            same = np.asarray(values)[:1, :1]
            datasets[path] = np.broadcast_to(same, (n_alpha, n_speed, *same.shape[2:]))
    for name, nodes in (
        ("alpha", np.linspace(1.0, 90.0, n_alpha)),
        ("speed", np.linspace(50.0, 300.0, n_speed)),
    ):
        unit = "_deg" if name == "alpha" else ""
        datasets[f"axes/{name}{unit}"] = nodes
        datasets[f"axes/{name}_span{unit}"] = nodes[[0, -1]]
        datasets[f"axes/{name}_coordinate"] = np.linspace(0.0, nodes.size - 1.0, 2 * nodes.size)
    return make_contents(datasets)


def _refused(path):
    with pytest.raises(TableError):
        read_table(path)


def _peak(action):
    tracemalloc.start()
    try:
        action()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_is_bounded_by_the_size_of_the_file(tmp_path):
    """Every array of the reader is numpy's, or bytes of Python: tracemalloc sees them."""
    path = tmp_path / "t.h5"
    write_table(path, _equal_nodes(30, 90))
    size = path.stat().st_size
    held = sum(values.nbytes for values in read_table(path).datasets.values())
    assert held > 30 * size
    assert _peak(lambda: table_arrays(read_table(path))) < min(150e6 + 50 * size, 4.5 * held)


def test_tables_that_unpack_to_too_much_are_refused(tmp_path):
    path = tmp_path / "t.h5"
    write_table(path, _equal_nodes(60, 100))
    most = FREE_BYTES + MOST_EXPANSION * path.stat().st_size
    with pytest.raises(TableError, match=f"datasets: got .*, allowed: at most {most} in a file"):
        read_table(path)
    assert _peak(lambda: _refused(path)) < 3 * path.stat().st_size


def test_a_chunk_is_unpacked_only_as_far_as_its_size(file):
    _edit(file, _bomb)
    assert _peak(lambda: _refused(file)) < 2e6


def test_packing_takes_little_more_than_what_is_packed():
    quantiles = np.sort(np.random.default_rng(1).random((40, 20, 2, 3, 65), np.float32))
    packed = sum(part.nbytes for part in pack_quantiles(quantiles))
    assert _peak(lambda: pack_quantiles(quantiles)) < 1.5 * packed + 2e6


@pytest.mark.parametrize(
    ("lengths", "reason"),
    [
        # 2**31 16-bit steps, to which a draw counts in 32 bits
        (
            {"n_alpha": 2049, "n_speed": 1025, "n_classes": 1, "n_knots": 64},
            "quantiles: got 3221225472 entries in memory",
        ),
        ({"n_alpha": 2**16, "n_components": 512}, "cholesky: got 32212"),
        ({"n_components": 65537}, "n_components = 65537, allowed: at most 65536"),
        ({"n_knots": 65537}, "n_knots = 65537, allowed: at most 65536"),
        ({"n_alpha_grid": 2**24 + 1}, "n_alpha_grid = 16777217, allowed: at most 16777216"),
    ],
)
def test_tables_that_a_draw_cannot_count_through_are_refused(lengths, reason, contents):
    known = check_shapes({path: values.shape for path, values in contents.datasets.items()})
    sizes = known | lengths
    shapes = {d.path: tuple(sizes.get(dim, dim) for dim in d.dims) for d in DATASETS}
    with pytest.raises(TableError, match=reason):
        check_shapes(shapes)
