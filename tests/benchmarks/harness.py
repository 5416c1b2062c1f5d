"""Shared by the benchmarks: imports from a checkout, and timing of several functions in turns."""

import runpy
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

HERE = Path(__file__).resolve().parent
TESTS, ROOT = HERE.parent, HERE.parents[1]

for _folder in (TESTS, TESTS / "embedding", TESTS / "reference", ROOT / "tools", ROOT):
    sys.path.insert(0, str(_folder))

# Compiled kernels are cached in a folder of their own for each state of the sources.
runpy.run_path(str(TESTS / "conftest.py"))


def in_turns(
    timed: Mapping[str, Callable[[], object]],
    rounds: int,
    clock: Callable[[], float] = time.process_time,
) -> dict[str, list[float]]:
    """Measure the seconds of each function in each round, after one call that is not counted.

    The order rotates from round to round, so that a slow spell of the machine meets all functions.
    """
    names = list(timed)
    seconds: dict[str, list[float]] = {name: [] for name in names}
    for function in timed.values():
        function()
    for turn in range(rounds):
        first = turn % len(names)
        for name in names[first:] + names[:first]:
            start = clock()
            timed[name]()
            seconds[name].append(clock() - start)
    return seconds


def median_ratio(times: list[float], base: list[float]) -> float:
    """Median over all rounds of the ratio of two times of the same round."""
    return statistics.median(t / b for t, b in zip(times, base, strict=True))
