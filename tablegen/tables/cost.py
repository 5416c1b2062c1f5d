"""Estimate the processor time of a table from the time of one node, and describe it."""

import math
from typing import NamedTuple

from tablegen.accuracy.measure import sample_size
from tablegen.fitting.law_conditions import covered_range
from tablegen.tables.interpolation_error import SMALLEST_CHEAP_SAMPLES
from tablegen.tables.plan import Plan
from tablegen.tables.refine import NodeCache

# The numbers below are measured times over the time of a node with the smallest mixture.

#: A node with the mixture that is chosen in the end: the least and the most.
_NODE_TIME = (1.0, 3.0)
#: A trial: draws in the middle of an edge or of a cell of the grid, compared with simulation by all
#: metrics, and by the cheap ones alone; the second for as many states as a node has particles.
_TRIAL_TIME, _CHEAP_TRIAL_TIME = 5.0, 1.25
#: The fit of a leaf without experts, conditions included, and the simulation of chains of hits;
#: both for as many rebounds as a node has particles.
_LEAF_TIME, _CHAIN_TIME = 3.0, 1.5

#: A leaf takes as long again for each _EXPERTS experts. The simulation of the particles of a node
#: takes as long as the fit of _COMPONENTS components.
_EXPERTS, _COMPONENTS = 64.0, 150.0

#: Least and most rounds of the refinement, and least and most nodes and trials for the choice of
#: the mixture.
_ROUNDS, _PROBES = (1, 2), (6, 24)

#: Rebounds of the measurement of chains.
_CHAIN_REBOUNDS = 5e6


class Cost(NamedTuple):
    """Estimated cost of a table."""

    plan: Plan
    #: Least and most processor time [s] that is still to be spent.
    seconds: tuple[float, float]
    #: Processor time [s] that an interrupted run spent on pieces that this run uses.
    spent: float


def estimate(plan: Plan, cache: NodeCache, conditions: int, spent: float) -> Cost:
    """Fit a node, and extrapolate its time to the whole table.

    Parameters
    ----------
    plan : Plan
    cache : NodeCache
        Fits the node, and keeps it for the table.
    conditions : int
        Number of conditions at which the finished table is measured.
    spent : float
        Processor time [s] of the pieces of an interrupted run.

    Returns
    -------
    Cost
    """
    size, begin, (alphas, speeds) = plan.sizes[0], cache.runner.seconds, plan.grid
    cache.fit(size, [(alphas[len(alphas) // 2], speeds[len(speeds) // 2])])
    node_seconds = cache.runner.seconds - begin
    leaf_rebounds = sum(
        (spin_sizes.leaves + spin_sizes.nonspinning_leaves)
        * spin_sizes.rebounds
        * (1.0 + spin_sizes.groups * spin_sizes.experts / _EXPERTS)
        for spin_sizes in plan.spin.values()
    )
    states = sample_size(plan.config.accuracy, SMALLEST_CHEAP_SAMPLES)
    ends = []
    for k, nodes in enumerate((plan.first, plan.most)):
        work = math.prod(nodes) * _NODE_TIME[k if len(plan.sizes) > 1 else 0]
        if plan.first != plan.most:
            cheap_time = _CHEAP_TRIAL_TIME * states / size.samples
            trials = cheap_time * _trials(*nodes) + _TRIAL_TIME * (nodes[0] - 1)
            work += _ROUNDS[k] * trials
        work += _PROBES[k] * (1.0 + _TRIAL_TIME) if len(plan.sizes) > 1 else 0.0
        work += _LEAF_TIME * leaf_rebounds / (size.samples * (1.0 + size.components / _COMPONENTS))
        if conditions > 0:
            work += conditions * (1 + plan.config.spin) * _TRIAL_TIME
            work += _CHAIN_TIME * _CHAIN_REBOUNDS * plan.config.spin / size.samples
        ends.append(max(work * node_seconds - spent, 0.0))
    return Cost(plan, (ends[0], ends[1]), spent)


def _trials(alphas: int, speeds: int) -> int:
    """Count the edges and cells of a grid."""
    return (alphas - 1) * speeds + alphas * (speeds - 1) + (alphas - 1) * (speeds - 1)


def time_text(low: float, high: float) -> str:
    """Write a range of durations [s] in the unit that fits the longer one."""
    units = {"hours": 3600.0, "minutes": 60.0, "seconds": 1.0}
    unit = next((name for name, seconds in units.items() if high >= 2.0 * seconds), "seconds")
    ends = (float(f"{max(x / units[unit], 1.0):.2g}") for x in (low, high))
    return f"{' to '.join(dict.fromkeys(f'{end:g}' for end in ends))} {unit}"


def spent_text(spent: float, quoted: Cost | None = None) -> str:
    """Describe the processor time [s] that was spent, and the estimate before."""
    text = f"{time_text(spent, spent)} of one processor"
    return f"{text}, where {time_text(*quoted.seconds)} were estimated" if quoted else text


def cost_text(cost: Cost, workers: int | None) -> str:
    """Describe a cost in one line; ``workers`` is their number, if it is known."""
    plan, (low, high) = cost.plan, cost.seconds
    alpha_deg = plan.config.domain.alpha_deg
    text = f"{plan.first[0]} x {plan.first[1]} nodes"
    if plan.most != plan.first:
        text += f" at first, at most {plan.most[0]} x {plan.most[1]} where the error needs it"
    if plan.leaves:
        flat, steep = map(math.degrees, covered_range(plan.config).alpha)
        text += f", a spin law of {plan.leaves} leaves at {flat:.4g} to {steep:.4g} degrees"
        if steep - flat > 1.1 * (alpha_deg[1] - alpha_deg[0]):
            text += (
                ", because a grain may meet the next wall at any angle (if particles hit one wall "
                "only, set spin = false)"
            )
    text += f"; about {time_text(low, high)} of one processor"
    if cost.spent > 0.0:
        text += f" after the {time_text(cost.spent, cost.spent)} that are done"
    if workers is not None and workers > 1:
        text += f", {time_text(low / workers, high / workers)} on {workers}"
    return text
