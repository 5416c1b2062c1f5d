"""Measurements of a report: error against run time, accuracy map, and spinning impacts."""

import platform
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib import metadata
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import sampler
from sampler.files import find_table
from sampler.library import processors
from sampler.table import Table
from tablegen.accuracy.chains import (
    GEOMETRIES,
    LaterHit,
    Wall,
    chain_comparisons,
    first_arrivals,
    follow_grains,
    kinds_of_grains,
)
from tablegen.accuracy.comparison import Measured
from tablegen.accuracy.judgement import Judged, judge
from tablegen.accuracy.metrics import Settings, at_resolution, estimate_metrics
from tablegen.config.config import Config, stored_config
from tablegen.evidence.benchmark import (
    QUICK,
    Benchmark,
    Budget,
    batch_seed,
    best_seconds,
    run_benchmark,
)
from tablegen.evidence.methods import (
    baseline_methods,
    direct_methods,
    load_whole,
    other_table,
    table_method,
)
from tablegen.model.float_array import FloatArray
from tablegen.parallel import in_threads
from tablegen.progress import bar
from tablegen.simulation.direct import silent_model
from tablegen.simulation.impact_chains import ANY_ANGLES
from tablegen.simulation.simulate import simulate

#: Purposes of random numbers, apart from those of the benchmarks.
_DIRECT, _TABLE = 200, 202

#: Angle [rad] and speed [m/s] at which chains begin whose rebounds are timed, and the hit timed.
_TIMED_ANGLE, _TIMED_SPEED, _TIMED_HIT = np.radians(30.0), 100.0, 6


@dataclass(frozen=True)
class AccuracyMap:
    """Distances of a table from direct simulation over a grid of conditions."""

    alpha_deg: tuple[float, ...]
    speed: tuple[float, ...]
    #: All speeds of the first angle, then of the second.
    points: tuple[Measured, ...]
    #: States a side.
    samples: int


@dataclass(frozen=True)
class ComparedChain:
    """One kind of grains through sixty hits in a geometry, compared with direct simulation."""

    kind: str
    geometry: str
    #: One for each of `tablegen.accuracy.chains.GROUPS`.
    hits: tuple[LaterHit, ...]


@dataclass(frozen=True)
class SpinningWay:
    """One way to rebound particles that arrive spinning."""

    name: str
    #: Processor time of a rebound, in batches on one thread.
    batch_nanoseconds: float
    #: Worst numbers along chains; none of direct simulation, the reference.
    numbers: tuple[Judged, ...]
    #: Empty of direct simulation.
    chains: tuple[ComparedChain, ...] = ()


