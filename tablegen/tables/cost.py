"""Estimate the processor time of a table from one node and one leaf, and describe it.

The estimate is the time of a node times the most nodes that the table may get, and the time of a
leaf times the number of leaves. Not all of these nodes are fitted, and the trials that choose them
are not counted; the two are of similar size. tablegen/fitting/EXPERIMENTS.md compares estimates
with real times.
"""

import math
import time
from typing import NamedTuple

import numpy as np

from tablegen.checkpoints import Arrays, Task
from tablegen.config.config import Config
from tablegen.fitting.law_conditions import covered_range
from tablegen.fitting.resolution import SpinSizes
from tablegen.fitting.spin_law import ShapeConditions, conditions_task, leaf_task
from tablegen.tables.plan import Plan
from tablegen.tables.refine import NodeCache

#: Rebounds of a leaf that is fitted to compile the kernels only.
_TO_COMPILE = 2000


class Cost(NamedTuple):
    """Estimated cost of a table."""

    plan: Plan
    #: Processor time [s] that is still to be spent.
    seconds: float
    #: Processor time [s] that an interrupted run spent on pieces that this run uses.
    spent: float


def estimate(plan: Plan, cache: NodeCache, spent: float) -> Cost:
    """Fit a node and a leaf, and multiply their times by the numbers of nodes and leaves.

    Parameters
    ----------
    plan : Plan
    cache : NodeCache
        Fits the node, and keeps it for the table.
    spent : float
        Processor time [s] of the pieces of an interrupted run.

    Returns
    -------
    Cost
    """
    runner, (alphas, speeds) = cache.runner, plan.grid
    begin = runner.seconds
    # if there is a choice of mixtures, the largest is the one that the accuracy is likely to need
    cache.fit(plan.sizes[-1], [(alphas[len(alphas) // 2], speeds[-1])])
    seconds = (runner.seconds - begin) * math.prod(plan.most)
    if plan.spin:
        code, sizes = next(iter(plan.spin.items()))
        tasks = {"leaf": Task(_fit_one_leaf, (plan.config, code, sizes))}
        leaf = runner.run("fitting a leaf", tasks, stored=False)["leaf"]
        seconds += float(leaf["seconds_of_leaf"]) * plan.leaves
    return Cost(plan, max(seconds - spent, 0.0), spent)


def _fit_one_leaf(config: Config, shape_code: int, sizes: SpinSizes) -> Arrays:
    """Time the fit of a leaf that holds all conditions of a shape, with kernels compiled before."""
    few = sizes._replace(leaves=1, nonspinning_leaves=1)
    shape = ShapeConditions(**conditions_task(config, shape_code, few, "estimate"))
    leaf = shape.leaf_conditions(1)
    leaf_task(config, shape_code, leaf, sizes._replace(rebounds=_TO_COMPILE), "estimate")
    begin = time.thread_time()
    leaf_task(config, shape_code, leaf, sizes, "estimate")
    return {"seconds_of_leaf": np.array(time.thread_time() - begin)}


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
