"""Error against run time for particles that arrive spinning: table and direct simulation.

The impacts are those that occur in chains. Every way is timed at the same ones, in batches and one
by one; its error is that of the law of condition, grain and outcome.
"""

import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.errors import OutsideTableWarning
from sampler.table import Table
from tablegen.accuracy.joint_law import Draw, compare_chains, drawn_from, share_inside
from tablegen.accuracy.noise_corrected import Estimate
from tablegen.config.config import Config
from tablegen.config.targets import JointTargets
from tablegen.evidence import one_by_one
from tablegen.evidence.budget import Budget
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import Impacts, occurring_impacts, simulated

#: Ways of a rebound.
DIRECT, SPINNING, FIRST = "direct simulation", "table, with spin", "table, without spin"

#: Accuracy that any law has, so that none is looked at twice.
_ANY = JointTargets(ks=1.0, auc=1.0)

#: Rounds of timings of which the best counts: what else the machine does only adds.
_ROUNDS = 5

#: Works on all impacts once.
Work = Callable[[], object]


@dataclass(frozen=True)
class SpinningWay:
    """One way to rebound spinning particles."""

    name: str
    #: Processor time of a rebound, in batches and one by one.
    batch_nanoseconds: float
    single_nanoseconds: float
    #: Over the impacts of chains, by metric; of direct simulation, two samples of it.
    estimates: dict[str, Estimate]
    #: Impacts a side.
    states: int


@dataclass(frozen=True)
class SpinningImpacts:
    """All ways, timed in one run."""

    #: Impacts that were timed.
    timed: int
    ways: tuple[SpinningWay, ...]

    def ratios(self) -> dict[str, float]:
        """Compare the costs of a draw with spin; nothing of a table without spin law.

        Returns
        -------
        dict
            Over a draw without spin, in batches and one by one; and direct simulation one by one
            over a draw with spin, in batches and one by one.
        """
        of = {way.name: way for way in self.ways}
        if SPINNING not in of:
            return {}
        spin, first, direct = of[SPINNING], of[FIRST], of[DIRECT]
        return {
            "batch, with over without spin": spin.batch_nanoseconds / first.batch_nanoseconds,
            "one by one, with over without spin": spin.single_nanoseconds
            / first.single_nanoseconds,
            "direct one by one over a batch's draw with spin": direct.single_nanoseconds
            / spin.batch_nanoseconds,
            "direct over a draw with spin, one by one": direct.single_nanoseconds
            / spin.single_nanoseconds,
        }


def works(
    table: Table, model: DirectModel, impacts: Impacts, seed: int
) -> dict[str, tuple[Work, Work]]:
    """Give each way's work on all impacts, on one thread: as a batch, and one by one.

    Parameters
    ----------
    table : Table
    model : DirectModel
    impacts : Impacts
    seed : int
    """
    alpha1, speed, spin = impacts.alpha1, impacts.speed, impacts.spin
    keys = np.uint64(seed), impacts.index, impacts.hit
    state, work = np.empty(6), np.empty(model.work_size)
    found: dict[str, tuple[Work, Work]] = {
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


def nanoseconds(
    found: Mapping[str, tuple[Work, Work]], count: int, rounds: int = _ROUNDS
) -> dict[str, tuple[float, float]]:
    """Processor time of one rebound of so many, in batches and one by one; the best of some rounds.

    All take turns in every round, so that what else the machine does meets all of them.
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
                        best[name][k] = min(best[name][k], passed)
    return {name: (1e9 * a / count, 1e9 * b / count) for name, (a, b) in best.items()}


def measure_spinning_impacts(
    table: Table, config: Config, budget: Budget, seed: int, tick: Callable[[int], Any]
) -> SpinningImpacts | None:
    """Time and compare all ways at the impacts that occur.

    Parameters
    ----------
    table : Table
        With or without a spin law.
    config : Config
        Of the table.
    budget : Budget
    seed : int
    tick : callable
        Called with 1 as each way is done.

    Returns
    -------
    SpinningImpacts or None
        None of a table of so few angles or speeds that no chain stays there.
    """
    share, model = share_inside(config, seed), DirectModel(config)
    pilot = np.arange(int(budget.timed / max(share, 0.01)), dtype=np.uint64)
    impacts = occurring_impacts(config, model, seed, pilot, 1)
    draws: dict[str, Draw] = {
        DIRECT: lambda chains: simulated(model, chains, seed),
        FIRST: drawn_from(table, seed, spin=False),
        SPINNING: drawn_from(table, seed),
    }
    ready, ways = works(table, model, impacts, seed), []
    how: dict[str, Any] = {"seed": seed, "samples": budget.chained, "targets": _ANY}
    with warnings.catch_warnings():
        # today's law may begin at higher speeds than particles have after some walls
        warnings.simplefilter("ignore", OutsideTableWarning)
        for name in ready:
            found = compare_chains(draws[name], config, **how)
            tick(1)
            if found is None:
                return None
            ways.append((name, found))
        costs = nanoseconds(ready, len(impacts.index))
    return SpinningImpacts(
        len(impacts.index),
        tuple(SpinningWay(n, *costs[n], found.estimates, found.states) for n, found in ways),
    )
