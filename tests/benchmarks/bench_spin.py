"""Nanoseconds per draw with and without spin, beside direct simulation, at impacts that occur.

    python tests/benchmarks/bench_spin.py
    python tests/benchmarks/bench_spin.py --table T.h5 --rounds 15 --json spin.json

The impacts are the second to the sixth of chains on one wall or between two, by direct simulation
of particles that keep their grains. Every way rebounds the same ones on one thread, in batches and
one by one in compiled code; all take turns in every round. Times are processor time, the least of
all rounds.
"""

import argparse
import json
import warnings
from pathlib import Path

import checkout  # noqa: F401  (before the imports that it makes possible)
import numpy as np
from tablegen.evidence.report_text import ratio_lines
from tablegen.evidence.spinning_impacts import (
    SpinningImpacts,
    SpinningWay,
    nanoseconds,
    works,
)

import sampler
from tablegen.config.config import stored_config
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import occurring_impacts


def measured(table: sampler.Table, count: int, rounds: int, seed: int = 1) -> SpinningImpacts:
    """Time every way at the impacts of so many particles; errors are left out."""
    config = stored_config(table.config, "config")
    model = DirectModel(config)
    impacts = occurring_impacts(config, model, seed, np.arange(count, dtype=np.uint64))
    size = len(impacts.index)
    with warnings.catch_warnings():
        # today's law may begin at higher speeds than particles have after some walls
        warnings.simplefilter("ignore", sampler.OutsideTableWarning)
        costs = nanoseconds(works(table, model, impacts, seed), size, rounds)
    ways = (SpinningWay(name, *both, {}, 0) for name, both in costs.items())
    return SpinningImpacts(size, tuple(ways))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--table", default="corundum-steel")
    parser.add_argument("--count", type=int, default=500_000, help="particles")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    table = sampler.load(arguments.table)
    found = measured(table, arguments.count, arguments.rounds)
    print(f"{'ns per rebound':20} {'batch':>9} {'one by one':>11}")
    for way in found.ways:
        print(f"{way.name:20} {way.batch_nanoseconds:9.1f} {way.single_nanoseconds:11.1f}")
    print(*ratio_lines(found), sep="\n")
    if arguments.json:
        rows = {w.name: [w.batch_nanoseconds, w.single_nanoseconds] for w in found.ways}
        record = {"table": arguments.table, "nanoseconds": rows, "ratios": found.ratios()}
        arguments.json.write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
