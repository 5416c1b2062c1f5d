"""Densities of variables and of pairs of them, table next to direct, at some conditions."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from sampler.formats.channels import STATE
from sampler.table import Table
from tablegen.config.config import Config
from tablegen.evidence.accuracy_map import grid
from tablegen.evidence.benchmark import Tick
from tablegen.evidence.budget import Budget
from tablegen.evidence.method_errors import batch_seed
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import simulate

_DIRECT, _TABLE = range(300, 302)

#: Bins of a density of one variable, and of each of a pair.
BINS, PAIR_BINS = 80, 32

#: Part of the direct states that the axes show; the rest is in the tails.
_SHOWN = (0.001, 0.999)


@dataclass(frozen=True)
class View:
    """Histograms of both samples at one condition."""

    alpha_deg: float
    speed: float
    #: What the bins of each variable cover.
    low: list[float]
    high: list[float]
    #: ``"u"``: counts in `BINS` bins; ``"u v"``: counts in `PAIR_BINS` squared bins, all bins
    #: of the second variable for the first bin of the first, and so on.
    table: dict[str, list[int]]
    direct: dict[str, list[int]]
    #: States a side; those outside the bins are counted in none.
    count: int


def _histograms(state: FloatArray, low: FloatArray, high: FloatArray) -> dict[str, list[int]]:
    """Count in bins of each variable and of each pair of variables."""
    found = {}
    for k, name in enumerate(STATE):
        counts, _ = np.histogram(state[:, k], BINS, (low[k], high[k]))
        found[name] = counts.tolist()
    cell = np.floor((state - low) / (high - low) * PAIR_BINS).astype(np.int64)
    inside = (cell >= 0) & (cell < PAIR_BINS)
    for (i, one), (j, other) in combinations(enumerate(STATE), 2):
        kept = inside[:, i] & inside[:, j]
        flat = cell[kept, i] * PAIR_BINS + cell[kept, j]
        found[f"{one} {other}"] = np.bincount(flat, minlength=PAIR_BINS**2).tolist()
    return found


def make_view(drawn: FloatArray, direct: FloatArray, alpha_deg: float, speed: float) -> View:
    """Count both samples in the same bins.

    Parameters
    ----------
    drawn, direct : float64 arrays, shape (n, 6)
        As many states each.
    alpha_deg, speed : float
    """
    low, high = np.quantile(direct, _SHOWN, axis=0)
    # a variable that does not vary still needs a bin
    high = np.maximum(high, low + 1e-6)
    return View(
        alpha_deg=alpha_deg,
        speed=speed,
        low=low.round(6).tolist(),
        high=high.round(6).tolist(),
        table=_histograms(drawn, low, high),
        direct=_histograms(direct, low, high),
        count=len(direct),
    )


def make_views(table: Table, config: Config, effort: Budget, seed: int, tick: Tick) -> list[View]:
    """Make views on a coarse grid over the range of a table.

    Parameters
    ----------
    table : Table
    config : Config
    effort : Budget
    seed : int
    tick : callable
        Called with 1 for each condition.
    """
    alpha, speed = grid(table, effort.views)
    found = []
    for k, (a, v) in enumerate((a, v) for a in alpha for v in speed):
        drawn = table.sample(
            np.radians(a), v, seed=batch_seed(seed, _TABLE, k), index=np.arange(effort.viewed)
        )
        key = batch_seed(seed, _DIRECT, k)
        direct = simulate(config, np.radians(a), v, effort.viewed, seed=key).state
        found.append(make_view(drawn, direct, a, v))
        tick(1)
    return found
