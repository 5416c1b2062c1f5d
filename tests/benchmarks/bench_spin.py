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
import time
import warnings
from functools import partial
from pathlib import Path

import checkout  # noqa: F401  (before the imports that it makes possible)
import numpy as np
import one_by_one
from threadpoolctl import threadpool_limits

import sampler
from tablegen.accuracy.joint_law import drawn_from
from tablegen.config.config import stored_config
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import occurring_impacts, simulated

#: Ways of a rebound.
DIRECT, SPINNING, FIRST = "direct simulation", "table, with spin", "table, without spin"


def works(table, model, impacts, seed):
    """Each way's work on all impacts, on one thread: as a batch, and one by one."""
    alpha1, speed, spin = impacts.alpha1, impacts.speed, impacts.spin
    keys = np.uint64(seed), impacts.index, impacts.hit
    state, work = np.empty(6), np.empty(model.work_size)
    found = {
        DIRECT: (
            lambda: simulated(model, impacts, seed, 1),
            lambda: one_by_one.simulate_spinning(
                model.arrays, alpha1, speed, spin, *keys, work, state
            ),
        ),
        FIRST: (
            partial(drawn_from(table, seed, 1, spin=False), impacts),
            lambda: one_by_one.draw_first_hits(table.arrays, alpha1, speed, *keys, state),
        ),
    }
    if table.has_spin:
        found[SPINNING] = (
            partial(drawn_from(table, seed, 1), impacts),
            lambda: one_by_one.draw_spinning(table.arrays, alpha1, speed, spin, *keys, state),
        )
    return found


def nanoseconds(found, count, rounds):
    """Processor time of one rebound by way, in batches and one by one; the best of some rounds.

    All take turns in every round, so that other load on the machine meets all of them.
    """
    best = {name: [np.inf, np.inf] for name in found}
    with threadpool_limits(limits=1):
        for turn in range(rounds + 1):
            for name, both in found.items():
                for k, work in enumerate(both):
                    begin = time.process_time()
                    work()
                    passed = time.process_time() - begin
                    if turn:  # the first compiles
                        best[name][k] = min(best[name][k], 1e9 * passed / count)
    return best


def measured(table: sampler.Table, count: int, rounds: int, seed: int = 1) -> dict:
    """Time every way at the impacts of some particles, in batches and one by one."""
    config = stored_config(table.config, "config")
    model = DirectModel(config)
    impacts = occurring_impacts(config, model, seed, np.arange(count, dtype=np.uint64))
    with warnings.catch_warnings():
        # the law without spin may begin at higher speeds than particles have after some walls
        warnings.simplefilter("ignore", sampler.OutsideTableWarning)
        return nanoseconds(works(table, model, impacts, seed), len(impacts.index), rounds)


def ratios(found: dict) -> dict[str, float]:
    """Costs of a draw with spin over others; nothing for a table without a spin law."""
    if SPINNING not in found:
        return {}
    spin, first, direct = found[SPINNING], found[FIRST], found[DIRECT]
    return {
        "batch, with over without spin": spin[0] / first[0],
        "one by one, with over without spin": spin[1] / first[1],
        "direct one by one over a batch's draw with spin": direct[1] / spin[0],
        "direct over a draw with spin, one by one": direct[1] / spin[1],
    }


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
    for name, (batch, single) in found.items():
        print(f"{name:20} {batch:9.1f} {single:11.1f}")
    print(*(f"{name}: {ratio:.2f}" for name, ratio in ratios(found).items()), sep="\n")
    if arguments.json:
        record = {"table": arguments.table, "nanoseconds": found, "ratios": ratios(found)}
        arguments.json.write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
