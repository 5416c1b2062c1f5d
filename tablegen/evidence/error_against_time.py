"""Everything that a report measures of error against run time, in one run."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from tqdm import tqdm

import sampler
from sampler.files import find_table
from sampler.table import Table
from tablegen.accuracy.metrics import Reference
from tablegen.config.config import Config, stored_config
from tablegen.evidence.baselines import baseline_methods
from tablegen.evidence.benchmark import Benchmark, make_case, run_benchmark, steps
from tablegen.evidence.budget import FULL, QUICK, Budget
from tablegen.evidence.direct_method import direct_methods
from tablegen.evidence.machine import machine
from tablegen.evidence.sample_size_convergence import Sample, sample_sizes
from tablegen.evidence.sampling_methods import BenchmarkCase, SamplingMethod
from tablegen.evidence.spinning_impacts import SpinningImpacts, measure_spinning_impacts
from tablegen.evidence.table_sizes import (
    design_condition,
    design_methods,
    other_table,
    seconds_at_random,
    table_method,
    whole_table,
)
from tablegen.evidence.tolerances import RESOLUTIONS, TOLERANCES, Setting, curve
from tablegen.progress import bar

#: Ways in which spinning particles rebound, at most.
_WAYS = 3


@dataclass(frozen=True)
class ErrorAgainstTime:
    """Error against run time, and what it was measured with."""

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
    #: Tables of many sizes on a small domain.
    designs: Benchmark
    #: Numerics of the direct model, on the same particles.
    settings: tuple[Setting, ...]
    sizes: tuple[Sample, ...]
    #: Particles that arrive spinning; None of a table in which no chain of impacts stays.
    spinning: SpinningImpacts | None
    #: One line for each baseline that is not installed.
    left_out: tuple[str, ...]
    #: Wall time of the measurement.
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Every number, JSON-ready."""
        return {"software_version": sampler.__version__, **asdict(self)}


def conditions(table: Table, budget: Budget) -> list[tuple[float, float]]:
    """Angles [degrees] and speeds at which the methods are compared."""
    alpha, speed = np.degrees(table.alpha_range), np.array(table.speed_range)
    return [
        (
            float(np.clip(round(alpha[0] + a * (alpha[1] - alpha[0]), 1), *alpha)),
            float(np.clip(round(speed[0] + v * (speed[1] - speed[0]), 0), *speed)),
        )
        for a, v in budget.conditions
    ]


class _Run:
    """One run of all measurements, with a step of the progress bar for each."""

    def __init__(
        self, name: str, beside: Sequence[str], budget: Budget, seed: int, bar: tqdm
    ) -> None:
        self.budget, self.seed, self.bar = budget, seed, bar
        self.table = whole_table(name)
        self.config: Config = stored_config(self.table.config, f"{name}: config")
        tables = [table_method(name), *(other_table(other, self.table) for other in beside)]
        baselines, self.left_out = baseline_methods()
        self.methods = [*direct_methods(), *tables, *baselines]
        #: direct simulation as configured, and the table
        self.main = (self.methods[0], tables[0])
        self.designs = design_methods(budget.node_samples)
        self.conditions = conditions(self.table, budget)
        at_each = steps(len(self.methods), budget) + len(RESOLUTIONS) + len(TOLERANCES)
        last = steps(len(self.designs), budget) + len(self.main) * len(budget.sizes) + _WAYS
        bar.reset(len(self.conditions) * at_each + last)

    def settings(self) -> list[Setting]:
        """Numerics of the direct model at every condition."""
        found = []
        for alpha_deg, speed in self.conditions:
            self.bar.set_description(f"numerics at {alpha_deg:g} deg", refresh=False)
            paths = self.budget.paths
            for point in curve(self.config, "mixture", alpha_deg, speed, paths, self.seed):
                found.append(point)
                self.bar.update()
        return found

    def benchmark(
        self, methods: Sequence[SamplingMethod], condition: tuple[float, float], number: int
    ) -> tuple[Benchmark, BenchmarkCase, Reference]:
        """Compare methods at a condition, whose number keeps its random numbers apart."""
        case, reference = make_case(self.config, *condition, self.budget, self.seed, number)
        made = run_benchmark(methods, case, reference, self.budget, self.bar.update)
        return made, case, reference

    def benchmarks(self) -> tuple[list[Benchmark], list[Sample]]:
        """Every method at each condition; sample sizes at the last one."""
        made = []
        for number, condition in enumerate(self.conditions):
            self.bar.set_description(f"methods at {condition[0]:g} deg", refresh=False)
            benchmark, case, reference = self.benchmark(self.methods, condition, number)
            made.append(benchmark)
        self.bar.set_description("sample sizes", refresh=False)
        costs = {(r.family, r.name): r.nanoseconds for r in made[-1].runners}
        draws = [(m.family, m.prepare(case).draw, costs[m.family, m.name]) for m in self.main]
        return made, sample_sizes(draws, reference, self.budget, self.seed, self.bar.update)

    def spinning(self) -> SpinningImpacts | None:
        """Particles that arrive spinning."""
        self.bar.set_description("spinning impacts", refresh=False)
        budget, tick = self.budget, self.bar.update
        return measure_spinning_impacts(self.table, self.config, budget, self.seed, tick)

    def table_sizes(self) -> Benchmark:
        """Tables of many sizes."""
        self.bar.set_description("table designs", refresh=False)
        number = len(self.conditions)
        return self.benchmark(self.designs, design_condition(self.config), number)[0]


def measure_error_against_time(
    name_or_path: str,
    beside: Sequence[str] = (),
    *,
    quick: bool = False,
    seed: int = 1,
    progress: bool = False,
) -> ErrorAgainstTime:
    """Measure error against run time of every method of sampling rebound states.

    Parameters
    ----------
    name_or_path : str
        Name of a table that comes with the package, or path of a .h5 file.
    beside : sequence of str
        Names or paths of further tables that are drawn from at the same conditions.
    quick : bool
        Measure less; see `tablegen.evidence.budget`.
    seed : int
        Of all random numbers.
    progress : bool
        Show a progress bar on standard error.

    Raises
    ------
    InputError
        If a file is not a table, or does not have what is compared.
    """
    budget, begin = QUICK if quick else FULL, time.perf_counter()
    path = find_table(name_or_path)
    with bar(progress, desc="methods") as counted:
        run = _Run(name_or_path, beside, budget, seed, counted)
        settings = run.settings()
        races, sizes = run.benchmarks()
        designs = run.table_sizes()
        spinning = run.spinning()
    return ErrorAgainstTime(
        table=name_or_path,
        content_sha256=run.table.contents.content_sha256,
        table_bytes=path.stat().st_size,
        random_nanoseconds=1e9 * seconds_at_random(run.table, budget.timed, seed),
        quick=quick,
        seed=seed,
        effort=budget,
        machine=machine(),
        races=tuple(races),
        designs=designs,
        settings=tuple(settings),
        sizes=tuple(sizes),
        spinning=spinning,
        left_out=tuple(run.left_out),
        seconds=time.perf_counter() - begin,
    )
