"""Nanoseconds per draw against the size of a table, and draws of several threads.

    python tests/benchmarks/bench_scaling.py
    python tests/benchmarks/bench_scaling.py --plot scaling.png --json scaling.json

A table of one fitted node, repeated over a grid, is varied in its nodes, its mixture components and
its knots, one at a time. A draw takes the same random words, steps and reads whatever these are;
what grows is the time that memory takes to answer. Beside draws at random conditions stand draws at
one condition, which stay in the processor's cache. Times are the least of several rounds in which
all tables take turns. Two threads are timed on the shipped table, by the clock on the wall.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import checkout  # noqa: F401  (before the imports that it makes possible)
import numpy as np

import sampler
from sampler.table import Table
from tablegen.config.config import load_config
from tablegen.fitting.node import fit_node
from tablegen.fitting.resolution import Resolution
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes
from tablegen.tables.intervals import Grid

SAMPLES = 50_000
CONDITION = (40.0, 150.0)

#: Angles and speeds, components and knots of the table from which one is varied at a time.
BASE = ((24, 6), 384, 129)
GRIDS = ((2, 2), (6, 3), (12, 4), (24, 6), (48, 12), (96, 24))
COMPONENTS = (32, 96, 192, 384, 768, 1536)
KNOTS = (17, 33, 65, 129, 257, 513)


@dataclass(frozen=True)
class Size:
    """A table to be timed: what is varied, and all of its sizes."""

    varied: str
    grid: tuple[int, int]
    components: int
    knots: int

    @property
    def value(self) -> int:
        """The number that is varied."""
        nodes = self.grid[0] * self.grid[1]
        return {"nodes": nodes, "components": self.components, "knots": self.knots}[self.varied]


def sizes() -> list[Size]:
    """All tables to be timed."""
    grid, components, knots = BASE
    return [
        *(Size("nodes", other, components, knots) for other in GRIDS),
        *(Size("components", grid, other, knots) for other in COMPONENTS),
        *(Size("knots", grid, components, other) for other in KNOTS),
    ]


def make_table(size: Size) -> Table:
    """Make a table of equal nodes."""
    config = load_config("corundum-steel")
    angles, speeds = size.grid
    grid = Grid(
        tuple(np.linspace(*config.domain.alpha_deg, angles)),
        tuple(np.linspace(*config.domain.speed, speeds)),
    )
    node = fit_node(config, *CONDITION, Resolution(SAMPLES, size.knots, size.components))
    return Table(assemble(config, make_axes(config, grid), [node] * (angles * speeds)))


class Draws:
    """Draws from one table, at random conditions and at one."""

    def __init__(self, table: Table, count: int) -> None:
        rng = np.random.default_rng(1)
        self.table, self.index = table, np.arange(count, dtype=np.uint64)
        self.states = np.empty((count, len(table.columns)))
        self.spread = (
            rng.uniform(*table.alpha_range, count),
            rng.uniform(*table.speed_range, count),
        )
        self.still = (np.full(count, np.radians(CONDITION[0])), np.full(count, CONDITION[1]))

    def nanoseconds(self, conditions: tuple[np.ndarray, np.ndarray]) -> float:
        """Processor time of one draw on one thread."""
        start = time.process_time()
        self.table.sample(*conditions, seed=1, index=self.index, threads=1, out=self.states)
        return 1e9 * (time.process_time() - start) / len(self.index)


def measure(chosen: list[Size], count: int, rounds: int) -> list[dict[str, object]]:
    """Least time of a draw from each table, at random conditions and at one."""
    draws = [Draws(make_table(size), count) for size in chosen]
    best = np.full((len(chosen), 2), np.inf)
    for _ in range(rounds):
        for k, one in enumerate(draws):
            best[k] = np.minimum(best[k], [one.nanoseconds(one.spread), one.nanoseconds(one.still)])
    return [
        {
            **asdict(size),
            "value": size.value,
            "megabytes": one.table.nbytes / 1e6,
            "random_ns": times[0],
            "one_condition_ns": times[1],
        }
        for size, one, times in zip(chosen, draws, best.tolist(), strict=True)
    ]


def thread_ratio(count: int, rounds: int, threads: int = 2) -> float:
    """How many times as many draws a second several threads make as one: the best round."""
    draws = Draws(sampler.load("corundum-steel"), count)

    def seconds(number: int) -> float:
        start = time.perf_counter()
        draws.table.sample(
            *draws.spread, seed=1, index=draws.index, threads=number, out=draws.states
        )
        return time.perf_counter() - start

    seconds(threads)
    times = np.array([[seconds(1), seconds(threads)] for _ in range(rounds)])
    return float(times[:, 0].min() / times[:, 1].min())


def plot(rows: list[dict[str, object]], file: Path) -> None:
    """Plot time against each number."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 3.2), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    for panel, varied in zip(panels, ("nodes", "components", "knots"), strict=True):
        part = [row for row in rows if row["varied"] == varied]
        for key, label, marker in (
            ("random_ns", "random conditions", "o-"),
            ("one_condition_ns", "one condition", "s--"),
        ):
            panel.plot(
                [row["value"] for row in part], [row[key] for row in part], marker, label=label
            )
        panel.set(xscale="log", xlabel=varied, ylim=(0.0, None))
    panels[0].set_ylabel("ns a draw")
    panels[0].legend()
    figure.savefig(file, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=300_000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--plot", type=Path, metavar="F.png")
    parser.add_argument("--json", type=Path, metavar="F.json")
    arguments = parser.parse_args()
    rows = measure(sizes(), arguments.count, arguments.rounds)
    print(f"{'varied':12} {'number':>7} {'MB':>7} {'random ns':>10} {'one condition ns':>17}")
    for row in rows:
        print(
            f"{row['varied']:12} {row['value']:7d} {row['megabytes']:7.2f} "
            f"{row['random_ns']:10.1f} {row['one_condition_ns']:17.1f}"
        )
    ratio = thread_ratio(10 * arguments.count, arguments.rounds)
    print(f"two threads over one: {ratio:.2f} times as many draws a second")
    if arguments.plot:
        plot(rows, arguments.plot)
    if arguments.json:
        text = json.dumps({"sizes": rows, "two_threads": ratio}, indent=1)
        arguments.json.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
