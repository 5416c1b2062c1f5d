"""Compilers of this machine, programs built with the header, and its functions in Python."""

import ctypes
import os
import shutil
import subprocess
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np
import pytest

from sampler.files import include_directory
from sampler.library import Conditions, Impacts, Rebounds, library

INCLUDE = include_directory()
MODULE = INCLUDE / "rebound_sampler.f90"
IMPLEMENTATION = '#define REBOUND_SAMPLER_IMPLEMENTATION\n#include "rebound_sampler.h"\n'

#: gcc compiles functions for one kind of processor only, in half of the time.
ONE_COPY = "-DRBT_NO_CLONES"

#: A program that includes the header takes its functions from an object that it is linked with.
LINKED = "-DREBOUND_SAMPLER_IMPLEMENTED"

#: gcc optimises nothing, as under its sanitizer, in a fifth of the time.
QUICK = ["-O0", "-D__SANITIZE_ADDRESS__"]

_WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wconversion", "-Wshadow"]
_VARIABLES = {"gcc": "CC", "g++": "CXX", "gfortran": "FC"}
_FLAGS = {
    "gcc": ["-std=c99", "-Wstrict-prototypes", ONE_COPY, *_WARNINGS],
    "clang": ["-std=c99", *_WARNINGS],
    "g++": ["-std=c++17", ONE_COPY, *_WARNINGS],
    "clang++": ["-std=c++17", *_WARNINGS],
    "nvcc": ["-std=c++17", "-fmad=false", "-Werror", "all-warnings"],
    "gfortran": ["-std=f2008", *_WARNINGS[:4], "-Wimplicit-interface"],
}


def find(compiler):
    """Path of a compiler, or None; CC, CXX and FC take the place of gcc, g++ and gfortran."""
    if compiler == "nvcc" and (installed := wheel_file("nvidia-cuda-nvcc", "bin/nvcc")):
        return str(installed)
    return shutil.which(os.environ.get(_VARIABLES.get(compiler, ""), compiler))


def wheel_file(package, end):
    """File of an installed package whose path ends so, or None without the package."""
    try:
        wheel = distribution(package)
    except PackageNotFoundError:
        return None
    # a package without the file is a test that fails, not one that is skipped
    (path,) = (path for path in wheel.files if str(path).endswith(f"/{end}"))
    return Path(wheel.locate_file(path)).resolve(strict=True)


def require(compiler):
    """Path of a compiler; skips the test where there is none."""
    path = find(compiler)
    if path is None:
        pytest.skip(f"no {compiler} on this machine")
    return path


def compile_with(compiler, arguments, output):
    words = [require(compiler), *_FLAGS[compiler], f"-I{INCLUDE}", *map(str, arguments)]
    command = [*words, "-o", str(output)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stderr}"


def build(compiler, sources, program, flags=()):
    language = ["-x", "c++"] if compiler in ("g++", "clang++") else []
    compile_with(compiler, [*language, *flags, *sources, "-lm"], program)
    return Path(program)


def build_implementation(path, flags):
    """Compile the functions of the header to an object, and return its path."""
    source = path.with_suffix(".c")
    source.write_text(IMPLEMENTATION)
    return build("gcc", [source], path, ["-c", *flags])


def build_on_host(source, program, flags=()):
    """Build a program for a GPU as one whose kernels the host runs, and return its path."""
    header = Path(__file__).resolve().parent / "device_on_host.h"
    options = ["-include", header, "-DRBTI_GPU", "-ffp-contract=off", *flags]
    return build("g++", [source], program, options)


def build_fortran(sources, folder, flags=()):
    """Build a Fortran program with the module and Python's library, and return its path."""
    objects = [MODULE, *sources, library()._name]
    return build("gfortran", objects, folder / "program", [*flags, f"-J{folder}"])


def run(program, *arguments, status=0, **environment):
    words = [str(program), *map(str, arguments)]
    environment = os.environ | environment
    done = subprocess.run(words, capture_output=True, text=True, timeout=300, env=environment)
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout


def load_library(source, flags=()):
    """Build a shared library with the functions of the header, and declare them to Python."""
    path = Path(source).with_suffix(".so")
    compile_with("gcc", [*flags, "-fPIC", "-shared", source, "-lm"], path)
    return declared(path)


def declared(path):
    """Load a library and declare the functions of the header, which take numpy arrays."""
    library = ctypes.CDLL(str(path))
    reals, integers = map(_array, (np.float64, np.int32))
    table, size, seed, real = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint64, ctypes.c_double
    index, hit, record = _array(np.uint64), _array(np.uint32), ctypes.POINTER
    for name, arguments in {
        "rbt_open": (ctypes.c_char_p, record(table)),
        "rbt_open_memory": (ctypes.c_void_p, size, record(table)),
        "rbt_close": (table,),
        "rbt_strerror": (ctypes.c_int,),
        "rbt_pair": (table,),
        "rbt_covered": (table, reals),
        "rbt_variables": (table, integers),
        "rbt_has_spin_law": (table,),
        "rbt_grains": (table, size, seed, index, hit, reals),
        "rbt_sample": (table, size, record(Conditions), seed, reals, integers),
        "rbt_rebound": (table, size, record(Impacts), seed, record(Rebounds)),
        "rbt_mean_half_size": (table, real),
        "rbt_use_direct": (table, ctypes.c_void_p),
        "rbt_wall_tilt": (real, real, real, real, reals),
    }.items():
        getattr(library, name).argtypes = arguments
    library.rbt_mean_half_size.restype = real
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
