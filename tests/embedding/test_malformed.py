"""Malformed binary tables are refused, each for its reason."""

from pathlib import Path

import numpy as np
import pytest
import toolchain
from malformed import MALFORMED, MALFORMED_SPIN, keep, make
from sampler.formats.image import binary_table
from small_tables import full
from special_files import KINDS, make_special
from spin_tables import with_spin_law

from sampler.formats.binary_layout import CODES, HEADER_DTYPE, field_offset

GOOD = (Path(__file__).resolve().parents[1] / "vectors" / "full.rbt").read_bytes()


#: The same table with a spin law.
SPINNING = binary_table(with_spin_law(full(), codes=(1, 6)))


@pytest.fixture(scope="module")
def reading_library(tmp_path_factory):
    """The functions of the header without memory maps."""
    return toolchain.header_library(
        tmp_path_factory.mktemp("reading"), ["-O2", "-DRBT_NO_MMAP", toolchain.ONE_COPY]
    )


CASES = [(GOOD, *case) for case in MALFORMED] + [(SPINNING, *case) for case in MALFORMED_SPIN]


@pytest.mark.parametrize(
    ("good", "change", "code", "repair"),
    [(case[0], *case[2:]) for case in CASES],
    ids=[f"{case[1]}{' (spin)' if case[0] is SPINNING else ''}" for case in CASES],
)
def test_the_reason(good, change, code, repair, library, reading_library, tmp_path):
    path = tmp_path / "t.rbt"
    path.write_bytes(make(good, change, repair))
    for each in (library, reading_library):
        got, table = toolchain.open_code(each, path)
        assert (got, table.value) == (code, None)


@pytest.mark.parametrize("good", [GOOD, SPINNING], ids=["no spin", "spin"])
def test_the_good_one(library, good, tmp_path):
    path = tmp_path / "t.rbt"
    path.write_bytes(make(good, keep, True))
    assert path.read_bytes() == good
    with toolchain.opened(library, path):
        pass


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_regular_file(library, reading_library, tmp_path, kind):
    path, _ = make_special(tmp_path, kind)
    for each in (library, reading_library):
        assert toolchain.open_code(each, tmp_path / "none")[0] == -10
        code, table = toolchain.open_code(each, path)  # a pipe would wait for ever
        assert (code, table.value) in ((-11, None), (-10, None))
        assert code == -11 or kind == "socket"  # which cannot be opened either


def test_a_table_that_was_read_is_not_the_file(reading_library, tmp_path):
    """What is allowed without memory maps only: overwritten in place, and cut short."""
    path = tmp_path / "t.rbt"
    path.write_bytes(GOOD)
    alpha1, speed, index, hit = toolchain.random_conditions(100)
    states, report = np.zeros((2, 100, 6)), toolchain.Report()
    with toolchain.opened(reading_library, path) as table:
        for each in states:
            given = alpha1, speed, None, 5, index, hit, each, report
            assert reading_library.rbt_draw_batch(table, 100, *given) >= 0
            path.write_bytes(bytes(100))
    np.testing.assert_array_equal(*states)
    assert states.any(axis=-1).all()


def test_memory_that_is_not_aligned(library):
    table = toolchain.ctypes.c_void_p()
    data = np.zeros(len(GOOD) + 128, np.uint8)
    start = -data.ctypes.data % 64
    for shift, code in ((0, 0), (8, -20)):
        place = data[start + shift : start + shift + len(GOOD)]
        place[:] = np.frombuffer(GOOD, np.uint8)
        got = library.rbt_open_memory(place.ctypes.data, len(GOOD), toolchain.ctypes.byref(table))
        assert got == code
        library.rbt_close(table)


def test_every_reason_of_the_contents_is_met():
    assert {case[3] for case in CASES} == {code.number for code in CODES if code.number <= -14}


def code_of_a_changed_byte(at):
    """Code for a change of one byte of the file."""
    if at < field_offset("major"):
        return -14
    if at < field_offset("minor"):
        return -15
    first = field_offset("file_bytes")
    return -16 if first <= at < first + 8 else -17


def test_flipped_bits(library, tmp_path):
    path = tmp_path / "t.rbt"
    for at in [*range(HEADER_DTYPE.itemsize), *range(HEADER_DTYPE.itemsize, len(GOOD), 623)]:
        data = bytearray(GOOD)
        data[at] ^= 1 << at % 8
        path.write_bytes(data)
        assert toolchain.open_code(library, path)[0] == code_of_a_changed_byte(at), at


@pytest.mark.parametrize("length", [0, 7, 8, 100, HEADER_DTYPE.itemsize, -1])
def test_truncated(library, tmp_path, length):
    path = tmp_path / "t.rbt"
    path.write_bytes(GOOD[:length])
    assert toolchain.open_code(library, path)[0] == (-14 if 0 <= length < 8 else -16)
