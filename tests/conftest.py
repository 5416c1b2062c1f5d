"""Numba caches a kernel by its own file and does not see edits in the kernels that it calls.

A cache folder named after all sources that reach machine code keeps a test run from meeting stale
kernels, and leaves kernels alone when anything else is edited. Kernels are in the modules that
import `sampler.compilation.jit` or numba; modules of the packages that these import may give them
constants.
"""

import hashlib
import os
import re
import tempfile
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest

_ROOT = Path(__file__).resolve().parents[1]
_COMPILES = re.compile(rb"^(from|import) (sampler\.compilation\.jit|numba)\b", re.MULTILINE)
_IMPORTS = re.compile(rb"^from ((?:sampler|tablegen)[.\w]*) import", re.MULTILINE)


def kernel_sources():
    """Files whose contents can change what a kernel computes, with these contents."""
    folders = ("sampler", "tablegen", "docs", "tests")
    files = [path for name in folders for path in sorted(_ROOT.glob(f"{name}/**/*.py"))]
    texts = {path: path.read_bytes() for path in files}
    found = {path for path, text in texts.items() if _COMPILES.search(text)}
    waiting = [path for path in found if path.relative_to(_ROOT).parts[0] != "tests"]
    while waiting:
        names = _IMPORTS.findall(texts[waiting.pop()])
        needed = {_ROOT.joinpath(*n.decode().split(".")).with_suffix(".py") for n in names}
        new = (needed & texts.keys()) - found
        waiting += new
        found |= new
    return {path: texts[path] for path in sorted(found)}


_digest = hashlib.sha256(b"".join(kernel_sources().values()))
_folder = f"rebound-tables-{os.getuid()}-{_digest.hexdigest()[:16]}"
os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(tempfile.gettempdir()) / _folder))


@pytest.fixture
def call(capsys):
    """Run a program in this process: status, standard output, standard error."""

    def runner(program, *arguments):
        main = import_module(f"{program}.commands.main").main
        status = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return SimpleNamespace(status=status, out=captured.out, err=captured.err)

    return runner


@pytest.fixture
def refuse(call, tmp_path):
    """Run what a program must refuse: one line, and the folder as it was. Returns the line."""

    def runner(program, *arguments):
        before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
        ended = call(program, *arguments)
        assert (ended.status, ended.out) == (2, "")
        line, end, rest = ended.err.partition("\n")
        assert (end, rest) == ("\n", "")
        assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before
        assert line.startswith(f"{program}: error: ")
        return line.removeprefix(f"{program}: error: ")

    return runner
