"""Inputs are regular files of bounded size; nothing waits for anything else."""

import os
import re

import pytest
from special_files import KINDS, make_special

import sampler
from sampler import InputError
from sampler.errors import TableError
from sampler.files import check_input, read_file, reading


def test_regular_files(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"four")
    (tmp_path / "link").symlink_to(path)
    assert check_input("file", path) == path
    assert read_file("file", path) == read_file("file", str(tmp_path / "link"), most=4) == b"four"
    with pytest.raises(InputError, match=r"file: got .*a.txt of 4 bytes, allowed: up to 3"):
        read_file("file", path, most=3)


def test_a_large_file_is_not_read(tmp_path):
    path = tmp_path / "sparse"
    with open(path, "wb") as file:
        file.truncate(2**36)
    with pytest.raises(
        InputError, match=f"sparse of {2**36} bytes, allowed: up to {reading.MOST_BYTES}"
    ):
        read_file("file", path)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_regular_file(tmp_path, kind):
    path, word = make_special(tmp_path, kind)
    line = re.escape(f"file: got {path}, a {word}, allowed: a regular file")
    for work in (check_input, read_file):
        with pytest.raises(InputError, match=line):
            work("file", path)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("none", "none, allowed: a file that exists"),
        ("file/in", "in, allowed: a file that exists"),
        ("loop", r"loop, which cannot be read \(Too many levels of symbolic links\)"),
        ("n" * 400, r"n, which cannot be read \(File name too long\)"),
        ("a\0b", r"which cannot be read \(embedded null byte\)"),
        ("secret", r"secret, which cannot be read \(Permission denied\), allowed: a file that can"),
    ],
)
def test_reasons(tmp_path, monkeypatch, name, reason):
    (tmp_path / "file").write_text("")
    (tmp_path / "secret").write_text("")
    (tmp_path / "loop").symlink_to("loop")
    # the superuser may read everything
    monkeypatch.setattr(os, "access", lambda place, _: place != tmp_path / "secret")
    with pytest.raises(InputError, match=reason):
        read_file("file", tmp_path / name)


def test_a_pipe_in_place_of_a_checked_file_is_not_waited_for(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.setattr(reading, "check_input", lambda what, path: path)
    with pytest.raises(InputError, match="pipe, a pipe, allowed: a regular file"):
        read_file("file", tmp_path / "pipe")


@pytest.mark.parametrize("size", [3, 5])
def test_files_that_are_written_meanwhile(tmp_path, monkeypatch, size):
    path = tmp_path / "log.txt"
    path.write_bytes(b"four")
    said = os.stat_result((0o100600, *[0] * 5, size, *[0] * 3))
    monkeypatch.setattr(os, "fstat", lambda _: said)
    with pytest.raises(InputError, match="of another size than it says, allowed: a file at rest"):
        read_file("file", path)


@pytest.mark.parametrize("kind", KINDS)
def test_no_table(tmp_path, kind):
    path, word = make_special(tmp_path, kind)
    with pytest.raises(InputError, match=f"table: got {path}, a {word}, allowed: a .h5 file"):
        sampler.load(path)
    with pytest.raises(TableError, match=f"table: got {path}, a {word}, allowed: a regular file"):
        sampler.read_table(path)
