"""Cost of a table, extrapolated from the time of a few nodes and trials."""

import math
from typing import NamedTuple

from tablegen.config.config import Config
from tablegen.fitting.resolution import Resolution, resolution, spin_sizes
from tablegen.tables.axes import first_grid, most_nodes
from tablegen.tables.intervals import Place
from tablegen.tables.refine import NodeCache, ladder

#: Nodes and trials that the choice of the mixture takes, least and most.
_PROBES = (3, 24)

#: Trials that the final measurement takes at each of its conditions, least and most: undecided
#: distances are measured again.
_MEASURED = (0.7, 4.0)

#: Time of the measurement at a node, which has fewer states, over that of a trial.
_SCREENED = 0.2

#: Time of a rebound in the fit of a spin law over that in the fit of a node, least and most.
_LEAF_REBOUND = (1.0, 4.0)

#: Rebounds of the measurement of a spin law in chains and cells, least and most.
_LATER_REBOUNDS = (5e6, 3e7)


class Cost(NamedTuple):
    """Cost of a table."""

    #: Angles and speeds of the first grid, and of the largest to which it is refined.
    first: tuple[int, int]
    most: tuple[int, int]
    #: Leaves of the spin law.
    leaves: int
    #: Least and most processor time that is left.
    seconds: tuple[float, float]
    #: Processor time of the pieces of an interrupted run, which is not spent again.
    done: float = 0.0


def estimate(cache: NodeCache, conditions: int = 0, done: float = 0.0) -> Cost:
    """Fit a node, compare it with direct simulation, and extrapolate the time of both.

    The cache keeps the node for the table. ``conditions`` is the number of those at which the
    finished table is measured, ``done`` the processor time of the pieces that there are.
    """
    config, grid = cache.config, first_grid(cache.config)
    first, most = (len(grid.alpha_deg), len(grid.speed)), most_nodes(config, grid)
    place = Place((grid.alpha_deg[first[0] // 2],), (grid.speed[first[1] // 2],))
    rungs = [config.table.components] if config.table.components else ladder(config)
    sizes = [resolution(config, rungs[0]), resolution(config, rungs[-1])]
    leaves, rebounds = _spin_law(config)
    seconds = []
    times = {size: _times(cache, size, place) for size in dict.fromkeys(sizes)}
    for k, (size, nodes) in enumerate(zip(sizes, (first, most), strict=True)):
        node, trial = times[size]
        whole = math.prod(nodes) * node
        if first != most:
            whole += _trials(*nodes) * (1, 2)[k] * trial
        if len(rungs) > 1:
            whole += _PROBES[k] * (node + trial)
        if conditions > 0:
            whole += _MEASURED[k] * conditions * (1 + config.spin) * trial
            whole += _SCREENED * math.prod(nodes) * trial
        later = _LATER_REBOUNDS[k] * (leaves > 0 and conditions > 0)
        whole += (_LEAF_REBOUND[k] * rebounds + later) * node / size.samples
        seconds.append(max(whole - done, 0.0))
    return Cost(first, most, leaves, (seconds[0], seconds[1]), done)


def _times(cache: NodeCache, size: Resolution, place: Place) -> tuple[float, float]:
    """Processor time of a node and of a trial."""
    begin = sum(cache.runner.seconds.values())
    cache.fit(size, [(place.alpha_deg[0], place.speed[0])])
    fitted = sum(cache.runner.seconds.values())
    cache.errors(size, [place])
    return fitted - begin, sum(cache.runner.seconds.values()) - fitted


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


def spent_text(spent: float, quoted: Cost | None = None) -> str:
    """Say how much processor time was spent, and how much was quoted."""
    text = f"{time_text(spent, spent)} of one processor"
    return f"{text}, where {time_text(*quoted.seconds)} were quoted" if quoted else text


def cost_text(cost: Cost, workers: int | None) -> str:
    """Describe a cost in one line, for a number of workers if it is known."""
    text = f"{cost.first[0]} x {cost.first[1]} nodes"
    if cost.most != cost.first:
        text += f" at first, at most {cost.most[0]} x {cost.most[1]} where the error needs it"
    if cost.leaves:
        text += f", a spin law of {cost.leaves} leaves"
    low, high = cost.seconds
    text += f"; about {time_text(low, high)} of one processor"
    if cost.done > 0.0:
        text += f" beside the {time_text(cost.done, cost.done)} that are done"
    if workers is not None and workers > 1:
        text += f", {time_text(low / workers, high / workers)} on {workers}"
    return text
