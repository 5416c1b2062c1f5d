"""Cost of a table, extrapolated from the time of one node and one trial."""

import math
from collections.abc import Callable
from typing import NamedTuple

from tablegen.config.config import Config
from tablegen.fitting.resolution import LADDER, resolution, spin_sizes
from tablegen.tables.axes import first_grid
from tablegen.tables.interpolation_error import error_of
from tablegen.tables.intervals import Place
from tablegen.tables.refine import NodeCache

#: Mixtures that reach an AUC of 0.5 + x have about this over x components.
_COMPONENTS_BY_AUC = 23.0

#: Nodes and trials that the choice of the mixture takes, all sizes together.
_PROBES = 18

#: Trials that the final measurement takes at each of its conditions.
_MEASURED = 2.0

#: Time of a rebound in the fit of a spin law over that in the fit of a node.
_LEAF_REBOUND = 3.0


class Cost(NamedTuple):
    """Cost of a table.

    Attributes
    ----------
    first, most : tuple of int
        Angles and speeds of the first grid, and of the grid with every interval halved once.
    leaves : int
        Leaves of the spin law.
    seconds : tuple of float
        Time of one processor for either grid.
    """

    first: tuple[int, int]
    most: tuple[int, int]
    leaves: int
    seconds: tuple[float, float]


def estimate(cache: NodeCache, conditions: int = 0) -> Cost:
    """Fit one node, compare it with direct simulation, and extrapolate the time of both.

    Parameters
    ----------
    cache : NodeCache
        Keeps the node for the table.
    conditions : int
        Number of conditions at which the finished table is measured.
    """
    config, grid = cache.config, first_grid(cache.config)
    named = config.table.alpha_nodes_deg is not None, config.table.speed_nodes is not None
    first = len(grid.alpha_deg), len(grid.speed)
    most = tuple(n if fixed else 2 * n - 1 for n, fixed in zip(first, named, strict=True))
    place = Place((grid.alpha_deg[first[0] // 2],), (grid.speed[first[1] // 2],))
    wanted = int(_COMPONENTS_BY_AUC / max(config.accuracy.auc - 0.5, 0.002))
    size = resolution(config, min(max(wanted, LADDER[0]), LADDER[-1]))

    def time_of(work: Callable[[], object]) -> float:
        before = sum(cache.runner.seconds.values())
        work()
        return sum(cache.runner.seconds.values()) - before

    node = time_of(lambda: cache.fit(size, [(place.alpha_deg[0], place.speed[0])]))
    trial = time_of(
        lambda: cache.errors(size, [place], lambda p, found: error_of(found, config.accuracy, p))
    )
    own = conditions if config.spin else 0
    leaves, rebounds = _spin_law(config)
    besides = _MEASURED * (conditions + own) * trial
    besides += _LEAF_REBOUND * rebounds * node / size.samples
    if config.table.components is None:
        besides += _PROBES * (node + trial)
    few = 0 if all(named) else _trials(*first)
    many = 0 if all(named) else few + _trials(*most)
    low = math.prod(first) * node + few * trial + besides
    high = math.prod(most) * node + many * trial + besides
    return Cost(first, (most[0], most[1]), leaves, (low, high))


def _trials(alphas: int, speeds: int) -> int:
    """Count the edges and cells of a grid."""
    return (alphas - 1) * speeds + alphas * (speeds - 1) + (alphas - 1) * (speeds - 1)


def _spin_law(config: Config) -> tuple[int, float]:
    """Leaves of the spin law, and the rebounds that are simulated for them."""
    if not config.spin:
        return 0, 0.0
    codes = config.population.kernel_arguments().shape_codes
    sizes = [spin_sizes(config).of_shape(int(code)) for code in codes]
    leaves = [size.leaves + size.still_leaves for size in sizes]
    return sum(leaves), sum(n * size.rebounds for n, size in zip(leaves, sizes, strict=True))


def time_text(low: float, high: float) -> str:
    """Write two durations in the unit that fits the longer."""
    units = {"hours": 3600.0, "minutes": 60.0, "seconds": 1.0}
    unit = next((name for name, seconds in units.items() if high >= 2.0 * seconds), "seconds")
    ends = (float(f"{max(x / units[unit], 1.0):.2g}") for x in (low, high))
    return f"{' to '.join(dict.fromkeys(f'{end:g}' for end in ends))} {unit}"


def cost_text(cost: Cost, workers: int | None) -> str:
    """Describe a cost in one line, for a number of workers if it is known."""
    text = f"{cost.first[0]} x {cost.first[1]} nodes"
    if cost.most != cost.first:
        text += f" at first, up to about {cost.most[0]} x {cost.most[1]} where the error needs it"
    if cost.leaves:
        text += f", a spin law of {cost.leaves} leaves"
    low, high = cost.seconds
    text += f"; about {time_text(low, high)} of one processor"
    if workers is not None and workers > 1:
        text += f", {time_text(low / workers, high / workers)} on {workers}"
    return text
