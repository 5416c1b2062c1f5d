"""Compilers of this machine, and programs built with the header and the module of `sampler`."""

import ctypes
import hashlib
import os
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np
import pytest

from sampler.files import include_directory

INCLUDE = include_directory()
MODULE = INCLUDE / "rebound_sampler.f90"
IMPLEMENTATION = '#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n'
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wconversion", "-Wshadow"]
FORTRAN_WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wimplicit-interface"]

#: gcc compiles functions for one kind of processor only, in half of the time; those of a batch have
#: copies for several, which `test_c_header.test_vectors` runs.
ONE_COPY = "-DRBT_NO_CLONES"

_VARIABLES = {"gcc": "CC", "g++": "CXX", "gfortran": "FC"}
_FLAGS = {
    "gcc": ["-std=c99", "-Wstrict-prototypes"],
    "clang": ["-std=c99"],
    "g++": ["-std=c++17"],
    "clang++": ["-std=c++17"],
    "nvcc": ["-std=c++17", "-fmad=false"],
    "gfortran": ["-std=f2008"],
}


def find(compiler):
    """Path of a compiler, or None; CC, CXX and FC take the place of gcc, g++ and gfortran."""
    if compiler == "nvcc" and (installed := wheel_file("nvidia-cuda-nvcc", "bin/nvcc")):
        return str(installed)
    return shutil.which(os.environ.get(_VARIABLES.get(compiler, ""), compiler))


def wheel_file(package, end):
    """File of an installed package whose path ends so, or None without the package."""
    try:
        found = distribution(package)
    except PackageNotFoundError:
        return None
    # a package without the file is a test that fails, not one that is skipped
    (path,) = (path for path in found.files if str(path).endswith(f"/{end}"))
    return Path(found.locate_file(path)).resolve(strict=True)


def require(compiler):
    """Path of a compiler; skips the test, saying so, where there is none."""
    path = find(compiler)
    if path is None:
        pytest.skip(f"no {compiler} on this machine")
    return path


#: Builds that are kept for the other processes and runs of the tests.
_BUILDS = Path(tempfile.gettempdir()) / f"rebound-tables-builds-{os.getuid()}"


def compile_with(compiler, arguments, output):
    """Run a compiler, or take what it made of the same texts before; its messages are the failure.

    What is kept is found by the compiler's version, the flags and the texts of all sources and of
    what lies beside them.
    """
    others = {"nvcc": ["-Werror", "all-warnings"], "gfortran": FORTRAN_WARNINGS}
    warnings = others.get(compiler, WARNINGS)
    words = [*_FLAGS[compiler], *warnings, f"-I{INCLUDE}", *map(str, arguments)]
    command = [require(compiler), *words, "-o", str(output)]
    kept = None if compiler == "gfortran" else _BUILDS / _digest(command[0], words)
    if kept is None or not kept.exists():
        run = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        assert run.returncode == 0, f"{' '.join(command)}\n{run.stderr}"
    if kept is None:
        return
    if kept.exists():
        shutil.copy(kept, output)
        return
    _BUILDS.mkdir(mode=0o700, exist_ok=True)
    unfinished = _BUILDS / f"{kept.name}-{os.getpid()}"
    shutil.copy(output, unfinished)
    unfinished.replace(kept)


def _digest(compiler, words):
    """What a build depends on."""
    sources = [Path(word) for word in words if Path(word).is_file()]
    folders = {INCLUDE, *(source.parent for source in sources)}
    found = hashlib.sha256(_version(compiler).encode())
    for word in words:
        found.update(b"a source" if Path(word) in sources else word.encode() + b"\n")
    beside = (path for folder in sorted(folders) for path in sorted(folder.glob("*.[ch]")))
    for path in [*sources, *beside]:
        found.update(path.read_bytes())
    return found.hexdigest()


@cache
def _version(compiler):
    """What a compiler says of itself."""
    return subprocess.run([compiler, "--version"], capture_output=True, text=True).stdout


def build(compiler, sources, program, flags=()):
    """Build a program and return its path."""
    language = ["-x", "c++"] if compiler in ("g++", "clang++") else []
    compile_with(compiler, [*language, *flags, *sources, "-lm"], program)
    return Path(program)


def build_on_host(source, program, flags=(), compiler="g++"):
    """Build a program for a GPU as one whose kernels the host runs, and return its path."""
    header = Path(__file__).resolve().parent / "device_on_host.h"
    options = ["-include", header, "-DRBTI_GPU", "-ffp-contract=off", *flags]
    return build(compiler, [source], program, options)


