"""Error against run time of tables and of direct simulation, at first impacts and later hits."""

import platform
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

import sampler
from sampler.files import find_table
from sampler.library import processors
from sampler.table import Table
from tablegen.accuracy.chains import Wall, chain_comparisons, first_arrivals, follow_grains
from tablegen.accuracy.judgement import Judged, judge
from tablegen.config.config import Config, stored_config
from tablegen.config.metric_table import CHAINS, METRICS
from tablegen.evidence.error_against_time import (
    QUICK,
    BatchMean,
    Benchmark,
    Budget,
    best_seconds,
    run_benchmark,
)
from tablegen.evidence.methods import direct_methods, load_whole, other_table, table_method
from tablegen.evidence.pictures import errors_picture
from tablegen.model.float_array import FloatArray
from tablegen.parallel import in_threads
from tablegen.presentation import TextTable
from tablegen.simulation.direct import silent_model
from tablegen.simulation.impact_chains import ANY_ANGLES

#: Angle [rad] and speed [m/s] at which chains begin whose rebounds are timed, and the hit timed.
_TIMED_ANGLE, _TIMED_SPEED, _TIMED_HIT = np.radians(30.0), 100.0, 6

_HEADS = [metric.head for metric in METRICS.values()]
METHOD_HEAD = ("method", "ns/draw", "bytes", "set-up s", *_HEADS, "forbidden")
SPINNING_HEAD = ("law of the wall", "ns/rebound", "KS", "energy", "squared spin", "angle")


@dataclass(frozen=True)
class SpinningWay:
    """One way to rebound particles that arrive spinning."""

    name: str
    #: Processor time of a rebound, in batches on one thread.
    nanoseconds: float
    #: Worst numbers along chains; none of direct simulation, the reference.
    numbers: tuple[Judged, ...]


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
    """Measure error against run time of a table and of direct simulation.

    ``beside`` names further tables that are compared at the same conditions; ``quick`` measures
    less. Raises `InputError` if a file is not a table, or does not hold all that is compared.
    """
    budget, begin = QUICK if quick else Budget(), time.perf_counter()
    table = load_whole(name_or_path)
    config = stored_config(table.config, f"{name_or_path}: config")
    tables = [table_method(name_or_path), *(other_table(other, table) for other in beside)]
    races = [
        run_benchmark(
            [*direct_methods(), *tables], config, condition, budget, (seed, number), progress
        )
        for number, condition in enumerate(conditions_of(table, budget))
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
        seconds=time.perf_counter() - begin,
    )


def conditions_of(table: Table, budget: Budget) -> list[tuple[float, float]]:
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
    direct = silent_model(config)
    walls: dict[str, Wall] = {"table, without spin": _FirstImpacts(table)}
    if table.has_spin:
        walls["table, with spin"] = table
    index = np.arange(budget.timed, dtype=np.uint64)
    first = first_arrivals(index, _TIMED_ANGLE, _TIMED_SPEED)
    _, arrivals = follow_grains(direct, first, "any", seed, _TIMED_HIT - 1)

    def nanoseconds(wall: Wall) -> float:
        return 1e9 * best_seconds(partial(arrivals.rebound, wall, seed), 5) / len(index)

    ways = [SpinningWay("direct simulation", nanoseconds(direct), ())]
    for name, wall in walls.items():
        chains = in_threads(
            lambda chain: chain(), chain_comparisons(wall, config, seed, budget.chained)
        )
        numbers = judge([hit for chain in chains for hit in chain], config.spin_targets)
        ways.append(SpinningWay(name, nanoseconds(wall), tuple(numbers)))
    return tuple(ways)


def _error_cells(errors: dict[str, BatchMean]) -> list[str]:
    """Write the mean of each metric, and the share of forbidden states."""
    cells = [metric.text(errors[name].mean) for name, metric in METRICS.items()]
    share = errors["forbidden"].mean
    return [*cells, f"{share:.1%}" if share >= 5e-4 else f"{share:.0e}" if share else "0"]


def method_table(race: Benchmark) -> TextTable:
    """Put all methods at one condition beside each other, the noise floor first."""
    rows = [["noise floor: direct against direct", "", "", "", *_error_cells(race.floor)]]
    for r in race.runners:
        costs = [f"{r.nanoseconds:,.0f}", f"{r.bytes:,}" if r.bytes else "-"]
        costs.append(f"{r.setup_seconds:.2f}")
        rows.append([f"{r.family}: {r.name}", *costs, *_error_cells(r.errors)])
    return TextTable(f"At {race.alpha_deg:g}°, {race.speed:g} m/s", METHOD_HEAD, rows)


def spinning_table(ways: Sequence[SpinningWay]) -> TextTable:
    """Put the ways to rebound spinning particles beside each other."""
    rows = []
    for way in ways:
        numbers = [f"{number.estimate.value:.3f}" for number in way.numbers]
        numbers += [""] * (len(CHAINS) - len(numbers))
        rows.append([way.name, f"{way.nanoseconds:,.0f}", *numbers])
    caption = "Particles that arrive spinning: largest error over all kinds of grains, hits 2 to 60"
    return TextTable(caption, SPINNING_HEAD, rows)


def report_text(report: Report) -> str:
    """Write a report for a terminal."""
    machine, effort = report.machine, report.effort
    distances = "; ".join(f"{metric.head}: {metric.label}" for metric in METRICS.values())
    parts = [
        f"Error against run time: {report.table}\n"
        f"{report.table_bytes:,} bytes hold the whole range of angles and speeds. A draw at random "
        f"conditions takes {report.random_nanoseconds:.0f} ns.\n"
        f"Made with seed {report.seed} in {report.seconds:.0f} s on {machine['processor']}, "
        f"{machine['cores']} cores, {machine['system']}, Python {machine['python']}. Times are "
        "processor times of one thread.",
        f"Each method gives {effort.batches} batches of {effort.batch:,} states, compared with "
        f"{effort.reference:,} directly simulated states. {distances}. A forbidden state moves "
        "into the wall or has gained energy. No method can be seen to be better than the noise "
        "floor.",
        *(str(method_table(race)) for race in report.races),
    ]
    if report.spinning:
        parts.append(str(spinning_table(report.spinning)))
    return "\n\n".join(parts)


def worst_condition(report: Report) -> Benchmark:
    """Choose the condition at which the report's own table does worst, by its AUC."""

    def auc(race: Benchmark) -> float:
        # the report's own table comes before tables beside it
        table = next(runner for runner in race.runners if runner.family == "table")
        return table.errors["auc"].mean

    return max(report.races, key=auc)


def report_picture(report: Report, name: str) -> bytes:
    """Draw two errors of every method where the table does worst; the name ends in its kind."""
    return errors_picture(worst_condition(report), name)
