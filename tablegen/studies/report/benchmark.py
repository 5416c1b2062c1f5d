"""All ways to get a rebound state at one condition: set up, timed, compared with direct states."""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from sampler.compilation.processors import processors
from tablegen.accuracy.metrics import Reference
from tablegen.config import Config
from tablegen.studies.report.budget import Effort
from tablegen.studies.report.direct_method import direct_states
from tablegen.studies.report.method_errors import Draw, Estimate, batch_errors, batch_seed, gathered
from tablegen.studies.report.sampling_methods import Prepared, Scene, Way

#: What random numbers are for, so that no two purposes share any.
REFERENCE, TRAINING, FLOOR, FIT, TIMED, BATCHES = range(6)

#: Timings of which the best counts: what else the machine does only adds.
_TIMINGS = 3

#: Called as work gets done, with the number of steps.
Tick = Callable[[int], Any]


@dataclass(frozen=True)
class Runner:
    """How a way did at one condition.

    Attributes
    ----------
    family, name, covers, settings
        Of the way.
    alpha_deg, speed : float
    bytes : int
        What a draw reads; the whole file of a table.
    setup_seconds : float
        Worker seconds to make it ready: fit, generation, or load of an existing table.
    nanoseconds : float
        Processor time of one draw on one thread.
    errors : dict from metric to Estimate
    facts : dict
    """

    family: str
    name: str
    covers: str
    settings: dict[str, Any]
    alpha_deg: float
    speed: float
    bytes: int
    setup_seconds: float
    nanoseconds: float
    errors: dict[str, Estimate]
    facts: dict[str, Any]


@dataclass(frozen=True)
class Race:
    """All ways at one condition.

    Attributes
    ----------
    alpha_deg, speed : float
    floor : dict from metric to Estimate
        Direct batches against the direct reference.
    runners : tuple of Runner
    """

    alpha_deg: float
    speed: float
    floor: dict[str, Estimate]
    runners: tuple[Runner, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and names, for JSON."""
        return asdict(self)


def make_scene(
    config: Config, alpha_deg: float, speed: float, effort: Effort, seed: int, place: int
) -> tuple[Scene, Reference]:
    """Simulate the reference of a condition, and states to fit rivals on.

    Parameters
    ----------
    config : Config
    alpha_deg, speed : float
    effort : Effort
    seed : int
    place : int
        Number of the condition; conditions share no random numbers.
    """

    def states(purpose: int, count: int) -> np.ndarray:
        return direct_states(config, alpha_deg, speed, count, batch_seed(seed, place, purpose))

    scene = Scene(
        config,
        alpha_deg,
        speed,
        states(TRAINING, effort.training),
        batch_seed(seed, place, FIT),
    )
    return scene, Reference(states(REFERENCE, effort.reference))


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


def prepare(way: Way, scene: Scene) -> tuple[Prepared, float]:
    """Set a way up; the worker seconds that this took."""
    start = time.process_time()
    with threadpool_limits(limits=1):
        ready = way.prepare(scene)
    passed = time.process_time() - start
    return ready, passed if ready.setup is None else ready.setup


def measured_errors(
    draws: Sequence[Draw],
    reference: Reference,
    effort: Effort,
    seeds: Callable[[int, int], int],
    tick: Tick,
) -> list[dict[str, Estimate]]:
    """Errors of several draws, their batches shared out over the processors.

    Parameters
    ----------
    draws : sequence of Draw
    reference : Reference
    effort : Effort
    seeds : callable
        From the number of a draw and of a batch to a seed.
    tick : callable
        Called with 1 as each batch is done.
    """
    found: list[list[dict[str, float]]] = [[{} for _ in range(effort.batches)] for _ in draws]
    # the classifier asks for one thread by itself; asked from several at once, it might keep it
    with threadpool_limits(limits=1), ThreadPoolExecutor(processors()) as pool:
        waiting = {
            pool.submit(
                batch_errors, draw, reference, effort.batch, effort.classified, r, seeds(k, r)
            ): (k, r)
            for k, draw in enumerate(draws)
            for r in range(effort.batches)
        }
        for future in as_completed(waiting):
            k, r = waiting[future]
            found[k][r] = future.result()
            tick(1)
    return [gathered(batches) for batches in found]


def run_race(
    ways: Sequence[Way], scene: Scene, reference: Reference, effort: Effort, tick: Tick
) -> Race:
    """Set up, time and judge all ways at one condition.

    Setting up and timing come first, one way after the other, while nothing else runs.

    Parameters
    ----------
    ways : sequence of Way
    scene : Scene
    reference : Reference
    effort : Effort
    tick : callable
        Called with 1 for each way that is ready and each batch that is judged.
    """
    ready: list[tuple[Prepared, float, float]] = []
    for way in ways:
        prepared, setup = prepare(way, scene)
        cost = nanoseconds(prepared.draw, effort.timed, batch_seed(scene.seed, TIMED))
        ready.append((prepared, setup, cost))
        tick(1)

    def floor(count: int, seed: int) -> np.ndarray:
        return direct_states(scene.config, scene.alpha_deg, scene.speed, count, seed, threads=1)

    errors = measured_errors(
        [floor, *(prepared.draw for prepared, _, _ in ready)],
        reference,
        effort,
        lambda k, r: batch_seed(scene.seed, BATCHES if k else FLOOR, k, r),
        tick,
    )
    runners = tuple(
        Runner(
            family=way.family,
            name=way.name,
            covers=way.covers,
            settings=way.settings,
            alpha_deg=scene.alpha_deg,
            speed=scene.speed,
            bytes=prepared.size,
            setup_seconds=setup,
            nanoseconds=cost,
            errors=error,
            facts=prepared.facts,
        )
        for way, (prepared, setup, cost), error in zip(ways, ready, errors[1:], strict=True)
    )
    return Race(scene.alpha_deg, scene.speed, errors[0], runners)


def steps(ways: int, effort: Effort) -> int:
    """How often `run_race` ticks."""
    return ways + (ways + 1) * effort.batches
