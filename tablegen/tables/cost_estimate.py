"""What a table will cost, said before it is made.

Counts follow from the configuration. Seconds follow from the time of a rebound, measured here and
now, and from what fits and comparisons took in the tables of ``tablegen/fitting/EXPERIMENTS.md``.
"""

import math
import time
from typing import NamedTuple

import numpy as np

from tablegen.accuracy.conditions import spin_conditions_beside
from tablegen.accuracy.joint_law import SAMPLES as CHAIN_IMPACTS
from tablegen.accuracy.measure import sample_size
from tablegen.config.config import Config
from tablegen.fitting.leaf_sizes import spin_sizes
from tablegen.fitting.resolution import LADDER, resolution
from tablegen.simulation.simulate import simulate
from tablegen.tables.axes import first_grid
from tablegen.tables.intervals import Grid

#: Seconds of a fit: so many a particle, and as many more for every so many mixture components.
_FIT, _FIT_COMPONENTS = 2.7e-6, 384

#: Seconds of a comparison: so many, and so many a state.
_CHECK, _CHECK_STATE = 0.8, 3.5e-6

#: Mixtures that reach an AUC of 0.5 + x have about this over x components.
_COMPONENTS_BY_AUC = 23.0

#: Places that are tried to choose the mixture, over all of its sizes.
_PROBES = 18

#: Trials that the measurement of a whole table takes at each of its conditions.
_MEASURED = 2.0

#: How far refinement takes the number of angles and of speeds; how many intervals it tries in vain.
_GROWTH, _IN_VAIN = (1.7, 2.3), 1.4

#: Of the spin law: what a rebound with spin costs over one without, seconds of the fit of a leaf
#: for each of its rebounds and as many more for every so many experts, and those of the trees for
#: each condition.
_SPINNING, _LEAF_FIT, _LEAF_EXPERTS, _TREE = 1.6, 6e-6, 30, 4e-6

#: Rebounds of both sides for each impact that is compared over chains.
_REBOUNDS = 8

#: Margin of the seconds, either way.
_MARGIN = 1.4

#: Memory, bytes: of the process, of a particle or state under way in a worker.
_PROCESS, _STATE = 650e6, 500

#: The same of a rebound of a leaf.
_LEAF_STATE = 1_500

#: Rebounds that are timed, at each of three angles.
_TIMED = 2_000


class Cost(NamedTuple):
    """What a table will cost."""

    #: Angles and speeds of the nodes to begin with.
    first: tuple[int, int]
    #: Those that refinement may end at; the same where the configuration names all nodes.
    most: tuple[int, int]
    #: Time of one processor, all tasks together.
    least_seconds: float
    most_seconds: float
    #: Bytes of a process that makes the table, and of each task that it has under way.
    memory: float
    worker_memory: float
    #: Leaves of the spin law.
    leaves: int = 0


def rebound_seconds(config: Config) -> float:
    """Processor time of one direct rebound here, the mean of three angles of the domain."""
    low, high = config.domain.alpha_deg
    speed = math.sqrt(config.domain.speed[0] * config.domain.speed[1])
    spent = []
    for alpha_deg in (low, 0.5 * (low + high), high):
        for _ in range(2):  # the first compiles
            start = time.process_time()
            simulate(config, np.radians(alpha_deg), speed, _TIMED, seed=1, threads=1)
            passed = time.process_time() - start
        spent.append(passed / _TIMED)
    return sum(spent) / len(spent)


def _trials(alphas: int, speeds: int) -> int:
    """Edges and cells of a grid."""
    return (alphas - 1) * speeds + alphas * (speeds - 1) + (alphas - 1) * (speeds - 1)


def _grown(grid: Grid, config: Config) -> tuple[int, int]:
    """Angles and speeds that refinement may end at."""
    table = config.table
    named = (table.alpha_nodes_deg is not None, table.speed_nodes is not None)
    sizes = (len(grid.alpha_deg), len(grid.speed))
    alphas, speeds = (
        n if fixed or n == 1 else math.ceil(growth * n)
        for n, growth, fixed in zip(sizes, _GROWTH, named, strict=True)
    )
    return alphas, speeds


