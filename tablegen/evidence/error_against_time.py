"""Methods of sampling rebound states, timed and compared with direct states at one condition.

A method gives several independent batches. Each is compared with the same large sample of direct
simulation. The error is the mean over the batches, and a bootstrap over them gives its confidence
interval. Batches of direct simulation, compared in the same way, show how much chance alone gives.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

import sampler
from sampler.errors import InputError
from sampler.files import find_table
from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.accuracy.metrics import ESTIMATES, Settings
from tablegen.config.config import Config
from tablegen.config.metric_table import METRICS
from tablegen.model.float_array import FloatArray
from tablegen.parallel import in_threads
from tablegen.progress import bar
from tablegen.simulation.simulate import simulate

#: From a number of states and a seed to states (n, 6), on one thread.
Draw = Callable[[int, int], FloatArray]

#: Where a fitted method can be drawn from: at any condition, or at the one it was fitted at.
DOMAIN, CONDITION = "domain", "condition"


@dataclass(frozen=True)
class BenchmarkCase:
    """A condition at which methods are compared; the seed is that of what a method fits."""

    config: Config
    alpha_deg: float
    speed: float
    seed: int


@dataclass(frozen=True)
class SamplingMethod:
    """A method of sampling rebound states."""

    family: str
    name: str
    #: `DOMAIN` or `CONDITION`.
    covers: str
    #: Bytes that a draw reads, 0 for none.
    size: int
    #: Fit the method, or load its table.
    prepare: Callable[[BenchmarkCase], Draw]


def direct_methods() -> list[SamplingMethod]:
    """Make the methods of direct simulation: as configured, by resolution, and by tolerance."""
    varied = [("contact resolution", "contact_resolution", x) for x in (1e-1, 1e-2, 1e-4)]
    varied += [("flight tolerance", "tolerance", x) for x in (1e-4, 1e-6)]
    methods = [SamplingMethod("direct simulation", "as configured", DOMAIN, 0, simulated)]
    for words, field, value in varied:
        prepare = partial(simulated, numerics={field: value})
        name = f"{words} {value:g}"
        methods.append(SamplingMethod("direct simulation", name, DOMAIN, 0, prepare))
    return methods


def simulated(case: BenchmarkCase, numerics: dict[str, float] | None = None) -> Draw:
    """Prepare direct simulation, with other numerical parameters than the configuration's."""
    config = case.config.with_changes({"model": numerics}) if numerics else case.config

    def draw(count: int, seed: int) -> FloatArray:
        alpha1 = np.radians(case.alpha_deg)
        return simulate(config, alpha1, case.speed, count, seed=seed, threads=1).state

    return draw


def load_whole(name_or_path: str) -> Table:
    """Load a table; raise InputError if it leaves variables of a state out."""
    table = sampler.load(name_or_path)
    if table.columns != STATE:
        raise InputError(
            "",
            f"variables {', '.join(table.columns)}",
            ", ".join(STATE),
            remedy="'tablegen validate' judges any table",
            source=str(name_or_path),
        )
    return table


def table_method(name_or_path: str) -> SamplingMethod:
    """Make the method of draws from a table."""
    path = find_table(name_or_path)

    def prepare(case: BenchmarkCase) -> Draw:
        table, alpha1 = sampler.load(path), math.radians(case.alpha_deg)

        def draw(count: int, seed: int) -> FloatArray:
            return table.sample(alpha1, case.speed, seed=seed, index=np.arange(count), threads=1)

        return draw

    size = path.stat().st_size
    return SamplingMethod("table", Path(name_or_path).stem, DOMAIN, size, prepare)


def other_table(name_or_path: str, table: Table) -> SamplingMethod:
    """Make the method of draws from another table of the same pair, wherever `table` can be drawn.

    Raises `InputError` if the pair is another, variables are left out, or the range does not hold
    that of `table`.
    """
    other = load_whole(name_or_path)
    if other.pair != table.pair:
        raise InputError("pair", other.pair, table.pair, source=str(name_or_path))
    for name in ("alpha_nodes_deg", "speed_nodes"):
        (low, high), (first, last) = (getattr(one, name)[[0, -1]] for one in (table, other))
        if first > low or last < high:
            given, allowed = f"{first:g} to {last:g}", f"{low:g} to {high:g} or more (degrees, m/s)"
            raise InputError(name, given, allowed, source=str(name_or_path))
    return table_method(name_or_path)


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
    #: Bytes that a draw reads; the whole file of a table; 0 for none.
    bytes: int
    #: Processor time to make it ready: a fit, or the load of a table [s].
    setup_seconds: float
    #: Processor time of one draw on one thread.
    nanoseconds: float
    #: By metric.
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


def batch_errors(
    draw: Draw, reference: FloatArray, budget: Budget, batch: int, seed: int
) -> dict[str, float]:
    """Measure the `METRICS` of one batch.

    The classifier sees other states of the reference in every batch.
    """
    state, few = draw(budget.batch, seed), min(budget.classified, budget.batch)
    start = batch * few % (len(reference) - few + 1)
    errors = {}
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
                draw = method.prepare(case)
            setup = time.process_time() - start
            work = partial(draw, budget.timed, batch_seed(key, TIMED))
            ready.append((method, draw, setup, 1e9 * best_seconds(work) / budget.timed))
            counted.update()
        draws = [simulated(case), *(draw for _, draw, *_ in ready)]
        errors = _all_errors(draws, reference, budget, key, counted.update)
    runners = tuple(
        MethodResult(m.family, m.name, m.covers, m.size, setup, cost, error)
        for (m, _, setup, cost), error in zip(ready, errors[1:], strict=True)
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
