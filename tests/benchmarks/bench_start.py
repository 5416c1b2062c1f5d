"""CPU seconds of programs that start with an empty cache of compiled kernels, and again.

    python tests/benchmarks/bench_start.py

Every row is a program: "first" with an empty cache, "again" the least of three runs after it.
"""

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from harness import ROOT

_PYTHON = (sys.executable, "-c")
_DRAW = "import sampler; t = sampler.load('corundum-steel-compact')"
_ONE = "seed=1, index=[0], hit=0)"
_IMPACT = "[1.0, -90.0, 0.0], [0, 1, 0], 1e-5"
_CONDITION = ("--alpha", "45", "--speed", "200", "--count", "1000", "--seed", "1")
_SHAPE = ("-m", "tablegen", "simulate", "--pair", "corundum-steel", "--shape", "mixture")
_OUTPUT = ("--output", "r.npz", "--overwrite")
PROGRAMS = {
    "import numpy, h5py": (*_PYTHON, "import numpy, h5py"),
    "table.sample": (*_PYTHON, f"{_DRAW}; t.sample(0.5, 100.0, {_ONE}"),
    "table.rebound": (*_PYTHON, f"{_DRAW}; t.rebound({_IMPACT}, {_ONE}"),
    "spinning, rough wall": (
        *_PYTHON,
        f"{_DRAW}; t.rebound({_IMPACT}, omega=[0, 0, 1e5], roughness=0.1, {_ONE}",
    ),
    "tablegen simulate": (sys.executable, *_SHAPE, *_CONDITION, *_OUTPUT),
}


def seconds(words: tuple[str, ...], folder: Path) -> float:
    """Run a program in a folder, which also holds its cache; its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": paths}
    subprocess.run(words, cwd=folder, env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    print(f"{'program, CPU seconds':<20} {'first':>8} {'again':>8}")
    for name, words in PROGRAMS.items():
        with tempfile.TemporaryDirectory() as folder:
            first = seconds(words, Path(folder))
            again = min(seconds(words, Path(folder)) for _ in range(3))
        print(f"{name:<20} {first:8.2f} {again:8.2f}", flush=True)


if __name__ == "__main__":
    main()
