"""What the first use costs: CPU seconds of programs that start with an empty cache, and again.

    python tests/benchmarks/bench_start.py

Kernels are compiled when they are first needed and then kept on disk. Every row is a
program of its own; "first" is the first time ever, "again" the least of a few runs after it.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import checkout

from tablegen.evidence.report import machine

#: Runs with a filled cache.
REPEATS = 3

_DRAW = "import sampler; t = sampler.load('corundum-steel-compact')"
_ONE = "seed=1, index=[0])"

TABLEGEN = (sys.executable, "-m", "tablegen")
SAMPLER = (sys.executable, "-m", "sampler")
_CONDITION = ("--alpha", "45", "--speed", "200", "--count", "1000", "--seed", "1")
PROGRAMS = {
    "tablegen --help": (*TABLEGEN, "--help"),
    "import tablegen": (sys.executable, "-c", "import tablegen"),
    "import numba, h5py": (sys.executable, "-c", "import numba, h5py"),
    "table.sample": (sys.executable, "-c", f"{_DRAW}; t.sample(0.5, 100.0, {_ONE}"),
    "table.rebound": (
        sys.executable,
        "-c",
        f"{_DRAW}; t.rebound([1.0, -90.0, 0.0], [0, 1, 0], 1e-5, {_ONE}",
    ),
    "sampler draw": (*SAMPLER, "draw", "corundum-steel", *_CONDITION, "--output", "draws.npz"),
    "tablegen inspect": (*TABLEGEN, "inspect", "corundum-steel"),
    "tablegen simulate": (
        *TABLEGEN,
        *("simulate", "--pair", "corundum-steel", "--shape", "mixture"),
        *_CONDITION,
        *("--output", "rebounds.npz"),
    ),
}


def seconds(words: tuple[str, ...], folder: Path) -> float:
    """CPU seconds of a program that runs in a folder, which also takes its cache."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    paths = os.pathsep.join([str(checkout.HERE.parents[1]), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": paths}
    subprocess.run(words, cwd=folder, env=environment, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def row(name: str, repeats: int = REPEATS) -> str:
    """Measure one program and say what it took."""
    with tempfile.TemporaryDirectory() as folder:
        first = seconds(PROGRAMS[name], Path(folder))
        again = min(seconds(PROGRAMS[name], Path(folder)) for _ in range(repeats))
    return f"{name:<20} {first:8.2f} {again:8.2f}"


def main() -> None:
    """Print a row for every program."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeats", type=int, default=REPEATS, help="runs with a filled cache")
    repeats = parser.parse_args().repeats
    print(f"CPU seconds on {machine()['processor']}")
    print(f"{'program':<20} {'first':>8} {'again':>8}")
    for name in PROGRAMS:
        print(row(name, repeats), flush=True)


if __name__ == "__main__":
    main()