def estimate(config: Config, rebound: float, conditions: int = 0) -> Cost:
    """Estimate what a table will cost.

    Parameters
    ----------
    config : Config
    rebound : float
        Processor time of one direct rebound [s], from `rebound_seconds`.
    conditions : int
        At how many conditions the whole table is measured at the end.
    """
    grid, table = first_grid(config), config.table
    first, most = (len(grid.alpha_deg), len(grid.speed)), _grown(grid, config)
    wanted = _COMPONENTS_BY_AUC / max(config.accuracy.auc - 0.5, 0.002)
    components = table.components or min(max(int(wanted), LADDER[0]), LADDER[-1])
    samples, states = resolution(config).samples, sample_size(config.accuracy)
    node = samples * (rebound + _FIT * (1.0 + components / _FIT_COMPONENTS))
    trial = states * (rebound + _CHECK_STATE) + _CHECK
    besides = conditions * _MEASURED * trial
    if table.components is None:
        besides += _PROBES * (node + trial)
    fixed = table.alpha_nodes_deg is not None and table.speed_nodes is not None
    least = math.prod(first) * node + (0.0 if fixed else _trials(*first) * trial)
    last = math.prod(most) * node + (0.0 if fixed else _IN_VAIN * _trials(*most) * trial)
    leaves, spinning = _spin_law(config, rebound) if config.spin else (0, 0.0)
    besides += spinning + (_spin_measurement(config, rebound, conditions) if config.spin else 0.0)
    return Cost(
        first,
        most,
        (least + besides) / _MARGIN,
        (last + besides) * _MARGIN,
        _PROCESS,
        max(_STATE * max(samples, states), _LEAF_STATE * spin_sizes(config).rebounds * config.spin),
        leaves,
    )


def _spin_law(config: Config, rebound: float) -> tuple[int, float]:
    """Leaves of the spin law, and the processor time that it takes [s]."""
    leaves, seconds = 0, 0.0
    for code in config.population.kernel_arguments().shape_codes:
        size = spin_sizes(config).of_shape(int(code))
        each = size.leaves + size.still_leaves
        fit = _LEAF_FIT * (1.0 + size.groups * size.experts / _LEAF_EXPERTS)
        seconds += each * size.rebounds * (2.0 * _SPINNING * rebound + fit)
        seconds += size.conditions * (_SPINNING * rebound + _TREE)
        leaves += each
    return leaves, seconds


def _spin_measurement(config: Config, rebound: float, conditions: int) -> float:
    """Processor time [s] of the measurement of a spin law, at conditions and over chains."""
    at_one = sample_size(config.spin_targets) * (_SPINNING * rebound + _CHECK_STATE) + _CHECK
    chains = CHAIN_IMPACTS * (_REBOUNDS * _SPINNING * rebound + _CHECK_STATE) + 2.0 * _CHECK
    return _MEASURED * (spin_conditions_beside(conditions) * at_one + chains * (conditions > 0))


def _time_text(low: float, high: float) -> str:
    """Two durations in the unit that fits the longer."""
    units = {"hours": 3600.0, "minutes": 60.0, "seconds": 1.0}
    unit = next((name for name, seconds in units.items() if high >= 2.0 * seconds), "seconds")
    ends = (float(f"{max(x / units[unit], 1.0):.2g}") for x in (low, high))
    return f"{' to '.join(dict.fromkeys(f'{end:g}' for end in ends))} {unit}"


def cost_text(cost: Cost, workers: int | None) -> str:
    """Say in one line what a table will cost.

    Parameters
    ----------
    cost : Cost
    workers : int or None
        How many pieces are done side by side; None if it is not known.
    """
    (alphas, speeds), (more_alphas, more_speeds) = cost.first, cost.most
    nodes = f"{alphas} x {speeds} nodes"
    if cost.most != cost.first:
        nodes += (
            f" at first, more where the error asks for it (up to about {more_alphas} x "
            f"{more_speeds})"
        )
    if cost.leaves:
        nodes += f", a spin law of {cost.leaves} leaves"
    seconds = cost.least_seconds, cost.most_seconds
    parts = [nodes, f"about {_time_text(*seconds)} of one processor"]
    if workers is not None and workers > 1:
        parts[-1] += f", {_time_text(*(s / workers for s in seconds))} on {workers}"
    memory = (cost.memory + (workers or 1) * cost.worker_memory) / 1e9
    parts.append(f"up to {memory:.1f} GB of memory" + (" a process" if workers is None else ""))
    return "; ".join(parts)
