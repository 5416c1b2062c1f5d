"""Methods of sampling rebound states: direct simulation and tables."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import sampler
from sampler.errors import InputError
from sampler.files import find_table
from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
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
class FittedMethod:
    """A method that is ready to draw."""

    draw: Draw
    #: Bytes that the draw reads, 0 for none.
    size: int


@dataclass(frozen=True)
class SamplingMethod:
    """A method of sampling rebound states."""

    family: str
    name: str
    #: `DOMAIN` or `CONDITION`.
    covers: str
    prepare: Callable[[BenchmarkCase], FittedMethod]


def direct_methods() -> list[SamplingMethod]:
    """Make the methods of direct simulation: as configured, by resolution, and by tolerance."""
    varied = [("contact resolution", "contact_resolution", x) for x in (1e-1, 1e-2, 1e-4)]
    varied += [("flight tolerance", "tolerance", x) for x in (1e-4, 1e-6)]
    methods = [SamplingMethod("direct simulation", "as configured", DOMAIN, simulated)]
    for words, name, value in varied:
        prepare = partial(simulated, numerics={name: value})
        methods.append(SamplingMethod("direct simulation", f"{words} {value:g}", DOMAIN, prepare))
    return methods


def simulated(case: BenchmarkCase, numerics: dict[str, float] | None = None) -> FittedMethod:
    """Prepare direct simulation, with other numerical parameters than the configuration's."""
    config = case.config.with_changes({"model": numerics}) if numerics else case.config

    def draw(count: int, seed: int) -> FloatArray:
        alpha1 = np.radians(case.alpha_deg)
        return simulate(config, alpha1, case.speed, count, seed=seed, threads=1).state

    return FittedMethod(draw, 0)


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

    def prepare(case: BenchmarkCase) -> FittedMethod:
        table, alpha1 = sampler.load(path), math.radians(case.alpha_deg)

        def draw(count: int, seed: int) -> FloatArray:
            return table.sample(alpha1, case.speed, seed=seed, index=np.arange(count), threads=1)

        return FittedMethod(draw, path.stat().st_size)

    return SamplingMethod("table", Path(name_or_path).stem, DOMAIN, prepare)


def other_table(name_or_path: str, table: Table) -> SamplingMethod:
    """Make the method of draws from another table of the same pair, wherever `table` can be drawn.

    Raises `InputError` if the pair is another, variables are left out, or the range does not hold
    that of `table`.
    """
    other = load_whole(name_or_path)
    if other.pair != table.pair:
        raise InputError("pair", other.pair, table.pair, source=str(name_or_path))
    for name in ("alpha_range", "speed_range"):
        (low, high), (first, last) = getattr(table, name), getattr(other, name)
        if first > low or last < high:
            given, allowed = f"{first:g} to {last:g}", f"{low:g} to {high:g} or more (radians, m/s)"
            raise InputError(name, given, allowed, source=str(name_or_path))
    return table_method(name_or_path)
