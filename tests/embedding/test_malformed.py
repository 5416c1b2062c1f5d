"""Malformed images are refused by Python and by C, with the same reason."""

from pathlib import Path

import numpy as np
import pytest
import toolchain
from malformed import MALFORMED, keep, make

from sampler.errors import TableError
from sampler.formats.binary import read_image
from sampler.formats.binary_layout import REASONS

GOOD = (Path(__file__).resolve().parents[1] / "vectors" / "full.rbt").read_bytes()


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    source = tmp_path_factory.mktemp("library") / "library.c"
    source.write_text('#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n')
    return toolchain.load_library(source, ["-O2"])


@pytest.fixture(scope="module")
def reading_library(tmp_path_factory):
    """The same without memory maps."""
    source = tmp_path_factory.mktemp("reading") / "library.c"
    source.write_text('#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n')
    return toolchain.load_library(source, ["-O2", "-DRBT_NO_MMAP"])


def python_reason(path):
    with pytest.raises(TableError) as refused:
        read_image(path)
    return str(refused.value).removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("change", "code", "repair"), [case[1:] for case in MALFORMED], ids=[c[0] for c in MALFORMED]
)
def test_the_reason(change, code, repair, library, reading_library, tmp_path):
    path = tmp_path / "t.rbt"
    path.write_bytes(make(GOOD, change, repair))
    assert python_reason(path) == REASONS[code]
    for each in (library, reading_library):
        got, table = toolchain.open_code(each, path)
        assert (got, table.value) == (code, None)


def test_the_good_one(library, tmp_path):
    path = tmp_path / "t.rbt"
    path.write_bytes(make(GOOD, keep, True))
    assert path.read_bytes() == GOOD
    read_image(path)
    with toolchain.opened(library, path):
        pass


def test_no_file_and_a_folder(library, tmp_path):
    assert toolchain.open_code(library, tmp_path / "none")[0] == -10
    assert toolchain.open_code(library, tmp_path)[0] == -11


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
    assert {case[2] for case in MALFORMED} == {code for code in REASONS if code <= -14}


@pytest.mark.parametrize("bit", range(0, 8 * len(GOOD), 4999))
def test_flipped_bits(bit, library, tmp_path):
    data = bytearray(GOOD)
    data[bit // 8] ^= 1 << bit % 8
    path = tmp_path / "t.rbt"
    path.write_bytes(data)
    code, _ = toolchain.open_code(library, path)
    assert code < 0
    assert python_reason(path) == REASONS[code]
