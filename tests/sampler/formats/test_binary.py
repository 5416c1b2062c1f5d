"""Images of tables: what is written is read back, and everything else is refused."""

import hashlib

import numpy as np
import pytest
from synthetic_table import make_contents

import sampler
from sampler.errors import InputError, TableError
from sampler.files.locate import include_directory
from sampler.formats.binary import image_bytes, read_image, write_image
from sampler.formats.binary_layout import (
    ALIGNMENT,
    ARRAYS,
    HEADER_DTYPE,
    REASONS,
    field_offset,
    layout_text,
)

pytestmark = pytest.mark.processor


@pytest.fixture(scope="module")
def image(contents):
    return image_bytes(contents)


def assert_equal(a, b):
    """Equal arrays and numbers in nested tuples."""
    if isinstance(a, tuple):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            assert_equal(x, y)
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    else:
        assert a == b


def test_what_is_written_is_read(contents, table, tmp_path):
    path = tmp_path / "t.rbt"
    write_image(path, contents)
    read = read_image(path)
    assert_equal(read.arrays, table.arrays)
    assert read.pair == contents.pair
    assert read.content_sha256 == contents.content_sha256
    assert [p.name for p in tmp_path.iterdir()] == ["t.rbt"]


def test_equal_tables_give_equal_bytes(contents, image):
    assert image_bytes(contents) == image


def test_layout_of_the_file(image):
    header = np.frombuffer(image[: HEADER_DTYPE.itemsize], HEADER_DTYPE)[0]
    assert image[:8] == b"\x89RBT\r\n\x1a\n"
    assert header["file_bytes"] == len(image)
    assert all(header[f"at_{array.name}"] % ALIGNMENT == 0 for array in ARRAYS)
    at = field_offset("sha256")
    outside = image[:at] + image[at + 32 :]
    assert hashlib.sha256(outside).digest() == image[at : at + 32]


@pytest.mark.parametrize("pair", ["x" * 128, "ä" * 64, "a\0b"])
def test_a_name_that_does_not_fit(pair):
    with pytest.raises(InputError, match=r"^pair: got \d+ bytes, allowed: at most 127"):
        image_bytes(make_contents(pair=pair))


def test_the_longest_name(tmp_path):
    write_image(tmp_path / "t.rbt", make_contents(pair="ä" * 63))
    assert read_image(tmp_path / "t.rbt").pair == "ä" * 63


def test_every_flipped_bit_is_found(image, tmp_path):
    path = tmp_path / "t.rbt"
    for at in [*range(HEADER_DTYPE.itemsize), *range(400, len(image), 997)]:
        broken = bytearray(image)
        broken[at] ^= 1 << at % 8
        path.write_bytes(broken)
        with pytest.raises(TableError) as refused:
            read_image(path)
        reason = str(refused.value).removeprefix(f"{path}: ")
        allowed = expected_reason(at)
        assert reason == REASONS[allowed]


def expected_reason(at):
    """Code for a change of one byte of the file."""
    if at < field_offset("major"):
        return -14
    if at < field_offset("minor"):
        return -15
    first = field_offset("file_bytes")
    return -16 if first <= at < first + 8 else -17


@pytest.mark.parametrize("length", [0, 7, 8, 100, HEADER_DTYPE.itemsize, -1])
def test_truncated(image, tmp_path, length):
    path = tmp_path / "t.rbt"
    path.write_bytes(image[:length])
    with pytest.raises(TableError) as refused:
        read_image(path)
    assert str(refused.value) == f"{path}: {REASONS[-14 if 0 <= length < 8 else -16]}"


def test_no_file_and_a_folder(tmp_path):
    for path, code in ((tmp_path / "none.rbt", -10), (tmp_path, -11)):
        with pytest.raises(TableError) as refused:
            read_image(path)
        assert str(refused.value) == f"{path}: {REASONS[code]}"


def test_draws_from_an_image_are_those_of_the_table(contents, table, tmp_path):
    write_image(tmp_path / "t.rbt", contents)
    arrays = read_image(tmp_path / "t.rbt").arrays
    state = np.empty(6)
    for index in range(20):
        key = np.uint64(3), np.uint64(index), np.uint32(0)
        assert sampler.draw(arrays, 0.7, 99.0, *key, state) == 0
        np.testing.assert_array_equal(state, table.sample(0.7, 99.0, seed=3, index=index))


def test_the_page_lists_the_fields_of_the_description():
    page = include_directory() / "README.md"
    assert page.read_text(encoding="utf-8").endswith(layout_text())
