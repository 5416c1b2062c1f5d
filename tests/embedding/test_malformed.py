"""Malformed binary tables are refused, each for its reason; so is what is no file."""

import ctypes
import os

import numpy as np
import pytest
import toolchain
from known_vectors import VECTORS
from spin_tables import LAWS, with_spin_law
from synthetic_table import make_contents

from sampler.errors import CODES
from sampler.files import find_table
from sampler.formats.binary_layout import ARRAYS, HEADER_DTYPE, field_offset
from sampler.formats.hdf5 import read_table
from sampler.formats.image import checksum, header_of, table_image

#: A good image of each kind of table: two shapes, the second a mesh, and tables among the laws.
GOOD = {
    "nodes": table_image(make_contents()),
    "spin": table_image(with_spin_law(make_contents(), codes=(1, 64))),
    "by sphere": table_image(with_spin_law(make_contents(), codes=(0, 1), laws=LAWS)),
    "spheres": table_image(read_table(find_table("kharaz-2001"))),
}
STORED = {array.name: array for array in ARRAYS}
MANY = 2**32 - 1


def field(name, value):

    def change(data):
        header_of(data)[name] = value
        return data

    return change


def number(name, at, value):
    """Change one number of an array; `at` counts from its begin."""

    def change(data):
        dtype = np.dtype(STORED[name].dtype)
        start = int(header_of(data)[f"at_{name}"]) + at * dtype.itemsize
        data[start : start + dtype.itemsize] = np.array([value], dtype).view(np.uint8)
        return data

    return change


def cut(length):
    return lambda data: data[:length].copy()


def components_to_the_end(data):
    """Leave room for the records, each a cache line, but not for the zeros behind them."""
    data = np.concatenate([data, np.zeros(-data.size % 64, np.uint8)])
    header = header_of(data)
    records = header["n_alpha"] * header["n_speed"] * header["n_components"]
    header["file_bytes"], header["at_components"] = data.size, data.size - 64 * records
    return data


#: Changes by the table and by the code that they are refused with.
MALFORMED = {
    ("nodes", -19): [cut(0), field("magic", b"\x89RBT\n\x1a\n\0")],
    ("nodes", -20): [
        *(field("major", version) for version in (0, 2, 5)),
        field("header_bytes", HEADER_DTYPE.itemsize - 1),
        lambda data: field("major", 4)(data)[:432].copy(),
    ],
    ("nodes", -21): [cut(10), cut(-1), field("header_bytes", MANY), field("file_bytes", 2**20)],
    ("nodes", -23): [
        *(field(f"n_{name}", n) for name in ("alpha", "knots", "channels") for n in (0, MANY)),
        *(field(name, 64) for name in ("stride", "n_law_parameters")),
        *(field(name, 1) for name in ("n_shapes", "n_leaves", "n_outcomes")),
    ],
    ("nodes", -24): [
        field("channels", [0, 1, 1, 2, 3, 4, -1, -1]),
        field("marginals", [0, 1, 2, 3, 4, 6, -1, -1]),
        field("columns", [0, 1, 2, 3, 4, 10, -1, -1]),
    ],
    ("nodes", -25): [components_to_the_end, field("n_alpha", 60_000)],
    ("nodes", -26): [
        *(field(f"{axis}_offset", n) for axis in ("alpha", "speed") for n in (-1, 2_000_000)),
        *(number(f"{axis}_coordinate", 3, x) for axis in ("alpha", "speed") for x in (-1, 2e6)),
        number("alpha_coordinate", 100, np.nan),
        *(number("alias", 44, n) for n in (5, 0xFFFF)),
        number("first_of_class", 17, 6),
    ],
    # a spin law of another number of features or experts is one of another version
    ("spin", -20): [field(name, n) for name in ("n_features", "n_experts") for n in (0, 55, MANY)],
    ("spin", -23): [
        *(field(f"n_{name}", n) for name in ("shapes", "nodes", "spin_knots") for n in (0, MANY)),
        *(field("n_outcomes", n) for n in (0, 6, 9)),
        *(field("n_leaves", n) for n in (0, MANY)),
        field("n_law_parameters", 7),
    ],
    ("spin", -25): [field("n_nodes", 2**20), field("n_outcomes", 8), field("n_law_parameters", 64)],
    ("spin", -26): [
        *(number("roots", 1, n) for n in (-1, 8)),
        *(number("node_axis", 7, n) for n in (-1, 10)),
        *(number("node_child", at, n) for at, n in ((2, 1), (3, 0), (15, 8), (0, -11), (14, -11))),
    ],
    # of laws beside a spin law both are tables
    ("by sphere", -26): [
        *(number("laws", at, x) for at, x in ((1, 2.0), (4, 1.0), (7, 12.0), (8, 0.5))),
    ],
    ("spheres", -23): [
        field("n_shapes", 0),
        *(field("n_law_parameters", n) for n in (0, 7, 2**21)),
        *(field(name, 2) for name in ("n_alpha", "n_alpha_grid", "n_leaves", "n_nodes")),
        field("flags", 1),
    ],
    ("spheres", -24): [field("columns", [-1] * 8), field("channels", [0, *[-1] * 7])],
    ("spheres", -25): [field("n_law_parameters", 2**20)],
    ("spheres", -26): [
        *(number("laws", at, x) for at, x in ((1, 4.0), (1, 5.0), (4, -1.0))),
        *(number("laws", 7, x) for x in (1.0, 90.0, np.nan)),
        *(number("laws", 8, n) for n in (0.0, 4.0, 2.5, np.inf)),
    ],
}
CASES = [(kind, change, code) for (kind, code), changes in MALFORMED.items() for change in changes]


