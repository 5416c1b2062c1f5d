"""Nanoseconds per draw against the size of a table, and draws of two threads.

    python tests/benchmarks/bench_scaling.py

A table of one fitted node, repeated over a grid, is varied in its nodes, its mixture components and
its knots, one at a time. A draw from any of them takes the same number of random words, steps and
reads; only the time in which memory answers grows. Besides draws at random conditions, draws at one
condition are timed, which stay in the processor's cache. Times are the least of several rounds. Two
threads are timed on the shipped table, in wall-clock time.
"""

import argparse
import time
from typing import NamedTuple

from harness import in_turns  # isort: skip
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

#: Angles and speeds, components, and knots.
GRIDS = ((2, 2), (6, 3), (12, 4), (24, 6), (48, 12), (96, 24))
COMPONENTS = (32, 96, 192, 384, 768, 1536)
KNOTS = (17, 33, 65, 129, 257, 513)


class Size(NamedTuple):
    """Size of a table; one of the fields differs from its default."""

    grid: tuple[int, int] = (24, 6)
    components: int = 384
    knots: int = 129

    def __str__(self) -> str:
        nodes = self.grid[0] * self.grid[1]
        return f"{nodes:5d} nodes {self.components:5d} components {self.knots:4d} knots"


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


def draws(table, count, threads=1, one_condition=False):
    """Draw from a table at random conditions, or at one."""
    rng = np.random.default_rng(1)
    alpha1, speed = rng.uniform(*table.alpha_range, count), rng.uniform(*table.speed_range, count)
    if one_condition:
        alpha1[:], speed[:] = np.radians(CONDITION[0]), CONDITION[1]
    index, states = np.arange(count, dtype=np.uint64), np.empty((count, len(table.columns)))
    return lambda: table.sample(alpha1, speed, seed=1, index=index, threads=threads, out=states)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=300_000)
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    sizes = [Size(grid=grid) for grid in GRIDS]
    sizes += [Size(components=components) for components in COMPONENTS]
    sizes += [Size(knots=knots) for knots in KNOTS]
    tables = {str(size): make_table(size) for size in sizes}
    count = options.count
    spread = in_turns({name: draws(t, count) for name, t in tables.items()}, options.rounds)
    still = {name: draws(t, count, one_condition=True) for name, t in tables.items()}
    still = in_turns(still, options.rounds)
    print(f"{'':42} {'MB':>7} {'random ns':>10} {'one condition ns':>17}")
    for name, table in tables.items():
        times = [1e9 * min(own[name]) / count for own in (spread, still)]
        print(f"{name:42} {table.nbytes / 1e6:7.2f} {times[0]:10.1f} {times[1]:17.1f}")
    shipped = sampler.load("corundum-steel")
    threads = {str(number): draws(shipped, 10 * count, number) for number in (1, 2)}
    times = in_turns(threads, options.rounds, time.perf_counter)
    ratio = min(times["1"]) / min(times["2"])
    print(f"two threads over one: {ratio:.2f} times as many draws a second")


if __name__ == "__main__":
    main()
