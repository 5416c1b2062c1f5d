"""All methods of sampling at one condition: fitted, timed, compared with direct states."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from tablegen.accuracy.measure import in_threads
from tablegen.accuracy.metrics import Reference
from tablegen.config.config import Config
from tablegen.evidence.budget import Budget
from tablegen.evidence.direct_method import simulated
from tablegen.evidence.method_errors import (
    BatchMean,
    Draw,
    batch_errors,
    batch_seed,
    gathered,
)
from tablegen.evidence.sampling_methods import BenchmarkCase, FittedMethod, SamplingMethod
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import simulate

#: What random numbers are for, so that no two purposes share any.
REFERENCE, TRAINING, FLOOR, FIT, TIMED, BATCHES = range(6)

#: Timings of which the best counts: what else the machine does only adds.
_TIMINGS = 3

#: Called as work gets done, with the number of steps.
Tick = Callable[[int], Any]


@dataclass(frozen=True)
class MethodResult:
    """Cost and errors of a method at one condition."""

    #: Of the method.
    family: str
    name: str
    covers: str
    settings: dict[str, Any]
    alpha_deg: float
    speed: float
    #: What a draw reads; the whole file of a table.
    bytes: int
    #: Worker seconds to make it ready: fit, generation, or load of an existing table.
    setup_seconds: float
    #: Processor time of one draw on one thread.
    nanoseconds: float
    #: By metric.
    errors: dict[str, BatchMean]
    facts: dict[str, Any]


@dataclass(frozen=True)
class Benchmark:
    """All methods at one condition."""

    alpha_deg: float
    speed: float
    #: By metric. Direct batches against the direct reference.
    floor: dict[str, BatchMean]
    runners: tuple[MethodResult, ...]


def make_case(
    config: Config, alpha_deg: float, speed: float, budget: Budget, seed: int, place: int
) -> tuple[BenchmarkCase, Reference]:
    """Simulate the reference of a condition, and states to fit baselines to.

    Parameters
    ----------
    config : Config
    alpha_deg, speed : float
    budget : Budget
    seed : int
    place : int
        Number of the condition; conditions share no random numbers.
    """

    def states(purpose: int, count: int) -> FloatArray:
        key = batch_seed(seed, place, purpose)
        return simulate(config, np.radians(alpha_deg), speed, count, seed=key).state

    training, key = states(TRAINING, budget.training), batch_seed(seed, place, FIT)
    case = BenchmarkCase(config, alpha_deg, speed, training, key)
    return case, Reference(states(REFERENCE, budget.reference))


def nanoseconds(draw: Draw, count: int, seed: int) -> float:
    """Processor time of one draw on one thread, the best of a few."""
    draw(min(count, 1000), seed)
    best = np.inf
    with threadpool_limits(limits=1):
        for _ in range(_TIMINGS):
            start = time.process_time()
            draw(count, seed)
            best = min(best, time.process_time() - start)
    return 1e9 * float(best) / count


def prepare(method: SamplingMethod, case: BenchmarkCase) -> tuple[FittedMethod, float]:
    """Fit a method; the worker seconds that this took."""
    start = time.process_time()
    with threadpool_limits(limits=1):
        ready = method.prepare(case)
    passed = time.process_time() - start
    return ready, passed if ready.setup is None else ready.setup


def measured_errors(
    draws: Sequence[Draw],
    reference: Reference,
    budget: Budget,
    seeds: Callable[[int, int], int],
    tick: Tick,
) -> list[dict[str, BatchMean]]:
    """Errors of several draws, their batches shared out over the processors.

    Parameters
    ----------
    draws : sequence of Draw
    reference : Reference
    budget : Budget
    seeds : callable
        From the number of a draw and of a batch to a seed.
    tick : callable
        Called with 1 as each batch is done.
    """
    count, size = budget.batches, budget.batch

    def errors(piece: tuple[int, int]) -> dict[str, float]:
        k, r = piece
        return batch_errors(draws[k], reference, size, budget.classified, r, seeds(k, r))

    # the classifier asks for one thread by itself; asked from several at once, it might keep it
    pieces = [(k, r) for k in range(len(draws)) for r in range(count)]
    found = in_threads(errors, pieces, tick)
    return [gathered(found[k * count : (k + 1) * count]) for k in range(len(draws))]


def run_benchmark(
    methods: Sequence[SamplingMethod],
    case: BenchmarkCase,
    reference: Reference,
    budget: Budget,
    tick: Tick,
) -> Benchmark:
    """Fit and time all methods at one condition, and measure their errors.

    Fits and timings come first, one method after the other, while nothing else runs.

    Parameters
    ----------
    methods : sequence of SamplingMethod
    case : BenchmarkCase
    reference : Reference
    budget : Budget
    tick : callable
        Called with 1 for each method that is ready and each batch that is measured.
    """
    ready: list[tuple[FittedMethod, float, float]] = []
    for method in methods:
        fitted, setup = prepare(method, case)
        cost = nanoseconds(fitted.draw, budget.timed, batch_seed(case.seed, TIMED))
        ready.append((fitted, setup, cost))
        tick(1)
    errors = measured_errors(
        [simulated(case).draw, *(fitted.draw for fitted, _, _ in ready)],
        reference,
        budget,
        lambda k, r: batch_seed(case.seed, BATCHES if k else FLOOR, k, r),
        tick,
    )
    runners = tuple(
        MethodResult(
            family=method.family,
            name=method.name,
            covers=method.covers,
            settings=method.settings,
            alpha_deg=case.alpha_deg,
            speed=case.speed,
            bytes=fitted.size,
            setup_seconds=setup,
            nanoseconds=cost,
            errors=error,
            facts=fitted.facts,
        )
        for method, (fitted, setup, cost), error in zip(methods, ready, errors[1:], strict=True)
    )
    return Benchmark(case.alpha_deg, case.speed, errors[0], runners)


def steps(methods: int, budget: Budget) -> int:
    """How often `run_benchmark` ticks."""
    return methods + (methods + 1) * budget.batches
