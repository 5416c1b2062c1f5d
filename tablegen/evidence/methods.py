"""Methods of sampling rebound states: direct simulation, tables, and baselines.

A table answers at any angle and speed, from nodes elsewhere. The baselines have the easier task:
each is fitted at the very condition at which it is judged.
"""

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
    """A condition at which methods are compared, with direct states (n, 6) to fit them to."""

    config: Config
    alpha_deg: float
    speed: float
    training: FloatArray
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


def baseline_methods() -> list[SamplingMethod]:
    """Make the methods that one would use without a table."""
    baselines: list[tuple[str, str, Callable[[BenchmarkCase], FittedMethod]]] = [
        ("independent marginals", "257 quantiles", independent_marginals),
        ("stored states", "4,096 stored states", partial(stored_states, count=4096)),
        ("stored states", "16,384 stored states", partial(stored_states, count=16_384)),
        ("Gaussian mixture", "8 components", partial(gaussian_mixture, components=8)),
        ("Gaussian mixture", "40 components", partial(gaussian_mixture, components=40)),
        ("kernel resampling", "Gaussian kernels", kernel_resampling),
    ]
    return [SamplingMethod(family, name, CONDITION, prepare) for family, name, prepare in baselines]


def independent_marginals(case: BenchmarkCase) -> FittedMethod:
    """Draw every variable by itself, from 257 quantiles."""
    levels = np.linspace(0.0, 1.0, 257)
    values = np.quantile(case.training, levels, axis=0)

    def draw(n: int, seed: int) -> FloatArray:
        uniform = np.random.default_rng(seed).random((n, 6))
        return np.column_stack([np.interp(uniform[:, k], levels, values[:, k]) for k in range(6)])

    return FittedMethod(draw, values.size * 4)


def stored_states(case: BenchmarkCase, count: int) -> FittedMethod:
    """Draw whole states from a store, with replacement."""
    store = case.training[:count].astype(np.float32)

    def draw(n: int, seed: int) -> FloatArray:
        rows = np.random.default_rng(seed).integers(len(store), size=n)
        return store[rows].astype(np.float64)

    return FittedMethod(draw, store.nbytes)


def gaussian_mixture(case: BenchmarkCase, components: int) -> FittedMethod:
    """Draw from a Gaussian mixture with full covariances, fitted to the states."""
    from sklearn.mixture import GaussianMixture

    fit = GaussianMixture(components, random_state=case.seed % 2**32).fit(case.training)

    def draw(n: int, seed: int) -> FloatArray:
        fit.set_params(random_state=seed % 2**32)
        # the library gives the mixture components one after the other
        return np.random.default_rng(seed).permutation(np.asarray(fit.sample(n)[0]))

    weight_mean_covariance = 1 + 6 + 21
    return FittedMethod(draw, components * weight_mean_covariance * 4)


def kernel_resampling(case: BenchmarkCase) -> FittedMethod:
    """Draw from a Gaussian kernel density estimate of the states."""
    from scipy.stats import gaussian_kde

    density = gaussian_kde(case.training.T)

    def draw(n: int, seed: int) -> FloatArray:
        return np.ascontiguousarray(density.resample(n, seed=seed % 2**32).T)

    return FittedMethod(draw, case.training.size * 4)


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
