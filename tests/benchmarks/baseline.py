"""Builds and runs the C++ baseline."""

import json
import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

SOURCE = Path(__file__).resolve().with_name("rk4_baseline.cpp")
FLAGS = ("-std=c++17", "-O3", "-march=native")

#: Shapes that the baseline knows.
SHAPES = ("mixture", "ellipsoid", "prism", "truncated-prism", "tetrahedron")


def find_compiler() -> str | None:
    """Path of the C++ compiler, the one that CXX names or else g++, if there is one."""
    return shutil.which(os.environ.get("CXX", "g++"))


def build(compiler: str, folder: Path, flags: Sequence[str] = ()) -> Path:
    """Compile the baseline into ``folder``; the program.

    Raises
    ------
    RuntimeError
        If it does not compile.
    """
    program = folder / "rk4_baseline"
    command = [compiler, *FLAGS, *flags, str(SOURCE), "-o", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} failed:\n{done.stderr}")
    return program


def run(
    program: Path, shape: str, alpha_deg: float, speed: float, count: int, seed: int
) -> dict[str, Any]:
    """Rebound ``count`` particles.

    Returns
    -------
    dict
        ``microseconds`` of processor time per rebound, mean number of ``collisions``, and
        ``mean`` by the names of the components.
    """
    arguments = [shape, repr(float(alpha_deg)), repr(float(speed)), str(count), str(seed)]
    done = subprocess.run(
        [str(program), *arguments], capture_output=True, text=True, check=True, timeout=3600
    )
    result: dict[str, Any] = json.loads(done.stdout)
    return result
