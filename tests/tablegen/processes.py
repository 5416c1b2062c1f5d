"""The command line in processes of its own, under MPI or not."""

import shutil
import subprocess
import sys
from functools import cache
from importlib import util
from types import SimpleNamespace

import pytest
from command_line import config_file
from tiny_tables import MEASURED, ROUGH

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


def generating(folder, *words, config=ROUGH):
    """Words that generate the table of a configuration in a folder."""
    settings = ("--output", folder / "t.h5", "--conditions", 1, "--samples", MEASURED, "--quiet")
    words = (*TABLEGEN, "generate", config_file(folder, config), *settings, *words)
    return [str(word) for word in words]


@cache
def mpiexec(ranks):
    """Words that start some ranks, on however few processors and as any user."""
    words, version = ["mpiexec", "-n", str(ranks)], command("mpiexec", "--version").out
    if "Open MPI" in version or "OpenRTE" in version:
        words += ["--allow-run-as-root", "--oversubscribe"]
    return words


def our_lines(text):
    """Lines of the command itself; mpiexec adds its own when a rank ends with an error."""
    return [line for line in text.splitlines() if line.startswith("tablegen: ")]