def build_fortran(sources, folder, flags=()):
    """Build a Fortran program with the module and the header, and return its path."""
    (folder / "library.c").write_text(IMPLEMENTATION)
    compile_with("gcc", ["-O2", ONE_COPY, "-c", folder / "library.c"], folder / "library.o")
    objects = [MODULE, *sources, folder / "library.o"]
    return build("gfortran", objects, folder / "program", [*flags, f"-J{folder}"])


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


class Report(ctypes.Structure):
    """What a batch reports."""

    _fields_ = [
        (name, ctypes.c_size_t) for name in ("row", "clamped_row", "clamped", "extrapolated")
    ]


class Impacts(ctypes.Structure):
    """What a batch of rebounds is given."""

    _fields_ = [
        (name, ctypes.c_void_p)
        for name in (
            *("velocity", "normal", "half_size", "wall_velocity", "index", "hit", "omega"),
            "roughness",
        )
    ]


def header_library(folder, flags=()):
    """Shared library of nothing but the header."""
    (folder / "library.c").write_text(IMPLEMENTATION)
    return load_library(folder / "library.c", flags)


def load_library(source, flags=(), compiler="gcc"):
    """Build a shared library with the functions of the header, and declare them to Python."""
    path = Path(source).with_suffix(".so")
    compile_with(compiler, [*flags, "-fPIC", "-shared", source, "-lm"], path)
    library = ctypes.CDLL(str(path))
    reals, integers = _array(np.float64), _array(np.int32)
    table, size, seed = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint64
    keys = seed, _array(np.uint64), _array(np.uint32)
    report = ctypes.POINTER(Report)
    for name, arguments in {
        "rbt_open": (ctypes.c_char_p, ctypes.POINTER(table)),
        "rbt_open_memory": (ctypes.c_void_p, size, ctypes.POINTER(table)),
        "rbt_close": (table,),
        "rbt_draw_batch": (table, size, reals, reals, reals, *keys, reals, report),
        "rbt_rebound": (
            table, reals, reals, ctypes.c_double, reals, reals, seed, seed, ctypes.c_uint32, reals,
            reals,
        ),
        "rbt_rough_rebound": (
            table, reals, reals, ctypes.c_double, reals, ctypes.c_double, reals, seed, seed,
            ctypes.c_uint32, reals, reals,
        ),
        "rbt_wall_tilt": (*4 * [ctypes.c_double], reals),
        "rbt_draw": (
            table, ctypes.c_double, ctypes.c_double, reals, seed, seed, ctypes.c_uint32, reals,
        ),
        "rbt_grain": (table, seed, seed, ctypes.c_uint32, reals),
        "rbt_keep_grains": (table, ctypes.c_int),
        "rbt_has_spin_law": (table,),
        "rbt_valid_speed": (table, reals),
        "rbt_rebound_batch": (table, size, ctypes.POINTER(Impacts), seed, reals, reals, report),
        "rbt_components": (table, integers),
        "rbt_strerror": (ctypes.c_int,),
        "rbt_pair": (table,),
        "rbt_alpha_range": (table, reals),
        "rbt_speed_range": (table, reals),
    }.items():  # fmt: skip
        getattr(library, name).argtypes = arguments
    library.rbt_pair.restype = library.rbt_strerror.restype = ctypes.c_char_p
    return library


def _array(dtype):
    """Argument type of a contiguous numpy array, or None for NULL."""
    kind = np.ctypeslib.ndpointer(dtype, flags="C_CONTIGUOUS")

    def from_param(cls, value):
        return None if value is None else kind.from_param(value)

    return type("array", (kind,), {"from_param": classmethod(from_param)})


def open_code(library, path):
    """Code of opening a file, and the table."""
    table = ctypes.c_void_p()
    return library.rbt_open(str(path).encode(), ctypes.byref(table)), table


@contextmanager
def opened(library, path):
    """Table of the C library, closed at the end."""
    code, table = open_code(library, path)
    assert code == 0
    try:
        yield table
    finally:
        library.rbt_close(table)


def random_conditions(n, seed=1):
    """Angles, speeds (one in five outside of the small tables), indices and hits."""
    rng = np.random.default_rng(seed)
    alpha1, speed = rng.uniform(0.3, 0.5 * np.pi, n), rng.uniform(45.0, 125.0, n)
    index = rng.integers(0, 2**64, n, dtype=np.uint64)
    return alpha1, speed, index, rng.integers(0, 2**32, n, dtype=np.uint32)
