"""The spin law of a configuration: its tasks run, and the datasets that they make."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tablegen.accuracy.measure import spin_accuracy_datasets
from tablegen.config.config import Config
from tablegen.fitting.fit_tasks import (
    ShapeConditions,
    conditions_task,
    leaf_task,
    speed_coordinate,
)
from tablegen.fitting.law_conditions import Range, ratio_range
from tablegen.fitting.leaf import LeafArrays
from tablegen.fitting.leaf_sizes import spin_sizes
from tablegen.fitting.tree import Tree
from tablegen.tasks.runner import Task, TaskRunner


def spin_law(config: Config, runner: TaskRunner) -> dict[str, NDArray[Any]]:
    """Make the spin law of a configuration.

    Parameters
    ----------
    config : Config
    runner : TaskRunner

    Returns
    -------
    dict from path to array
        The datasets of `sampler.formats.spin_layout`, those of the accuracy empty.
    """
    codes = [int(code) for code in config.population.kernel_arguments().shape_codes]
    sizes = {code: spin_sizes(config).of_shape(code) for code in codes}
    keys = {f"spin conditions {code} {tuple(sizes[code])}": code for code in codes}
    tasks = {
        key: Task(conditions_task, (config, code, sizes[code], key)) for key, code in keys.items()
    }
    made = runner.run("conditions with spin", tasks)
    found = {
        code: ShapeConditions(**{name: made[key][name] for name in ShapeConditions._fields})
        for key, code in keys.items()
    }
    leaves = {}
    for code, place in found.items():
        for number in range(len(place.starts) - 1):
            key = f"spin leaf {code} {number} {tuple(sizes[code])}"
            arguments = (config, code, place.of_leaf(number), sizes[code], key)
            leaves[key] = Task(leaf_task, arguments)
    fitted = runner.run("fitting leaves", leaves)
    stacked = {
        f"spin/{name}": np.stack([arrays[name] for arrays in fitted.values()])
        for name in LeafArrays._fields
    }
    trees = [Tree(place.axis, place.cut, place.child) for place in found.values()]
    counts = [len(place.starts) - 1 for place in found.values()]
    return {
        **_population(config, codes),
        **_domain(config),
        **_forest(trees, counts),
        **stacked,
        **spin_accuracy_datasets(None),
    }


def _population(config: Config, codes: list[int]) -> dict[str, NDArray[Any]]:
    """Shapes and ratios that the law is made for, and their law in the population."""
    arguments = config.population.kernel_arguments()
    return {
        "spin/shape_codes": np.array(codes, dtype=np.int32),
        "spin/shape_weights": np.diff(arguments.cumulative_weights, prepend=0.0),
        "spin/ratio_range": np.array([ratio_range(config.population, code) for code in codes]),
        "spin/aspect": arguments.aspect,
    }


def _domain(config: Config) -> dict[str, NDArray[Any]]:
    """Conditions that the law covers."""
    return {
        "spin/speed_coordinate": np.array(speed_coordinate(config)),
        "spin/alpha_range_deg": np.array(config.domain.alpha_deg),
        "spin/speed_range": np.array(Range.of(config).speed),
    }


def _forest(trees: list[Tree], leaves: list[int]) -> dict[str, NDArray[Any]]:
    """Trees of all shapes one after another."""
    nodes = np.cumsum([0, *(len(tree.axis) for tree in trees)])
    before = np.cumsum([0, *leaves])
    child = [
        np.where(tree.child >= 0, tree.child + node, tree.child - leaf)
        for tree, node, leaf in zip(trees, nodes[:-1], before[:-1], strict=True)
    ]
    return {
        "spin/roots": nodes[:-1].astype(np.int32),
        "spin/node_axis": np.concatenate([tree.axis for tree in trees]),
        "spin/node_cut": np.concatenate([tree.cut for tree in trees]),
        "spin/node_child": np.concatenate(child).astype(np.int32),
    }
