"""Files by name, and outputs that are written whole or not at all."""

import errno
import json
import os
import socket
import stat
import subprocess
import sys

import numpy as np
import pytest
from refusals import refused

from sampler.errors import InputError
from sampler.files import (
    atomic_output,
    check_output,
    commented_fields,
    find_file,
    find_table,
    json_text,
    read_file,
    write_arrays,
    write_text,
)


def test_a_name_comes_before_a_file_of_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "corundum-steel").write_text("")
    (tmp_path / "other").write_text("")
    assert find_table("corundum-steel").suffix == ".h5"
    assert find_table("./corundum-steel").resolve() == tmp_path / "corundum-steel"
    assert find_table("other").name == "other"


def test_missing_files_are_refused_in_one_line():
    for given in ("quartz", "none.h5", "."):
        refused("table", find_file, "table", given, ".h5")
    refused("mesh", read_file, "mesh", "none")


@pytest.mark.parametrize("given", [None, 3, ["corundum-steel"]])
def test_what_is_no_name_is_refused(given):
    line = refused("table", find_table, given)
    assert line == f"table: got {type(given).__name__}, allowed: a name, or the path of a .h5 file"


def fill_the_disk(path):
    with atomic_output(path) as temporary:
        temporary.write_text("half")
        raise OSError(28, "No space left on device")


def test_a_failed_write_leaves_the_older_file_and_nothing_else(tmp_path):
    path = tmp_path / "a.txt"
    write_text(path, "older")
    path.chmod(0o640)
    with pytest.raises(InputError, match=r"cannot write .*a\.txt: No space"):
        fill_the_disk(path)
    assert path.read_text() == "older"
    write_text(path, "newer")
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("newer", 0o640)
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_a_link_stays_and_its_file_is_replaced(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_text(tmp_path / "link", "text")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "text"


def no_links(*_):
    raise OSError(errno.EPERM, "no hard links here")


@pytest.mark.parametrize("links", [True, False])
def test_a_file_that_appeared_since_the_check_is_kept_once(tmp_path, monkeypatch, links):
    if not links:
        monkeypatch.setattr("os.link", no_links)
    path = tmp_path / "a.txt"
    check_output(path)
    write_text(path, "ours")
    write_text(path, "ours again")
    assert path.read_text() == "ours again"
    path.unlink()
    check_output(path)
    path.write_text("of another program")
    for use in (check_output, lambda path: write_text(path, "ours")):
        with pytest.raises(InputError, match="has appeared since this output was checked"):
            use(path)
        assert path.read_text() == "of another program"
        path.unlink()
        check_output(path)
        path.write_text("of another program")
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_an_output_that_was_there_at_the_check_is_replaced(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("older")
    check_output(path)
    write_text(path, "newer")
    assert path.read_text() == "newer"


@pytest.mark.parametrize("name", ["x" * 300, "a\0b"])
def test_names_that_no_file_can_have_are_refused_before_any_work(tmp_path, name):
    with pytest.raises(InputError, match=r"^output: cannot write [^\n]*(too long|null)"):
        check_output(tmp_path / name)


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        ("none/a", "cannot write none/a: there is no folder .*none"),
        (".", ". is a folder; give a file name"),
    ],
)
def test_outputs_that_cannot_be_are_refused_before_any_work(path, sentence):
    with pytest.raises(InputError, match=sentence):
        write_text(path, "text")


@pytest.mark.parametrize("name", ["folder/", "file/", "file/."])
def test_a_name_that_ends_in_a_folder_is_no_file(tmp_path, name):
    with pytest.raises(InputError, match="is a folder; give a file name"):
        check_output(f"{tmp_path}/{name}")


def test_a_folder_that_takes_no_file_is_refused_before_any_work():
    """Its permissions let the owner of the machine write into it."""
    with pytest.raises(InputError, match=r"^output: cannot write /proc/a.txt: "):
        check_output("/proc/a.txt")


def test_what_is_no_regular_file_is_written_into(tmp_path):
    pipe = tmp_path / "pipe.json"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    check_output(pipe)
    write_text(pipe, "all of it")
    assert os.read(reader, 100) == b"all of it"
    os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    write_text("/dev/null", "nobody reads it")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    with pytest.raises(InputError, match="cannot write /dev/full: No space left on device"):
        write_text("/dev/full", "text")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "socket"))
        with pytest.raises(InputError, match="is a disk or a socket"):
            check_output(tmp_path / "socket")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["pipe.json", "socket"]


def test_the_file_of_standard_output_is_written_into(tmp_path):
    """Replaced, it would lose what is printed after it."""
    path = tmp_path / "all.txt"
    script = f"from sampler.files import *; print(1); write_text({str(path)!r}, '2\\n'); print(3)"
    with open(path, "w") as output:
        subprocess.run([sys.executable, "-c", script], stdout=output, check=True)
    assert path.read_text() == "1\n2\n3\n"


def test_numbers_that_are_none_are_not_written(tmp_path):
    with pytest.raises(ValueError, match="state: holds a number that is not finite"):
        write_arrays(tmp_path / "a.npz", state=np.array([1.0, np.nan]))
    with pytest.raises(ValueError, match="JSON"):
        json_text({"x": np.inf})
    assert json.loads(json_text({"x": [1, 2.5]})) == {"x": [1, 2.5]}
    assert list(tmp_path.iterdir()) == []


def test_fields_at_the_top_of_a_file():
    text = "# title: A, B\n#\n# title: again\n# wall:  steel \nangle,e_n\n# later: x\n"
    assert commented_fields(text) == {"title": "A, B", "wall": "steel"}
