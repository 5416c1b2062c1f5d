"""Nanoseconds per draw: Python and C, beside numpy's bootstrap of stored rows and the floor.

    python tests/benchmarks/bench_draw.py
    python tests/benchmarks/bench_draw.py --table corundum-steel --rounds 31

Every row draws the same number of states of six variables at random angles and speeds, on one
thread. The bootstrap is ``rows[rng.integers(0, 10**6, n)]`` of an array of 10**6 rows in single
precision. Rows with spin are draws from the spin law, at spins of all directions; a table without
one gets a random one of 132 leaves. The floor, which no table of this size can go below, is the
random words of a draw and one read of 16 bytes at a random place. Times are processor time; a
ratio is the median of the ratios to the bootstrap of the same round. Without gcc the rows of C
are left out.
"""

import argparse
import statistics
import tempfile
from collections.abc import Callable
from pathlib import Path

from harness import HERE, in_turns, median_ratio  # isort: skip
import numpy as np
import toolchain
from spin_tables import with_spin_law

import sampler
from sampler.files import find_table
from sampler.formats.hdf5 import read_table
from sampler.formats.image import write_binary_table

ROWS = 10**6
BOOTSTRAP = "numpy bootstrap of rows"
NATIVE = ("-O3", "-march=native")

#: With versions for wide vectors, which tests leave out.
VERSIONS = ("-URBT_NO_CLONES",)

#: Draws all states once.
Draw = Callable[[], object]


class Conditions:
    """Random conditions within a table, and arrays for the states."""

    def __init__(self, table: sampler.Table, n: int) -> None:
        rng = np.random.default_rng(1)
        self.alpha1 = rng.uniform(*np.radians(table.alpha_nodes_deg[[0, -1]]), n)
        self.speed = rng.uniform(*table.speed_nodes[[0, -1]], n)
        self.index = rng.integers(0, 2**64, n, dtype=np.uint64)
        self.hit = np.zeros(n, np.uint32)
        self.spin = rng.uniform(-1.0, 1.0, (n, 3))
        self.inertia = rng.uniform(0.2, 0.3, n)
        along, down = self.speed * np.cos(self.alpha1), -self.speed * np.sin(self.alpha1)
        self.velocity = np.stack([along, down, np.zeros(n)], axis=1)
        self.omega = self.spin * self.speed[:, None] / 1e-5
        self.states = np.empty((n, len(table.columns)))
        self.codes = np.empty(n, np.int32)


def python_draws(table: sampler.Table, c: Conditions) -> dict[str, Draw]:
    rng = np.random.default_rng(2)
    rows = rng.standard_normal((ROWS, 6)).astype(np.float32)
    keys = {"seed": 7, "index": c.index, "hit": c.hit, "threads": 1}

    def sample(out, **spin):
        return lambda: table.sample(c.alpha1, c.speed, **keys, out=out, **spin)

    def rebound(**spin):
        return lambda: table.rebound(c.velocity, [0.0, 1.0, 0.0], 1e-5, **keys, **spin)

    return {
        BOOTSTRAP: lambda: rows[rng.integers(0, ROWS, c.index.size)],
        "Python, Table.sample": sample(c.states),
        "Python, Table.sample, spin": sample(c.states, spin=c.spin, inertia=c.inertia),
        "Python, Table.rebound": rebound(),
        "Python, Table.rebound, spin": rebound(omega=c.omega, inertia=c.inertia),
    }


def c_draws(image: Path, c: Conditions, folder: Path) -> dict[str, Draw]:
    """Draws in C, in batches and one by one, and the floor."""
    draws: dict[str, Draw] = {}
    n = c.index.size
    for flags in (("-O2", *VERSIONS), (*NATIVE, *VERSIONS)):
        source = folder / f"loops{len(flags)}.c"
        source.write_text((HERE / "draw_loops.c").read_text())
        library = toolchain.load_library(source, flags)
        library.one_by_one.argtypes = library.rbt_sample.argtypes
        library.floor_of_draws.argtypes = library.rbt_grains.argtypes[:4]
        _, opened = toolchain.open_code(library, image)
        name = f"C {' '.join(flags[:-1])}"
        for label, spin in (("", None), (", spin", c.spin)):
            arrays = {name: getattr(c, name) for name in ("alpha1", "speed", "index", "hit")}
            arrays |= {} if spin is None else {"spin": spin, "inertia": c.inertia}
            record = toolchain.Conditions(**{k: array.ctypes.data for k, array in arrays.items()})
            given = (opened, n, record, 7, c.states, c.codes)
            draws[f"{name}, batch{label}"] = lambda f=library.rbt_sample, a=given: f(*a)
            draws[f"{name}, one by one{label}"] = lambda f=library.one_by_one, a=given: f(*a)
        if flags[:2] == NATIVE:
            words = (opened, n, 7, c.index)
            draws["C floor"] = lambda f=library.floor_of_draws, a=words: f(*a)
    return draws


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel")
    parser.add_argument("--count", type=int, default=ROWS)
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    contents = read_table(find_table(options.table))
    if not contents.has_spin:
        contents = with_spin_law(contents, codes=(0, 1, 2, 3), depth=5)
    table = sampler.Table(contents)
    conditions = Conditions(table, options.count)
    draws = python_draws(table, conditions)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if toolchain.find("gcc"):
            write_binary_table(folder / "t.rbt", contents)
            draws |= c_draws(folder / "t.rbt", conditions, folder)
        measured = in_turns(draws, options.rounds)
    print(f"{'ns per draw':32} {'least':>8} {'median':>8} {'/ bootstrap':>12}")
    scale = 1e9 / options.count
    for name, times in measured.items():
        least, median = scale * min(times), scale * statistics.median(times)
        ratio = median_ratio(times, measured[BOOTSTRAP])
        print(f"{name:32} {least:8.1f} {median:8.1f} {ratio:12.2f}")


if __name__ == "__main__":
    main()
