"""The error of a sample against the time it takes to draw: direct simulation and table.

A small sample is uncertain whatever it is drawn from. With more states the error of direct
simulation falls on; that of a table falls as fast, sooner, until its own error is left.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from tablegen.accuracy.metrics import Reference
from tablegen.evidence.benchmark import Tick
from tablegen.evidence.budget import Budget
from tablegen.evidence.method_errors import (
    BatchMean,
    Draw,
    batch_errors,
    batch_seed,
    gathered,
)

#: Purpose of the random numbers, apart from those of `tablegen.evidence.benchmark`.
_SIZES = 100


@dataclass(frozen=True)
class Sample:
    """Error of samples of one size."""

    family: str
    #: States in a sample.
    count: int
    #: Processor time of such a sample on one thread.
    seconds: float
    #: By metric. Without AUC, which small samples cannot train.
    errors: dict[str, BatchMean]


def sample_sizes(
    draws: Sequence[tuple[str, Draw, float]],
    reference: Reference,
    budget: Budget,
    seed: int,
    tick: Callable[[int], Any] | Tick,
) -> list[Sample]:
    """Error against sample size.

    Parameters
    ----------
    draws : sequence of (family, Draw, nanoseconds of a draw)
    reference : Reference
    budget : Budget
    seed : int
    tick : callable
        Called with 1 for each size of each draw.
    """
    found = []
    for k, (family, draw, cost) in enumerate(draws):
        for count in budget.sizes:
            batches = [
                batch_errors(draw, reference, count, 0, r, batch_seed(seed, _SIZES, k, count, r))
                for r in range(budget.batches)
            ]
            found.append(Sample(family, count, 1e-9 * cost * count, gathered(batches)))
            tick(1)
    return found
