"""Tables are read where files cannot be locked, and other files are named as what they are."""

import os
import shutil
import subprocess
import sys

import pytest
from documents import ROOT

import sampler
from sampler.errors import TableError
from sampler.files import find_table

#: A preloaded library in which no file can be locked, as on some network file systems.
NO_LOCKS = r"""
#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <stdarg.h>
int flock(int file, int how) { (void)file; (void)how; errno = ENOLCK; return -1; }
int fcntl(int file, int what, ...) {
    extern int __fcntl(int, int, ...);
    va_list given; va_start(given, what); void *value = va_arg(given, void *); va_end(given);
    if (what == F_SETLK || what == F_SETLKW) { errno = ENOLCK; return -1; }
    return __fcntl(file, what, value);
}
"""

#: Holds an exclusive lock until its input ends.
HOLDER = """
import fcntl, sys
file = open(sys.argv[1], "rb+")
fcntl.flock(file, fcntl.LOCK_EX)
print("locked", flush=True)
sys.stdin.read()
"""

#: Runs a command that reads a table; all others read it by the same function.
COMMANDS = """
from sampler.cli import main

assert main("export t.h5 --output t.rbt".split()) == 0
"""


@pytest.fixture
def table(tmp_path):
    return shutil.copy(find_table("kharaz-2001"), tmp_path / "t.h5")


def check_commands(folder, **environment):
    roots = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    words = [sys.executable, "-c", COMMANDS]
    environment = os.environ | {"PYTHONPATH": roots} | environment
    ended = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True)
    assert "lock" not in ended.stderr, ended.stderr
    assert "damaged" not in ended.stderr, ended.stderr
    assert ended.returncode == 0, ended.stderr


def test_tables_are_read_while_another_process_locks_them(table):
    pytest.importorskip("fcntl")
    words = [sys.executable, "-c", HOLDER, str(table)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        assert holder.stdout.readline() == b"locked\n"
        sampler.load(table)
        check_commands(table.parent)


def test_tables_are_read_where_no_file_can_be_locked(table, tmp_path):
    compiler = shutil.which("gcc")
    if compiler is None or sys.platform != "linux":
        pytest.skip("needs gcc and Linux")
    source, library = tmp_path / "no_locks.c", tmp_path / "no_locks.so"
    source.write_text(NO_LOCKS)
    subprocess.run([compiler, "-shared", "-fPIC", source, "-o", library], check=True)
    check_commands(table.parent, LD_PRELOAD=str(library))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("x.toml", "[pair]\n", "is a configuration, not a table"),
        ("x.csv", "alpha_deg\n", "is a file of measurements, not a table"),
        ("x.h5", "words\n", "is no HDF5 file"),
        ("x.h5", "", "is empty"),
    ],
)
def test_other_files_are_named_as_what_they_are(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(TableError, match=message):
        sampler.load(path)


def test_files_that_may_not_be_read_are_not_called_damaged(table):
    table.chmod(0)
    if os.access(table, os.R_OK):
        pytest.skip("this user reads everything")
    with pytest.raises(TableError, match=r"cannot read .*: Permission denied"):
        sampler.load(table)
