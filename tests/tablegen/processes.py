"""The command line in processes of its own, under MPI or not."""

import shutil
import subprocess
import sys
from functools import cache
from importlib import util
from types import SimpleNamespace

import pytest

TABLEGEN = (sys.executable, "-m", "tablegen")

needs_dask = pytest.mark.skipif(
    util.find_spec("distributed") is None, reason="needs Dask: pip install 'rebound-tables[dask]'"
)
needs_mpi = pytest.mark.skipif(
    util.find_spec("mpi4py") is None or shutil.which("mpiexec") is None,
    reason="needs mpi4py and mpiexec: pip install 'rebound-tables[mpi]' and Open MPI or MPICH",
)


def command(*words):
    """Run a command line to its end: status, standard output, standard error but compilations."""
    ended = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=150)
    # the first process of all says that it compiles, which depends on what ran before
    lines = ended.stderr.splitlines(keepends=True)
    err = "".join(line for line in lines if not line.startswith(("compiling the ", "compiled ")))
    return SimpleNamespace(status=ended.returncode, out=ended.stdout, err=err)


@cache
def mpiexec(ranks):
    """Words that start some ranks, on however few processors and as any user."""
    version = command("mpiexec", "--version").out
    open_mpi = "Open MPI" in version or "OpenRTE" in version
    flags = ["--allow-run-as-root", "--oversubscribe"] if open_mpi else []
    return ["mpiexec", "-n", str(ranks), *flags]


def our_lines(text):
    """Lines of the command itself; mpiexec adds its own when a rank ends with an error."""
    return [line for line in text.splitlines() if line.startswith("tablegen: ")]
