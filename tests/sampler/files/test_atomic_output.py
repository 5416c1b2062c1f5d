"""Outputs appear whole or not at all."""

import os
import stat
from pathlib import Path

import pytest
from special_files import KINDS, make_special

from sampler import InputError
from sampler.files import atomic_output, check_output, write_text


def test_moved_into_place_at_the_end(tmp_path):
    target = tmp_path / "out.txt"
    with atomic_output(target) as temporary:
        temporary.write_text("whole")
        assert not target.exists()
        assert temporary.parent == target.parent
    assert target.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_nothing_left_after_a_failure(tmp_path, error):
    target = tmp_path / "out.txt"
    target.write_text("earlier")

    def fail():
        with atomic_output(target) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        fail()
    assert target.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [target]


def test_failure_to_write_is_one_line(tmp_path):
    with (
        pytest.raises(InputError, match=r"output: cannot write .*: File name too long"),
        atomic_output(tmp_path / ("n" * 400)) as temporary,
    ):
        temporary.write_text("half")
    assert not list(tmp_path.iterdir())


def test_paths_that_cannot_work(tmp_path):
    with pytest.raises(InputError, match="a folder, allowed: a regular file"):
        check_output(tmp_path)
    with pytest.raises(InputError, match="allowed: a file in a folder that exists"):
        check_output(tmp_path / "none" / "out.npz")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="allowed: a file in a folder that exists"):
        check_output(tmp_path / "file" / "out.npz")


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_regular_file_stays(tmp_path, kind):
    path, word = make_special(tmp_path, kind)
    before = os.stat(path)
    with (
        pytest.raises(InputError, match=f"output: got {path}, a {word}, allowed: a regular file"),
        atomic_output(path) as temporary,
    ):
        temporary.write_text("whole")
    assert os.stat(path) == before


def test_standard_output_is_no_file():
    for name in ("-", "./-"):
        with pytest.raises(InputError, match="output: got -, allowed: a file name"):
            check_output(name)
    read, write = os.pipe()
    with pytest.raises(InputError, match="a pipe, allowed: a regular file"):
        check_output(f"/dev/fd/{write}")
    os.close(read)
    os.close(write)


def test_links_are_followed(tmp_path):
    target, folder = tmp_path / "target.txt", tmp_path / "folder"
    folder.mkdir()
    for k, link in enumerate((tmp_path / "link", folder / "link")):
        link.symlink_to(target)  # the first time it leads to nothing yet
        write_text(link, f"text {k}")
        assert link.is_symlink()
        assert target.read_text() == f"text {k}"
    assert list(folder.iterdir()) == [folder / "link"]
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InputError, match=r"cannot write .*loop: Too many levels"):
        check_output(tmp_path / "loop")
    (tmp_path / "lost").symlink_to("none/there")
    with pytest.raises(InputError, match="allowed: a file in a folder that exists"):
        check_output(tmp_path / "lost")


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_mode_is_kept(tmp_path, mode):
    path = tmp_path / "out.txt"
    path.write_text("earlier")
    path.chmod(mode)
    with atomic_output(path) as temporary:
        assert stat.S_IMODE(temporary.stat().st_mode) & ~mode == 0
        temporary.write_text("later")
    assert path.read_text() == "later"
    assert stat.S_IMODE(path.stat().st_mode) == mode


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_new_files_follow_the_mask(tmp_path, mask):
    before = os.umask(mask)
    try:
        write_text(tmp_path / "out.txt", "whole")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "out.txt").stat().st_mode) == 0o666 & ~mask


@pytest.mark.skipif(os.geteuid() != 0, reason="only the superuser gives files away")
def test_owner_is_kept(tmp_path):
    path = tmp_path / "out.txt"
    path.write_text("earlier")
    os.chown(path, 12345, 54321)
    write_text(path, "later")
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 54321)


def test_write_protected_files_stay(tmp_path, monkeypatch):
    path = tmp_path / "out.txt"
    path.write_text("earlier")
    # as for a user who may write to the folder and not to the file; the superuser may always
    monkeypatch.setattr(os, "access", lambda place, _: Path(place) != path)
    with pytest.raises(InputError, match="allowed: a file that can be written"):
        check_output(path)


def test_what_is_read_is_not_written(tmp_path, monkeypatch):
    table, new = tmp_path / "t.h5", tmp_path / "new.h5"
    table.write_text("table")
    (tmp_path / "link").symlink_to("t.h5")
    os.link(table, tmp_path / "other-name")
    (tmp_path / "f").mkdir()
    monkeypatch.chdir(tmp_path)
    for name in (table, "t.h5", "./f/../t.h5", "link", "other-name"):
        with pytest.raises(InputError, match="which is also read, allowed: another file"):
            check_output(name, [new, table])
    check_output(new, [table, tmp_path / "none" / "there", "a\0b"])
    with pytest.raises(InputError, match="which is also read"):
        check_output("f/../new.h5", [new])  # neither is there yet
