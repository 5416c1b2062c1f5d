"""Nanoseconds per draw: Python and C, beside numpy's bootstrap of stored rows and the floor.

    python tests/benchmarks/bench_draw.py
    python tests/benchmarks/bench_draw.py --table corundum-steel --rounds 31 --json draw.json

Every one draws the same number of states of six components at random angles and speeds, on one
thread. The bootstrap is ``rows[rng.integers(0, 10**6, n)]`` of an array of 10**6 rows in single
precision; draws of Python are written in double precision, and once more in single precision, as
those rows are. Rows with spin are draws from the spin law, at spins of all directions; a table
without one gets a random one of 132 leaves. The floor is what no table of this size can go below:
the random words of a draw and one read of 16 bytes at a random place. Times are processor time; all
take turns in every round, and a ratio is the median of the ratios to the bootstrap of the same
round. Without gcc the rows of C are left out.
"""

import argparse
import ctypes
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import checkout  # noqa: F401  (before the imports that it makes possible)
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "embedding"))
import toolchain
from spin_tables import with_spin_law

import sampler
from sampler.formats.image import write_binary_table

HERE = Path(__file__).resolve().parent
ROWS = 10**6
BOOTSTRAP = "numpy bootstrap of rows"
NATIVE = ("-O3", "-march=native")

#: Draws all states once.
Draw = Callable[[], object]


class Conditions:
    """Random conditions within a table, and where states go."""

    def __init__(self, table: sampler.Table, n: int, seed: int = 1) -> None:
        rng = np.random.default_rng(seed)
        self.alpha1, self.speed = (
            rng.uniform(*table.alpha_range, n),
            rng.uniform(*table.speed_range, n),
        )
        self.index = rng.integers(0, 2**64, n, dtype=np.uint64)
        self.hit = np.zeros(n, np.uint32)
        self.spin = rng.standard_normal((n, 3))
        self.states = np.empty((n, len(table.columns)))
        self.singles = np.empty((n, len(table.columns)), np.float32)


def python_draws(table: sampler.Table, conditions: Conditions) -> dict[str, Draw]:
    """The bootstrap, and the batch of this package."""
    rng = np.random.default_rng(2)
    rows = rng.standard_normal((ROWS, 6)).astype(np.float32)
    c = conditions
    return {
        BOOTSTRAP: lambda: rows[rng.integers(0, ROWS, c.index.size)],
        "Python, Table.sample": lambda: table.sample(
            c.alpha1, c.speed, seed=7, index=c.index, hit=c.hit, threads=1, out=c.states
        ),
        "Python, Table.sample, float32": lambda: table.sample(
            c.alpha1, c.speed, seed=7, index=c.index, hit=c.hit, threads=1, out=c.singles
        ),
        "Python, Table.sample, spin": lambda: table.sample(
            c.alpha1,
            c.speed,
            spin=c.spin,
            seed=7,
            index=c.index,
            hit=c.hit,
            threads=1,
            out=c.states,
        ),
    }


def c_draws(image: Path, conditions: Conditions, folder: Path) -> dict[str, Draw]:
    """Batch, single calls and floor in C, compiled with and without the instructions of here."""
    found: dict[str, Draw] = {}
    c = conditions
    n = c.index.size
    for flags in (("-O2",), NATIVE):
        source = folder / f"loops{len(flags)}.c"
        source.write_text((HERE / "draw_loops.c").read_text())
        library = toolchain.load_library(source, flags)
        library.one_by_one.argtypes = library.rbt_draw_batch.argtypes[:-1]
        library.floor_of_draws.argtypes = (
            ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint64, library.one_by_one.argtypes[6],
        )  # fmt: skip
        _, opened = toolchain.open_code(library, image)
        name = f"C {' '.join(flags)}"
        for label, spin in (("", None), (", spin", c.spin)):
            given = (opened, n, c.alpha1, c.speed, spin, 7, c.index, c.hit, c.states)
            found[f"{name}, batch{label}"] = lambda f=library.rbt_draw_batch, a=given: f(*a, None)
            found[f"{name}, one by one{label}"] = lambda f=library.one_by_one, a=given: f(*a)
        if flags == NATIVE:
            words = (opened, n, 7, c.index)
            found["C floor"] = lambda f=library.floor_of_draws, a=words: f(*a)
    return found


def measure(draws: dict[str, Draw], n: int, rounds: int) -> dict[str, list[float]]:
    """Nanoseconds per draw in each round; the order rotates from round to round."""
    names = list(draws)
    seconds: dict[str, list[float]] = {name: [] for name in names}
    for draw in draws.values():
        draw()
    for turn in range(rounds):
        for k in range(len(names)):
            name = names[(turn + k) % len(names)]
            start = time.process_time()
            draws[name]()
            seconds[name].append(1e9 * (time.process_time() - start) / n)
    return seconds


def summarised(measured: dict[str, list[float]]) -> list[dict[str, object]]:
    """Least and median time of each, and median ratio to the bootstrap."""
    base = measured[BOOTSTRAP]
    return [
        {
            "name": name,
            "least_ns": min(times),
            "median_ns": statistics.median(times),
            "ratio": statistics.median(t / b for t, b in zip(times, base, strict=True)),
        }
        for name, times in measured.items()
    ]


def with_any_spin_law(table: sampler.Table) -> sampler.Table:
    """The table, with a random spin law if it has none: its numbers do not change the times."""
    if table.contents.has_spin:
        return table
    return sampler.Table(with_spin_law(table.contents, codes=(0, 1, 2, 3), depth=5))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel")
    parser.add_argument("--count", type=int, default=ROWS)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    table = with_any_spin_law(sampler.load(arguments.table))
    conditions = Conditions(table, arguments.count)
    draws = python_draws(table, conditions)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if toolchain.find("gcc"):
            write_binary_table(folder / "t.rbt", table.contents)
            draws |= c_draws(folder / "t.rbt", conditions, folder)
        found = summarised(measure(draws, arguments.count, arguments.rounds))
    print(f"{'ns per draw':32} {'least':>8} {'median':>8} {'/ bootstrap':>12}")
    for row in found:
        print(
            f"{row['name']:32} {row['least_ns']:8.1f} {row['median_ns']:8.1f} {row['ratio']:12.2f}"
        )
    if arguments.json:
        arguments.json.write_text(json.dumps({"table": arguments.table, "draws": found}, indent=1))


if __name__ == "__main__":
    main()
