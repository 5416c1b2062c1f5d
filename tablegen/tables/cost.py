"""Estimate the processor time of a table from the time of a few nodes, and describe it.

Work is counted in particles of nodes: the unit is the simulation of one particle, and the ranking
of its variables. It takes about two microseconds. The numbers below are measured times in this
unit. tablegen/fitting/EXPERIMENTS.md compares estimates with real times.
"""

import math
from typing import NamedTuple

from tablegen.accuracy.measure import sample_size
from tablegen.fitting.law_conditions import covered_range
from tablegen.fitting.resolution import Resolution
from tablegen.tables.interpolation_error import SMALLEST_CHEAP_SAMPLES
from tablegen.tables.plan import Plan
from tablegen.tables.refine import NodeCache

#: Fit of a mixture of K components, over K^2: it sees a number of particles for each component.
_MIXTURE = 1.8

#: Comparison of one state with simulation, by the cheap metrics and by all metrics; and the
#: classifier of one comparison.
_CHEAP_STATE, _STATE, _CLASSIFIER = 0.9, 2.0, 2.5e5

#: Share of the states that a trial by cheap metrics takes on average.
_TRIED_SHARE = 0.33

#: Fit of a leaf to one rebound, the conditions of the leaf included: without experts, and for each
#: expert.
_REBOUND, _REBOUND_BY_EXPERT = 3.2, 0.0166

#: Measurement of a spin law along chains of hits.
_CHAINS = 6.2e6

#: Share of the nodes that may be added to the first grid and are added.
_ADDED_SHARE = 0.45

#: Conditions at which the mixture is chosen: so many nodes and comparisons.
_PROBES = 12


class Cost(NamedTuple):
    """Estimated cost of a table."""

    plan: Plan
    #: Processor time [s] that is still to be spent.
    seconds: float
    #: Processor time [s] that an interrupted run spent on pieces that this run uses.
    spent: float


def estimate(plan: Plan, cache: NodeCache, conditions: int, spent: float) -> Cost:
    """Fit a few nodes, and extrapolate their time to the whole table.

    Parameters
    ----------
    plan : Plan
    cache : NodeCache
        Fits the nodes, and keeps them for the table.
    conditions : int
        Number of conditions at which the finished table is measured.
    spent : float
        Processor time [s] of the pieces of an interrupted run.

    Returns
    -------
    Cost
    """
    begin, (alphas, speeds) = cache.runner.seconds, plan.grid
    timed = [(a, speeds[-1]) for a in sorted({alphas[0], alphas[len(alphas) // 2], alphas[-1]})]
    cache.fit(plan.sizes[0], timed)
    seconds = (cache.runner.seconds - begin) / (len(timed) * _node_work(plan.sizes[0]))
    work = _grid_work(plan) + _spin_law_work(plan) + _measurement_work(plan, conditions)
    return Cost(plan, max(work * seconds - spent, 0.0), spent)


def _node_work(size: Resolution) -> float:
    return size.samples + _MIXTURE * size.components**2


def _grid_work(plan: Plan) -> float:
    """Estimate the work of nodes, of their trials, and of the choice of the mixture."""
    angles, speeds = (
        first + _ADDED_SHARE * (most - first)
        for first, most in zip(plan.first, plan.most, strict=True)
    )
    states = sample_size(plan.config.accuracy, SMALLEST_CHEAP_SAMPLES)
    # if there is a choice of mixtures, the largest is the one that the accuracy is likely to need
    work = angles * speeds * _node_work(plan.sizes[-1])
    if len(plan.sizes) > 1:
        work += _PROBES * (_node_work(plan.sizes[-1]) + _CHEAP_STATE * states + _CLASSIFIER)
    if plan.first != plan.most:
        trials = _count_trials(plan.first, angles, speeds)
        work += trials * _TRIED_SHARE * _CHEAP_STATE * states
        work += (angles - 1) * (_CHEAP_STATE * states + _CLASSIFIER)
    return work


def _count_trials(first: tuple[int, int], angles: float, speeds: float) -> float:
    """Count the trials on the edges of a first grid, on halves of edges, and in final cells."""
    between_angles = first[0] - 1 + 2 * (angles - first[0])
    between_speeds = first[1] - 1 + 2 * (speeds - first[1])
    edges = between_angles * first[1] + between_speeds * first[0]
    return edges + (angles - 1) * (speeds - 1)


def _spin_law_work(plan: Plan) -> float:
    return sum(
        (sizes.leaves + sizes.nonspinning_leaves)
        * sizes.rebounds
        * (_REBOUND + _REBOUND_BY_EXPERT * sizes.groups * sizes.experts)
        for sizes in plan.spin.values()
    )


def _measurement_work(plan: Plan, conditions: int) -> float:
    if conditions == 0:
        return 0.0
    config = plan.config
    work = conditions * (_STATE * sample_size(config.accuracy) + _CLASSIFIER)
    if config.spin:
        work += conditions * (_STATE * sample_size(config.spin_targets) + _CLASSIFIER) + _CHAINS
    return work


def time_text(seconds: float) -> str:
    """Write a duration [s] in a unit that fits it."""
    units = {"hours": 3600.0, "minutes": 60.0, "seconds": 1.0}
    unit = next((name for name, length in units.items() if seconds >= 2.0 * length), "seconds")
    return f"{float(f'{max(seconds / units[unit], 1.0):.2g}'):g} {unit}"


def spent_text(spent: float, quoted: Cost | None = None) -> str:
    """Describe the processor time [s] that was spent, and the estimate before."""
    text = f"{time_text(spent)} of one processor"
    return f"{text}, where {time_text(quoted.seconds)} were estimated" if quoted else text


def cost_text(cost: Cost, workers: int | None) -> str:
    """Describe a cost in one line; ``workers`` is their number, if it is known."""
    plan = cost.plan
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
    text += f"; about {time_text(cost.seconds)} of one processor"
    if cost.spent > 0.0:
        text += f" after the {time_text(cost.spent)} that are done"
    if workers is not None and workers > 1:
        text += f", {time_text(cost.seconds / workers)} on {workers}"
    return text
