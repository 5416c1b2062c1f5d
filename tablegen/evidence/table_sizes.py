"""Draws from a table as a method of sampling; and tables of many sizes on a small domain."""

import math
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import sampler
from sampler.errors import InputError
from sampler.files import find_table
from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.config.config import Config
from tablegen.evidence.sampling_methods import (
    DOMAIN,
    BenchmarkCase,
    FittedMethod,
    SamplingMethod,
)
from tablegen.model.float_array import FloatArray
from tablegen.tables.generate import generate

FAMILY = "table"

#: Part of the table's range that the design sweep covers, as shares of its angles and speeds.
PART = ((0.665, 0.8325), (0.4, 0.612))

#: Where a design is compared, as shares of that part: in no design's node.
JUDGED = (0.25, 0.25)

#: The design from which each sweep changes one number.
BASE = {"angles": 3, "speeds": 2, "components": 128, "knots": 65}

#: Angles and speeds, mixture components and knots that take the place of the base's.
NODES = ((2, 2), (4, 3), (7, 4))
COMPONENTS = (4, 16, 32, 64, 256, 512)
KNOTS = (17, 33, 129)


@dataclass(frozen=True)
class Design:
    """Sizes of a table on the small domain."""

    varied: str
    angles: int = BASE["angles"]
    speeds: int = BASE["speeds"]
    components: int = BASE["components"]
    knots: int = BASE["knots"]

    @property
    def name(self) -> str:
        """Sizes in words."""
        return (
            f"{self.angles} x {self.speeds} nodes, {self.components} components, {self.knots} knots"
        )


def designs() -> list[Design]:
    """Every design of the sweep, the base first."""
    return [
        Design("base"),
        *(Design("nodes", angles=a, speeds=v) for a, v in NODES),
        *(Design("components", components=k) for k in COMPONENTS),
        *(Design("knots", knots=k) for k in KNOTS),
    ]


def draw_from(table: Table, alpha_deg: float, speed: float) -> Any:
    """Draw of one condition from a table, on one thread."""

    def draw(count: int, seed: int) -> FloatArray:
        return table.sample(
            math.radians(alpha_deg), speed, seed=seed, index=np.arange(count), threads=1
        )

    return draw


def _prepare(case: BenchmarkCase, path: Path) -> FittedMethod:
    table = sampler.load(path)
    return FittedMethod(draw_from(table, case.alpha_deg, case.speed), path.stat().st_size)


def table_method(name_or_path: str) -> SamplingMethod:
    """Draws from a table that there is."""
    path = find_table(name_or_path)
    return SamplingMethod(FAMILY, Path(name_or_path).stem, DOMAIN, partial(_prepare, path=path))


def whole_table(name_or_path: str) -> Table:
    """Load a table that gives all variables of a state.

    Raises
    ------
    InputError
        If it is not a table, or leaves variables out.
    """
    table = sampler.load(name_or_path)
    if table.columns != STATE:
        raise InputError(
            f"{name_or_path}: got components {', '.join(table.columns)}, "
            f"allowed: {', '.join(STATE)} ('tablegen validate' judges any table)"
        )
    return table


def other_table(name_or_path: str, table: Table) -> SamplingMethod:
    """Draws from another table wherever a table can be drawn from.

    Raises
    ------
    InputError
        If it is of another pair, leaves variables out, or does not cover that table's range.
    """
    other = whole_table(name_or_path)
    if other.pair != table.pair:
        raise InputError(f"{name_or_path}: got pair {other.pair}, allowed: {table.pair}")
    for ours, theirs, units in (
        (np.degrees(table.alpha_range), np.degrees(other.alpha_range), "degrees"),
        (table.speed_range, other.speed_range, "m/s"),
    ):
        if theirs[0] > ours[0] or theirs[1] < ours[1]:
            raise InputError(
                f"{name_or_path}: got a range of {theirs[0]:g} to {theirs[1]:g} {units}, "
                f"allowed: {ours[0]:g} to {ours[1]:g} or more"
            )
    return table_method(name_or_path)


def seconds_at_random(table: Table, count: int, seed: int) -> float:
    """Seconds per draw at random conditions, as in a flow code; one thread."""
    rng = np.random.default_rng(seed)
    alpha = rng.uniform(*table.alpha_range, count)
    speed = rng.uniform(*table.speed_range, count)
    index = np.arange(count)
    best = math.inf
    for _ in range(3):
        start = time.process_time()
        table.sample(alpha, speed, seed=seed, index=index, threads=1)
        best = min(best, time.process_time() - start)
    return best / count


def part_of(limits: tuple[float, float], shares: tuple[float, float]) -> tuple[float, float]:
    """Part of a range, at whole numbers where these lie inside."""
    low, high = limits
    first, last = (low + x * (high - low) for x in shares)
    if low <= round(first) < round(last) <= high:
        return float(round(first)), float(round(last))
    return first, last


def _nodes(limits: tuple[float, float], count: int) -> list[float]:
    """Evenly spaced nodes over a range, its ends as they are; one node if the range is a point."""
    if limits[0] == limits[1]:
        return [limits[0]]
    return [*np.linspace(*limits, count).tolist()[:-1], limits[1]]


def design_config(config: Config, design: Design, samples: int, seed: int) -> Config:
    """Make the configuration of a design on the small domain, of a table without a spin law."""
    alpha = part_of(config.domain.alpha_deg, PART[0])
    speed = part_of(config.domain.speed, PART[1])
    return config.with_changes(
        {
            "spin": False,
            "domain": {"alpha_deg": list(alpha), "speed": list(speed)},
            "table": {
                "seed": seed,
                "samples_per_node": samples,
                "components": design.components,
                "quantile_knots": design.knots,
                "alpha_nodes_deg": _nodes(alpha, design.angles),
                "speed_nodes": _nodes(speed, design.speeds),
            },
        }
    )


def design_condition(config: Config) -> tuple[float, float]:
    """Angle [degrees] and speed at which every design is compared."""
    alpha = part_of(config.domain.alpha_deg, PART[0])
    speed = part_of(config.domain.speed, PART[1])
    return (
        alpha[0] + JUDGED[0] * (alpha[1] - alpha[0]),
        speed[0] + JUDGED[1] * (speed[1] - speed[0]),
    )


def _generate(case: BenchmarkCase, design: Design, samples: int) -> FittedMethod:
    """Generate a design, keep it in memory, say what it took."""
    settings = design_config(case.config, design, samples, case.seed % 2**32)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "design.h5"
        made = generate(settings, path, conditions=0)
        size = path.stat().st_size
        table = sampler.load(path)
    return FittedMethod(
        draw_from(table, case.alpha_deg, case.speed),
        size,
        setup=sum(made.seconds.values()),
        facts={"worker_seconds": dict(made.seconds)},
    )


def design_methods(samples: int) -> list[SamplingMethod]:
    """Every design as a method; it is generated when it is prepared."""
    return [
        SamplingMethod(
            FAMILY,
            design.name,
            DOMAIN,
            partial(_generate, design=design, samples=samples),
            {
                "varied": design.varied,
                "nodes": [design.angles, design.speeds],
                "components": design.components,
                "quantile_knots": design.knots,
                "samples_per_node": samples,
            },
        )
        for design in designs()
    ]