@dataclass(frozen=True)
class Report:
    """Measurements of a report, and how they were made."""

    #: Name or path that was given.
    table: str
    content_sha256: str
    table_bytes: int
    #: Processor time of a draw from the table at random conditions.
    random_nanoseconds: float
    quick: bool
    seed: int
    effort: Budget
    machine: dict[str, Any]
    #: Every method at each condition.
    races: tuple[Benchmark, ...]
    #: Empty if no chain begins in the range of the table.
    spinning: tuple[SpinningWay, ...]
    atlas: AccuracyMap
    #: Wall time of the measurements.
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Return every number, as JSON takes it."""
        return {"software_version": sampler.__version__, **asdict(self)}


def machine() -> dict[str, Any]:
    """Describe this machine without its name: processor, cores, system and versions."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    packages = ("numpy", "scipy", "numba", "llvmlite", "h5py", "scikit-learn")
    return {
        "processor": next(names, platform.processor() or platform.machine() or "unknown"),
        "cores": processors(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "packages": {name: metadata.version(name) for name in packages},
    }


def measure_report(
    name_or_path: str,
    beside: Sequence[str] = (),
    *,
    quick: bool = False,
    seed: int = 1,
    progress: bool = False,
) -> Report:
    """Measure the accuracy of a table, and error against run time of every method.

    ``beside`` names further tables that are compared at the same conditions; ``quick`` measures
    less. Raises `InputError` if a file is not a table, or does not hold all that is compared.
    """
    budget, begin = QUICK if quick else Budget(), time.perf_counter()
    table = load_whole(name_or_path)
    config = stored_config(table.config, f"{name_or_path}: config")
    tables = [table_method(name_or_path), *(other_table(other, table) for other in beside)]
    methods = [*direct_methods(), *tables, *baseline_methods()]
    races = [
        run_benchmark(methods, config, condition, budget, (seed, number), progress)
        for number, condition in enumerate(_conditions(table, budget))
    ]
    return Report(
        table=name_or_path,
        content_sha256=table.content_sha256,
        table_bytes=find_table(name_or_path).stat().st_size,
        random_nanoseconds=1e9 * seconds_at_random(table, budget.timed, seed),
        quick=quick,
        seed=seed,
        effort=budget,
        machine=machine(),
        races=tuple(races),
        spinning=measure_spinning(table, config, budget, seed),
        atlas=make_accuracy_map(table, config, budget, seed, progress),
        seconds=time.perf_counter() - begin,
    )


def _conditions(table: Table, budget: Budget) -> list[tuple[float, float]]:
    """Choose the angles [degrees] and speeds at which the methods are compared."""
    (first, last), (slow, fast) = np.degrees(table.alpha_range), table.speed_range
    return [
        (
            float(np.clip(round(first + a * (last - first), 1), first, last)),
            float(np.clip(round(slow + v * (fast - slow), 0), slow, fast)),
        )
        for a, v in budget.conditions
    ]


def seconds_at_random(table: Table, count: int, seed: int) -> float:
    """Time a draw at random conditions, as in a flow code, on one thread."""
    rng, index = np.random.default_rng(seed), np.arange(count)
    alpha, speed = rng.uniform(*table.alpha_range, count), rng.uniform(*table.speed_range, count)
    draw = partial(table.sample, alpha, speed, seed=seed, index=index, threads=1)
    return best_seconds(draw) / count


def grid(table: Table, shape: tuple[int, int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Choose angles [degrees] and speeds in the middle of equal parts.

    Parts are equal in the square root of the angle, because the law changes faster near grazing,
    and in the speed.
    """
    low, high = np.sqrt(np.degrees(table.alpha_range))
    roots = low + (high - low) * (np.arange(shape[0]) + 0.5) / shape[0]
    first, last = table.speed_range
    speeds = first + (last - first) * (np.arange(shape[1]) + 0.5) / shape[1]
    alpha = np.round(roots**2, 2), np.round(speeds, 1)
    return tuple(np.unique(alpha[0]).tolist()), tuple(np.unique(alpha[1]).tolist())


def make_accuracy_map(
    table: Table, config: Config, budget: Budget, seed: int, progress: bool = False
) -> AccuracyMap:
    """Compare a table with direct simulation of its configuration on a grid of conditions."""
    alpha, speed = grid(table, budget.grid)
    conditions, count = [(a, v) for a in alpha for v in speed], budget.mapped
    settings = Settings(directions=8, classified=budget.classified)

    def measured(k: int) -> Measured:
        a, v = conditions[k]
        keys = [batch_seed(seed, purpose, k) for purpose in (_DIRECT, _TABLE)]
        alpha1, index = np.radians(a), np.arange(count)
        direct = simulate(config, alpha1, v, count, seed=keys[0], threads=1).state
        drawn = table.sample(alpha1, v, seed=keys[1], index=index, threads=1)
        blurred = at_resolution(drawn, 0), at_resolution(direct, 1)
        return Measured(a, v, estimate_metrics(*blurred, settings))

    with bar(progress, total=len(conditions), desc="accuracy map") as counted:
        points = in_threads(measured, range(len(conditions)), counted.update)
    return AccuracyMap(alpha, speed, tuple(points), count)


class _FirstImpacts:
    """The law of first impacts of a table as a law of the wall for every hit."""

    def __init__(self, table: Table) -> None:
        self.table = table

    def rebound(
        self,
        velocity: FloatArray,
        normal: FloatArray,
        half_size: float,
        *,
        omega: FloatArray,
        inertia: FloatArray,
        **keys: Any,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rebound from walls; spins are ignored."""
        return self.table.rebound(velocity, normal, half_size, grain="fresh", **keys)


def measure_spinning(
    table: Table, config: Config, budget: Budget, seed: int
) -> tuple[SpinningWay, ...]:
    """Time ways to rebound spinning particles at the sixth hits of chains, and compare them there.

    Each rebound takes the four numbers of rotation that the last one gave, the angular velocity and
    the inertia about it; only the way without spin ignores them. There is no way of a table without
    a spin law that has only a part of the angles of hits.
    """
    low, high = table.alpha_range
    if not table.has_spin and (low > ANY_ANGLES[0] or high < ANY_ANGLES[1]):
        return ()
    walls: dict[str, Wall] = {
        "direct simulation": silent_model(config),
        "table, without spin": _FirstImpacts(table),
    }
    if table.has_spin:
        walls["table, with spin"] = table
    kinds = kinds_of_grains(silent_model(config), seed, 1)
    compared: dict[str, list[ComparedChain]] = {name: [] for name in walls}
    for name in list(walls)[1:]:
        chains = chain_comparisons(walls[name], config, seed, budget.chained)
        parts = in_threads(lambda chain: chain(), chains)
        of_chains = product(kinds, GEOMETRIES)
        compared[name] = [
            ComparedChain(*names, tuple(hits)) for names, hits in zip(of_chains, parts, strict=True)
        ]
    index = np.arange(budget.timed, dtype=np.uint64)
    first = first_arrivals(index, _TIMED_ANGLE, _TIMED_SPEED)
    _, arrivals = follow_grains(walls["direct simulation"], first, "any", seed, _TIMED_HIT - 1)
    ways = []
    for name, of_way in compared.items():
        cost = best_seconds(partial(arrivals.rebound, walls[name], seed), 5) / len(index)
        hits = [hit for chain in of_way for hit in chain.hits]
        numbers = tuple(judge(hits, config.spin_targets))
        ways.append(SpinningWay(name, 1e9 * cost, numbers, tuple(of_way)))
    return tuple(ways)
