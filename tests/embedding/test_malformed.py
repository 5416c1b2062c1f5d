"""Malformed binary tables are refused, each for its reason; so is what is no file."""

import os

import numpy as np
import pytest
import toolchain
from known_vectors import VECTORS
from small_tables import full
from spin_tables import less_spheres, with_spin_law

from sampler.errors import CODES
from sampler.formats.binary_layout import (
    ALL_ARRAYS,
    FIRST_HEADER_BYTES,
    HEADER_DTYPE,
    field_offset,
)
from sampler.formats.image import checksum, header_of, table_image

GOOD = (VECTORS / "full.rbt").read_bytes()
#: The same with a spin law: two shapes, the second a mesh, with four nodes and five leaves each.
SPINNING = table_image(with_spin_law(full(), codes=(1, 6))).tobytes()
#: And with outcomes less those of spheres.
LESS_SPHERES = table_image(less_spheres(with_spin_law(full(), codes=(0,)))).tobytes()
DTYPES = {array.name: np.dtype(array.dtype) for array in ALL_ARRAYS}


def field(name, value):
    """Change a header field."""

    def change(data):
        data[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)[name] = value
        return data

    return change


def number(name, at, value):
    """Change one number of an array; `at` counts from its begin."""

    def change(data):
        dtype = DTYPES[name]
        start = int(header_of(data)[f"at_{name}"]) + at * dtype.itemsize
        data[start : start + dtype.itemsize] = np.array([value], dtype).view(np.uint8)
        return data

    return change


def cut(length):
    return lambda data: data[:length].copy()


def components_to_the_end(data):
    """Leave room for the records, each a cache line, but not for the zeros behind them."""
    data = np.concatenate([data, np.zeros(-data.size % 64, np.uint8)])
    header = data[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)
    records = header["n_alpha"] * header["n_speed"] * header["n_components"]
    header["file_bytes"], header["at_components"] = data.size, data.size - 64 * records
    return data


#: Changes by the code that they are refused with.
MALFORMED = {
    -14: [cut(0), field("magic", b"\x89RBT\n\x1a\n\0")],
    -15: [field("major", 2)],
    -16: [cut(100), cut(-1), field("header_bytes", 431), field("file_bytes", len(GOOD) + 64)],
    -18: [field("n_alpha", 0), field("n_components", 2**32 - 1), field("stride", 64)],
    -19: [
        field("pair", b"\x1b[2Jgold"),
        field("channels", [0, 1, 1, 2, 3, 4, -1, -1]),
        field("columns", [0, 1, 2, 3, 4, 7, -1, -1]),  # without its channels
    ],
    -20: [field("at_alias", 64), field("at_quantiles", 2**64 - 64), components_to_the_end],
    -21: [
        field("least_inertia", 0.7),
        field("least_inertia", np.nan),
        field("alpha_first", np.nan),
        field("speed_last", 1.0),
        field("variate_max", 2e6),
    ],
    -22: [field("alpha_offset", 1), number("speed_coordinate", 3, 0.0)],
    -23: [number("normals", 1000, np.nan)],
    -24: [number("alias", 44, 5)],
    -25: [number("first_of_class", 1, 6)],
    -26: [number("components", 32, 4097), number("components", 7, 0)],
    -27: [number("spans", 0, np.nan), number("spans", 5, -1.0)],
    -28: [number("quantiles", 4, 65535)],
}
MALFORMED_SPIN = {
    -16: [cut(FIRST_HEADER_BYTES)],
    -18: [field("n_leaves", 0), field("n_shapes", 1025)],
    -20: [field("at_experts", 448), field("at_shape_inertia", 64), field("n_nodes", 2**20)],
    -21: [
        field("spin_alpha", [1.0, 0.5]),
        field("valid_speed", [10.0, np.nan]),
        field("spin_size", [2, 1]),
    ],
    -27: [number("spin_spans", 8, -2e6), number("spin_quantiles", 34, 0)],
    -28: [number("spin_quantiles", 2, 65535)],
    -29: [
        number("shape_codes", 0, -1),
        number("shape_shares", 1, 0.9),
        number("shape_inertia", 3, 0.0),
    ],
    -30: [number("roots", 1, 8), number("node_cut", 3, 2e3), number("node_child", 2, 1)],
    -31: [number("inputs", 6, np.nan), number("experts", 138, 0)],
}
MALFORMED_LAWS = {
    -18: [
        number("laws", 0, 0.0),
        number("laws", 2, np.nan),
        number("laws", 1, 4),
        field("n_laws", 7),
    ],
    -20: [field("at_laws", 448), field("n_laws", 2**20)],
    -27: [number("spin_spans", 2, np.nan)],
}
GOODS = (GOOD, MALFORMED), (SPINNING, MALFORMED_SPIN), (LESS_SPHERES, MALFORMED_LAWS)
CASES = [
    (good, change, code) for good, changes in GOODS for code in changes for change in changes[code]
]


def written(path, good, change, code):
    """Write a malformed table, with a checksum that is right unless the size is the matter."""
    data = change(np.frombuffer(good, np.uint8).copy())
    if code not in (-14, -16, -17):
        at = field_offset("sha256")
        data[at : at + 32] = np.frombuffer(checksum(data), np.uint8)
    path.write_bytes(data.tobytes())


@pytest.mark.parametrize(("good", "change", "code"), CASES)
def test_the_reason(good, change, code, library, tmp_path):
    written(tmp_path / "t.rbt", good, change, code)
    found, table = toolchain.open_code(library, tmp_path / "t.rbt")
    assert (found, table.value) == (code, None)


@pytest.mark.parametrize("good", [GOOD, SPINNING])
def test_the_good_one(library, good, tmp_path):
    written(tmp_path / "t.rbt", good, lambda data: data, 0)
    with toolchain.opened(library, tmp_path / "t.rbt"):
        pass


def test_every_reason_of_the_contents_is_met():
    contents = {code.number for code in CODES if code.number <= -14}
    assert {code for _, _, code in CASES} | {-17, -32} == contents  # -17 below, -32 is of draws


def test_what_is_no_regular_file(library, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert toolchain.open_code(library, tmp_path / "none")[0] == -10
    for path in (tmp_path, tmp_path / "pipe"):  # which would wait for ever
        code, table = toolchain.open_code(library, path)
        assert (code, table.value) == (-11, None)


def test_flipped_bits(library, tmp_path):
    path, size = tmp_path / "t.rbt", field_offset("file_bytes")
    for at in [*range(HEADER_DTYPE.itemsize), *range(HEADER_DTYPE.itemsize, len(GOOD), 623)]:
        data = bytearray(GOOD)
        data[at] ^= 1 << at % 8
        path.write_bytes(data)
        expected = -14 if at < field_offset("major") else -15 if at < field_offset("minor") else -17
        expected = -16 if size <= at < size + 8 else expected
        of_header = at - field_offset("header_bytes") in range(4)  # may be shorter than the least
        found = toolchain.open_code(library, path)[0]
        assert found == expected or (of_header and found == -16), at
