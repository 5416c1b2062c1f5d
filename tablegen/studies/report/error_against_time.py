"""Everything that a report measures of error against run time, in one run."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from tqdm import tqdm

import sampler
from sampler.files.locate import find_table
from sampler.table import Table
from tablegen.config import Config, parse_config
from tablegen.studies.report.baselines import baseline_methods
from tablegen.studies.report.benchmark import Benchmark, make_case, run_benchmark, steps
from tablegen.studies.report.budget import FULL, QUICK, Budget
from tablegen.studies.report.direct_method import direct_methods
from tablegen.studies.report.machine import machine
from tablegen.studies.report.sample_size_convergence import Sample, sample_sizes
from tablegen.studies.report.table_sizes import (
    design_condition,
    design_methods,
    other_table,
    seconds_at_random,
    table_method,
    whole_table,
)
from tablegen.studies.report.tolerances import RESOLUTIONS, TOLERANCES, Setting, curve
from tablegen.tasks.progress import bar


@dataclass(frozen=True)
class ErrorAgainstTime:
    """Error against run time, and what it was measured with.

    Attributes
    ----------
    table : str
        Name or path that was given.
    content_sha256 : str
    table_bytes : int
    random_nanoseconds : float
        Processor time of a draw from the table at random conditions.
    quick : bool
    seed : int
    effort : Budget
    machine : dict
    races : tuple of Benchmark
        Every method at each condition.
    designs : Benchmark
        Tables of many sizes on a small domain.
    settings : tuple of Setting
        Numerics of the direct model, on the same particles.
    sizes : tuple of Sample
    left_out : tuple of str
        One line for each baseline that is not installed.
    seconds : float
        Wall time of the measurement.
    """

    table: str
    content_sha256: str
    table_bytes: int
    random_nanoseconds: float
    quick: bool
    seed: int
    effort: Budget
    machine: dict[str, Any]
    races: tuple[Benchmark, ...]
    designs: Benchmark
    settings: tuple[Setting, ...]
    sizes: tuple[Sample, ...]
    left_out: tuple[str, ...]
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
    """One run of all measurements."""

    def __init__(
        self, name: str, beside: Sequence[str], budget: Budget, seed: int, bar: tqdm
    ) -> None:
        self.budget, self.seed, self.bar = budget, seed, bar
        self.table = whole_table(name)
        self.tables = [table_method(name), *(other_table(other, self.table) for other in beside)]
        self.config: Config = parse_config(self.table.config, f"{name}: config")
        self.baselines, self.left_out = baseline_methods()
        self.places = conditions(self.table, budget)

    def total(self) -> int:
        """Count the steps of the progress bar."""
        methods = len(direct_methods()) + len(self.tables) + len(self.baselines)
        designs = len(design_methods(1))
        return (
            len(self.places) * (steps(methods, self.budget) + len(RESOLUTIONS) + len(TOLERANCES))
            + steps(designs, self.budget)
            + 2 * len(self.budget.sizes)
        )

    def settings(self) -> list[Setting]:
        """Numerics of the direct model at every condition."""
        found = []
        for alpha_deg, speed in self.places:
            self.bar.set_description(f"numerics at {alpha_deg:g} deg", refresh=False)
            points = curve(self.config, "mixture", alpha_deg, speed, self.budget.paths, self.seed)
            for point in points:
                found.append(point)
                self.bar.update()
        return found

    def races(self) -> tuple[list[Benchmark], list[Sample]]:
        """Every method at each condition; sample sizes at the last one."""
        methods = [*direct_methods(), *self.tables, *self.baselines]
        races: list[Benchmark] = []
        for place, (alpha_deg, speed) in enumerate(self.places):
            self.bar.set_description(f"methods at {alpha_deg:g} deg", refresh=False)
            case, reference = make_case(
                self.config, alpha_deg, speed, self.budget, self.seed, place
            )
            races.append(run_benchmark(methods, case, reference, self.budget, self.bar.update))
        self.bar.set_description("sample sizes", refresh=False)
        costs = {(r.family, r.name): r.nanoseconds for r in races[-1].runners}
        chosen = (methods[0], methods[len(direct_methods())])
        draws = [
            (method.family, method.prepare(case).draw, costs[method.family, method.name])
            for method in chosen
        ]
        return races, sample_sizes(draws, reference, self.budget, self.seed, self.bar.update)

    def designs(self) -> Benchmark:
        """Tables of many sizes."""
        self.bar.set_description("table designs", refresh=False)
        alpha_deg, speed = design_condition(self.config)
        case, reference = make_case(
            self.config, alpha_deg, speed, self.budget, self.seed, len(self.places)
        )
        methods = design_methods(self.budget.node_samples)
        return run_benchmark(methods, case, reference, self.budget, self.bar.update)


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
        Measure less; see `tablegen.studies.report.budget`.
    seed : int
        Of all random numbers.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    ErrorAgainstTime

    Raises
    ------
    InputError
        If a file is not a table, or does not have what is compared.
    """
    budget, begin = QUICK if quick else FULL, time.perf_counter()
    path = find_table(name_or_path)
    with bar(progress, desc="methods") as counted:
        run = _Run(name_or_path, beside, budget, seed, counted)
        counted.reset(run.total())
        settings = run.settings()
        races, sizes = run.races()
        designs = run.designs()
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
        left_out=tuple(run.left_out),
        seconds=time.perf_counter() - begin,
    )
