"""All methods of sampling at one condition: fitted, timed, and compared with direct states.

A method gives several independent batches. Each is compared with the same large direct reference;
the error is the mean over the batches, and a bootstrap over them gives its confidence interval.
Direct batches, compared in the same way, are the noise floor: no method can be seen to be better.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from tablegen.accuracy.metrics import ESTIMATES, Settings
from tablegen.config.config import Config
from tablegen.config.metric_table import METRICS
from tablegen.evidence.methods import BenchmarkCase, Draw, SamplingMethod, simulated
from tablegen.model.float_array import FloatArray
from tablegen.parallel import in_threads
from tablegen.progress import bar
from tablegen.simulation.simulate import simulate

#: Purposes of random numbers; no two share any.
REFERENCE, FLOOR, FIT, TIMED, BATCHES = range(5)

#: Directions of the sliced Wasserstein distance.
_DIRECTIONS = 32


@dataclass(frozen=True)
class Budget:
    """Sizes of all that a report measures; the defaults take up to three minutes on two cores."""

    #: States of the direct reference at a condition, a multiple of those in a batch.
    reference: int = 200_000
    #: States in a batch, batches per method, and states a side of the classifier.
    batch: int = 50_000
    batches: int = 4
    classified: int = 20_000
    #: Draws that are timed together.
    timed: int = 100_000
    #: Where the methods are compared, as shares of the table's range of angles and speeds.
    conditions: tuple[tuple[float, float], ...] = ((0.11, 0.13), (0.75, 0.5))
    #: Particles a side of each chain of hits.
    chained: int = 10_000


#: Half a minute on two cores.
QUICK = Budget(
    reference=100_000,
    batch=20_000,
    classified=10_000,
    timed=50_000,
    conditions=((0.75, 0.5),),
    chained=3_000,
)


@dataclass(frozen=True)
class BatchMean:
    """Mean over batches and its 95 % confidence interval."""

    mean: float
    low: float
    high: float
    values: tuple[float, ...]


@dataclass(frozen=True)
class MethodResult:
    """Cost and errors of a method at one condition."""

    family: str
    name: str
    covers: str
    #: Bytes that a draw reads; the whole file of a table.
    bytes: int
    #: Processor time to make it ready: a fit, or the load of a table [s].
    setup_seconds: float
    #: Processor time of one draw on one thread.
    nanoseconds: float
    #: By metric, and "forbidden": the share of states that no rebound can have.
    errors: dict[str, BatchMean]


@dataclass(frozen=True)
class Benchmark:
    """All methods at one condition; the floor is by metric."""

    alpha_deg: float
    speed: float
    floor: dict[str, BatchMean]
    runners: tuple[MethodResult, ...]


def batch_seed(seed: int, *purpose: int) -> int:
    """Make the seed of one purpose, independent of all others."""
    return int(np.random.SeedSequence([seed, *purpose]).generate_state(1, np.uint64)[0])


def batch_mean(values: Sequence[float]) -> BatchMean:
    """Average over batches, with a percentile interval of 2,000 bootstrapped means."""
    array = np.asarray(values, dtype=np.float64)
    picks = np.random.default_rng(len(array)).integers(len(array), size=(2000, len(array)))
    low, high = np.quantile(array[picks].mean(axis=1), (0.025, 0.975))
    return BatchMean(float(array.mean()), float(low), float(high), tuple(array.tolist()))


def forbidden_share(state: FloatArray) -> float:
    """Share of states that no rebound can have: v <= 0, or translational energy above 1."""
    energy = np.square(state[:, :3]).sum(axis=1)
    return float(np.mean((state[:, 1] <= 0.0) | (energy > 1.0)))


def batch_errors(
    draw: Draw, reference: FloatArray, budget: Budget, batch: int, seed: int
) -> dict[str, float]:
    """Measure the `METRICS` and the forbidden share of one batch.

    The classifier sees other states of the reference in every batch.
    """
    state, few = draw(budget.batch, seed), min(budget.classified, budget.batch)
    start = batch * few % (len(reference) - few + 1)
    errors = {"forbidden": forbidden_share(state)}
    for name, metric in METRICS.items():
        if metric.learned:
            part = reference[start : start + few]
            estimate = ESTIMATES[name](state[:few], part, Settings(batch, classified=None))
        else:
            estimate = ESTIMATES[name](state, reference, Settings(0, _DIRECTIONS))
        errors[name] = estimate.value
    return errors


def best_seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """Time a call on one thread [processor time], the best of some repeats after a first call."""
    work()
    best = np.inf
    with threadpool_limits(limits=1):
        for _ in range(repeats):
            start = time.process_time()
            work()
            best = min(best, time.process_time() - start)
    return float(best)


def run_benchmark(
    methods: Sequence[SamplingMethod],
    config: Config,
    condition: tuple[float, float],
    budget: Budget,
    seeds: tuple[int, int],
    progress: bool = False,
) -> Benchmark:
    """Fit and time all methods at one condition, and measure their errors.

    Fits and timings come first, one method after the other, while nothing else runs. The condition
    is an impact angle [degrees] and a speed [m/s]; ``seeds`` are the seed of the report and the
    number of the condition.
    """
    alpha_deg, speed = condition

    key, count = batch_seed(*seeds, FIT), budget.reference
    case = BenchmarkCase(config, alpha_deg, speed, key)
    purpose = batch_seed(*seeds, REFERENCE)
    reference = simulate(config, np.radians(alpha_deg), speed, count, seed=purpose).state
    ready = []
    count = len(methods) + (len(methods) + 1) * budget.batches
    with bar(progress, total=count, desc=f"methods at {alpha_deg:g} deg") as counted:
        for method in methods:
            start = time.process_time()
            with threadpool_limits(limits=1):
                fitted = method.prepare(case)
            setup = time.process_time() - start
            draw = partial(fitted.draw, budget.timed, batch_seed(key, TIMED))
            cost = 1e9 * best_seconds(draw) / budget.timed
            ready.append((method, fitted, setup, cost))
            counted.update()
        draws = [simulated(case).draw, *(fitted.draw for _, fitted, *_ in ready)]
        errors = _all_errors(draws, reference, budget, key, counted.update)
    runners = tuple(
        MethodResult(m.family, m.name, m.covers, fitted.size, setup, cost, error)
        for (m, fitted, setup, cost), error in zip(ready, errors[1:], strict=True)
    )
    return Benchmark(alpha_deg, speed, errors[0], runners)


def _all_errors(
    draws: Sequence[Draw], reference: FloatArray, budget: Budget, key: int, tick: Any
) -> list[dict[str, BatchMean]]:
    """Measure the errors of all draws, of which the first is the floor."""

    def errors(piece: tuple[int, int]) -> dict[str, float]:
        k, r = piece
        seed = batch_seed(key, BATCHES if k else FLOOR, k, r)
        return batch_errors(draws[k], reference, budget, r, seed)

    pieces = [(k, r) for k in range(len(draws)) for r in range(budget.batches)]
    measured = in_threads(errors, pieces, tick)
    parts = [measured[k : k + budget.batches] for k in range(0, len(measured), budget.batches)]
    return [{name: batch_mean([b[name] for b in part]) for name in part[0]} for part in parts]
