"""Bytes, load time, memory and cost of a draw of tables cut to a scene, and of the full table.

    python tests/benchmarks/bench_scenes.py [--table corundum-steel]

The tables are cut from the full one by `tablegen prune`, so they give the same draws. Costs are the
best of several batches of a million draws at random conditions, on one thread.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from harness import in_turns  # isort: skip
import numpy as np

import sampler
from sampler.files import find_table
from tablegen.config.config import load_config
from tablegen.tables.prune import prune

N, ROUNDS = 1_000_000, 7

_LOAD = """
import sys, time, sampler, sampler.table
start = time.perf_counter()
sampler.load(sys.argv[1])
print(time.perf_counter() - start)
"""


def load_seconds(path):
    """Measure the seconds of the first load in a new process."""
    command = [sys.executable, "-c", _LOAD, str(path)]
    return min(float(subprocess.check_output(command)) for _ in range(3))


def draws(table):
    """Draw at random conditions."""
    rng = np.random.default_rng(1)
    alpha1, speed = np.radians(rng.uniform(0.5, 90.0, N)), rng.uniform(50.0, 300.0, N)
    index = np.arange(N, dtype=np.uint64)
    return lambda: table.sample(alpha1, speed, seed=1, index=index, threads=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        paths = {"full": find_table(options.table)}
        for scene in ("plane-flow", "no-spin"):
            paths[scene] = Path(folder) / f"{scene}.h5"
            prune(paths["full"], load_config(scene), paths[scene])
        tables = {name: sampler.load(path) for name, path in paths.items()}
        times = in_turns({name: draws(table) for name, table in tables.items()}, ROUNDS)
        for name, table in tables.items():
            print(
                f"{name:<12}{' '.join(table.columns):<36}"
                f"{paths[name].stat().st_size / 1e6:6.2f} MB file"
                f"{table.nbytes / 1e6:7.2f} MB memory"
                f"{load_seconds(paths[name]):7.3f} s to load"
                f"{1e9 * min(times[name]) / N:7.0f} ns a draw"
            )


if __name__ == "__main__":
    main()