def refusal(library, path, kind, change, summed=True):
    """Code of opening a table with a change, and with a checksum that is right."""
    data = change(GOOD[kind].copy())
    if summed:
        at = field_offset("sha256")
        data[at : at + 32] = np.frombuffer(checksum(data), np.uint8)
    path.write_bytes(data.tobytes())
    code, table = toolchain.open_code(library, path)
    assert (code == 0) == (table.value is not None)
    library.rbt_close(table)
    return code


@pytest.mark.parametrize(("kind", "change", "code"), CASES)
def test_the_reason(kind, change, code, library, tmp_path):
    assert refusal(library, tmp_path / "t.rbt", kind, change, code not in (-19, -21)) == code


@pytest.mark.parametrize("kind", GOOD)
def test_every_offset(kind, library, tmp_path):
    """No array of any kind of table is read through an offset that was not looked at."""
    path, good = tmp_path / "t.rbt", header_of(GOOD[kind])
    assert refusal(library, path, kind, lambda data: data) == 0
    end = -(-GOOD[kind].size // 64) * 64
    for array in ARRAYS:
        name = f"at_{array.name}"
        assert (good[name] > 0) == (good[array.count] > 0)
        for at in (0, 64, int(good[name]) + 8, end, 2**40, 2**64 - 64):
            code = refusal(library, path, kind, field(name, at))
            assert code == (-25 if good[array.count] else 0), (name, at)


def test_every_reason_of_the_contents_is_met():
    contents = {code.number for code in CODES if code.number <= -19}
    assert {code for _, _, code in CASES} | {-22} == contents  # -22 below


def test_what_is_no_regular_file(library, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert toolchain.open_code(library, tmp_path / "none")[0] == -15
    for path in (tmp_path, tmp_path / "pipe"):  # which would wait for ever
        code, table = toolchain.open_code(library, path)
        assert (code, table.value) == (-16, None)


def test_what_is_missing(library):
    table = ctypes.c_void_p(1)
    assert library.rbt_open(None, ctypes.byref(table)) == -1
    assert library.rbt_open_memory(None, 100, ctypes.byref(table)) == -1
    assert table.value is None
    assert library.rbt_open(str(VECTORS / "full.rbt").encode(), None) == -1
    assert library.rbt_open_memory(GOOD["nodes"].ctypes.data, GOOD["nodes"].size, None) == -1


def test_flipped_bits(library, tmp_path):
    path, good = tmp_path / "t.rbt", (VECTORS / "full.rbt").read_bytes()
    places = {name: field_offset(name) for name in ("major", "minor", "header_bytes", "sha256")}
    for at in [*range(HEADER_DTYPE.itemsize), *range(HEADER_DTYPE.itemsize, len(good), 623)]:
        data = bytearray(good)
        data[at] ^= 1 << at % 8
        path.write_bytes(data)
        expected = -19 if at < places["major"] else -20 if at < places["minor"] else -22
        expected = -21 if field_offset("file_bytes") <= at < places["sha256"] else expected
        if at - places["header_bytes"] in range(4):
            size = int(header_of(np.frombuffer(data, np.uint8))["header_bytes"])
            expected = -20 if size < HEADER_DTYPE.itemsize else -21 if size > len(good) else -22
        assert toolchain.open_code(library, path)[0] == expected, at
