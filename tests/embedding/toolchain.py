"""Compilers of this machine, and programs built with the header and the module of `sampler`."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from sampler.locate import include_directory

INCLUDE = include_directory()
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wconversion", "-Wshadow"]

_VARIABLES = {"gcc": "CC", "g++": "CXX", "gfortran": "FC"}
_FLAGS = {
    "gcc": ["-std=c99", "-Wstrict-prototypes"],
    "clang": ["-std=c99"],
    "g++": ["-std=c++17"],
    "clang++": ["-std=c++17"],
    "nvcc": [],
    "gfortran": ["-std=f2008"],
}


def find(compiler):
    """Path of a compiler, or None; CC, CXX and FC take the place of gcc, g++ and gfortran."""
    return shutil.which(os.environ.get(_VARIABLES.get(compiler, ""), compiler))


def require(compiler):
    """Path of a compiler; skips the test, saying so, where there is none."""
    path = find(compiler)
    if path is None:
        pytest.skip(f"no {compiler} on this machine")
    return path


def compile_with(compiler, arguments):
    """Run a compiler; its messages are the failure."""
    warnings = [] if compiler == "nvcc" else WARNINGS
    command = [
        require(compiler),
        *_FLAGS[compiler],
        *warnings,
        f"-I{INCLUDE}",
        *map(str, arguments),
    ]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert run.returncode == 0, f"{' '.join(command)}\n{run.stderr}"


def build(compiler, sources, program, flags=()):
    """Build a program and return its path."""
    language = ["-x", "c++"] if compiler in ("g++", "clang++") else []
    compile_with(compiler, [*language, *flags, *sources, "-o", program, "-lm"])
    return Path(program)


def run(program, *arguments, status=0, **environment):
    """Run a program and return what it prints."""
    done = subprocess.run(
        [str(program), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env=os.environ | environment,
    )
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout
