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
from tablegen.studies.report.baselines import rival_ways
from tablegen.studies.report.benchmark import Race, make_scene, run_race, steps
from tablegen.studies.report.budget import FULL, QUICK, Effort
from tablegen.studies.report.direct_method import direct_ways
from tablegen.studies.report.file_identity import identity
from tablegen.studies.report.machine import machine
from tablegen.studies.report.sample_size_convergence import Sample, sample_sizes
from tablegen.studies.report.table_sizes import (
    beside_way,
    design_condition,
    design_ways,
    seconds_at_random,
    table_way,
    whole_table,
)
from tablegen.studies.report.tolerances import RESOLUTIONS, TOLERANCES, Setting, curve
from tablegen.tasks.progress import bar


@dataclass(frozen=True)
class Evidence:
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
    effort : Effort
    machine : dict
    races : tuple of Race
        Every way at each condition.
    designs : Race
        Tables of many sizes on a small domain.
    settings : tuple of Setting
        Numerics of the direct model, on the same particles.
    sizes : tuple of Sample
    left_out : tuple of str
        One line for each rival that is not installed.
    seconds : float
        Wall time of the measurement.
    """

    table: str
    content_sha256: str
    table_bytes: int
    random_nanoseconds: float
    quick: bool
    seed: int
    effort: Effort
    machine: dict[str, Any]
    races: tuple[Race, ...]
    designs: Race
    settings: tuple[Setting, ...]
    sizes: tuple[Sample, ...]
    left_out: tuple[str, ...]
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Every number, JSON-ready."""
        return {"software_version": sampler.__version__, **asdict(self)}


def conditions(table: Table, effort: Effort) -> list[tuple[float, float]]:
    """Angles [degrees] and speeds at which the ways are compared."""
    alpha, speed = np.degrees(table.alpha_range), np.array(table.speed_range)
    return [
        (
            float(np.clip(round(alpha[0] + a * (alpha[1] - alpha[0]), 1), *alpha)),
            float(np.clip(round(speed[0] + v * (speed[1] - speed[0]), 0), *speed)),
        )
        for a, v in effort.conditions
    ]


class _Run:
    """One run of all measurements."""

    def __init__(
        self, name: str, beside: Sequence[str], effort: Effort, seed: int, bar: tqdm
    ) -> None:
        self.effort, self.seed, self.bar = effort, seed, bar
        self.table = whole_table(name)
        self.tables = [table_way(name), *(beside_way(other, self.table) for other in beside)]
        self.config: Config = parse_config(self.table.config, f"{name}: config")
        self.rivals, self.left_out = rival_ways()
        self.places = conditions(self.table, effort)

    def total(self) -> int:
        """Count the steps of the progress bar."""
        ways = len(direct_ways()) + len(self.tables) + len(self.rivals)
        designs = len(design_ways(1))
        return (
            len(self.places) * (steps(ways, self.effort) + len(RESOLUTIONS) + len(TOLERANCES))
            + steps(designs, self.effort)
            + 2 * len(self.effort.sizes)
        )

    def settings(self) -> list[Setting]:
        """Numerics of the direct model at every condition."""
        found = []
        for alpha_deg, speed in self.places:
            self.bar.set_description(f"numerics at {alpha_deg:g} deg", refresh=False)
            points = curve(self.config, "mixture", alpha_deg, speed, self.effort.paths, self.seed)
            for point in points:
                found.append(point)
                self.bar.update()
        return found

    def races(self) -> tuple[list[Race], list[Sample]]:
        """Every way at each condition; sample sizes at the last one."""
        ways = [*direct_ways(), *self.tables, *self.rivals]
        races: list[Race] = []
        for place, (alpha_deg, speed) in enumerate(self.places):
            self.bar.set_description(f"ways at {alpha_deg:g} deg", refresh=False)
            scene, reference = make_scene(
                self.config, alpha_deg, speed, self.effort, self.seed, place
            )
            races.append(run_race(ways, scene, reference, self.effort, self.bar.update))
        self.bar.set_description("sample sizes", refresh=False)
        costs = {(r.family, r.name): r.nanoseconds for r in races[-1].runners}
        chosen = (ways[0], ways[len(direct_ways())])
        draws = [
            (way.family, way.prepare(scene).draw, costs[way.family, way.name]) for way in chosen
        ]
        return races, sample_sizes(draws, reference, self.effort, self.seed, self.bar.update)

    def designs(self) -> Race:
        """Tables of many sizes."""
        self.bar.set_description("table designs", refresh=False)
        alpha_deg, speed = design_condition(self.config)
        scene, reference = make_scene(
            self.config, alpha_deg, speed, self.effort, self.seed, len(self.places)
        )
        ways = design_ways(self.effort.node_samples)
        return run_race(ways, scene, reference, self.effort, self.bar.update)


def gather_evidence(
    name_or_path: str,
    beside: Sequence[str] = (),
    *,
    quick: bool = False,
    seed: int = 1,
    progress: bool = False,
) -> Evidence:
    """Measure error against run time of every way to get a rebound state.

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
    Evidence

    Raises
    ------
    InputError
        If a file is not a table, or does not have what is compared.
    """
    effort, begin = QUICK if quick else FULL, time.perf_counter()
    path = find_table(name_or_path)
    with bar(progress, desc="methods") as counted:
        run = _Run(name_or_path, beside, effort, seed, counted)
        counted.reset(run.total())
        settings = run.settings()
        races, sizes = run.races()
        designs = run.designs()
    return Evidence(
        table=name_or_path,
        content_sha256=identity(path)["content_sha256"],
        table_bytes=path.stat().st_size,
        random_nanoseconds=1e9 * seconds_at_random(run.table, effort.timed, seed),
        quick=quick,
        seed=seed,
        effort=effort,
        machine=machine(),
        races=tuple(races),
        designs=designs,
        settings=tuple(settings),
        sizes=tuple(sizes),
        left_out=tuple(run.left_out),
        seconds=time.perf_counter() - begin,
    )
