"""Fixtures of all tests, and the folder of their compiled kernels.

`tablegen.model.jit` keeps kernels by the kernel sources of both packages and by their own file.
Kernels of tests and examples also call those of other tests and examples.
"""

import contextlib
import hashlib
import os
import re
import signal
import tempfile
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest

_ROOT = Path(__file__).resolve().parents[1]
_COMPILES = re.compile(rb"^(from|import) (\S+\.jit|numba)\b", re.MULTILINE)
_FILES = [path for name in ("docs", "tests") for path in sorted(_ROOT.glob(f"{name}/**/*.py"))]

_texts = (path.read_bytes() for path in _FILES)
_digest = hashlib.sha256(b"".join(text for text in _texts if _COMPILES.search(text)))
_folder = f"rebound-tables-{os.getuid()}-{_digest.hexdigest()[:16]}"
os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(tempfile.gettempdir()) / _folder))

# A shell starts what goes on in the background with Ctrl-C ignored, and the programs that tests
# start would inherit that; these tests send it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_configure(config):
    """Let one process of a test run compile the direct model, and the others load what it wrote."""
    if hasattr(config, "workerinput"):
        with contextlib.suppress(ImportError):  # Windows; an installation without the generator
            _compile_one_at_a_time()


def _compile_one_at_a_time():
    import fcntl

    from tablegen.simulation import direct_law

    compiled, folder = direct_law.compiled_simulation, Path(os.environ["NUMBA_CACHE_DIR"])

    def one_at_a_time():
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / "lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            return compiled()

    direct_law.compiled_simulation = one_at_a_time


@pytest.fixture
def call(capsys):
    """Run a program in this process; return its status, standard output and standard error."""

    def runner(program, *arguments):
        module = "sampler.cli" if program == "sampler" else "tablegen.commands.main"
        status = import_module(module).main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return SimpleNamespace(status=status, out=captured.out, err=captured.err)

    return runner


@pytest.fixture
def refuse(call, tmp_path):
    """Run a command line that must be refused with one line and no new file; return the line."""

    def runner(program, *arguments):
        before = {path: path.lstat().st_mtime_ns for path in tmp_path.rglob("*")}
        ended = call(program, *arguments)
        assert (ended.status, ended.out) == (2, "")
        line, end, rest = ended.err.partition("\n")
        assert (end, rest) == ("\n", "")
        assert {path: path.lstat().st_mtime_ns for path in tmp_path.rglob("*")} == before
        assert line.startswith(f"{program}: error: ")
        return line.removeprefix(f"{program}: error: ")

    return runner
