"""The spin law of a configuration: its tasks, and the datasets that they make.

One task draws the conditions of a shape and grows its tree, and one task fits each leaf. Random
numbers are keyed by the seed of the configuration and the key of the task.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.formats.bounds import SPEED_COORDINATE
from tablegen.accuracy.measure import spin_accuracy_datasets
from tablegen.checkpoints import SECONDS, Arrays, Stopwatch, Task, TaskRunner, stable_number
from tablegen.config.config import Config
from tablegen.config.pairs import ExponentialRestitution
from tablegen.fitting.law_conditions import (
    Range,
    draw_ratios,
    ratio_range,
    spinning_conditions,
    still_conditions,
)
from tablegen.fitting.leaf import LeafArrays, Rebounds, fit_leaf
from tablegen.fitting.resolution import SpinSizes, spin_sizes
from tablegen.fitting.spin_coordinates import SpeedCoordinate, coordinates, folded
from tablegen.fitting.tree import Tree, grow, joined
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel

#: Speed coordinate where the law of restitution has none of this form: its exponent, and the part
#: of the largest V_e at which it is 1/2.
_EXPONENT, _HALF_WAY = 0.5, 0.2

#: Number of conditions without spin over the rebounds of a leaf.
_STILL = 0.5


class LeafConditions(NamedTuple):
    """Conditions (n, 5) and ratios (n, 2) of a leaf, float32, and which are in it, (n,) bool."""

    conditions: NDArray[np.float32]
    ratios: NDArray[np.float32]
    inside: NDArray[np.bool_]


class ShapeConditions(NamedTuple):
    """Conditions of the leaves of a shape, one leaf after another, and the tree of the leaves.

    The first three are those of `LeafConditions`; ``starts`` (leaves + 1,) is where each leaf
    begins; the others are those of `Tree`.
    """

    conditions: NDArray[np.float32]
    ratios: NDArray[np.float32]
    inside: NDArray[np.bool_]
    starts: NDArray[np.int64]
    axis: NDArray[np.int8]
    cut: FloatArray
    child: NDArray[np.int32]

    @property
    def leaves(self) -> int:
        """Number of leaves."""
        return len(self.starts) - 1

    def of_leaf(self, number: int) -> LeafConditions:
        """Conditions of one leaf."""
        part = slice(self.starts[number], self.starts[number + 1])
        return LeafConditions(self.conditions[part], self.ratios[part], self.inside[part])


def spin_law(config: Config, runner: TaskRunner) -> dict[str, NDArray[Any]]:
    """Make the spin law of a configuration.

    Returns the datasets of `sampler.formats.layout` by path; those of the accuracy are empty.
    """
    codes = [int(code) for code in config.population.kernel_arguments().shape_codes]
    sizes = {code: spin_sizes(config).of_shape(code) for code in codes}
    keys = {code: f"spin conditions {code} {tuple(sizes[code])}" for code in codes}
    tasks = {
        key: Task(conditions_task, (config, code, sizes[code], key)) for code, key in keys.items()
    }
    made = runner.run("conditions with spin", tasks)
    shapes = [
        ShapeConditions(**{name: made[key][name] for name in ShapeConditions._fields})
        for key in keys.values()
    ]
    leaves = {}
    for code, shape in zip(codes, shapes, strict=True):
        for number in range(shape.leaves):
            key = f"spin leaf {code} {number} {tuple(sizes[code])}"
            leaves[key] = Task(leaf_task, (config, code, shape.of_leaf(number), sizes[code], key))
    fitted = runner.run("fitting leaves", leaves).values()
    stacked = {
        f"spin/{name}": np.stack([arrays[name] for arrays in fitted]) for name in LeafArrays._fields
    }
    return {
        **_covered(config, codes),
        **_forest(shapes),
        **stacked,
        **spin_accuracy_datasets(None),
    }


def _covered(config: Config, codes: list[int]) -> dict[str, NDArray[Any]]:
    """Shapes, ratios and conditions that the law covers, and their law in the population."""
    arguments = config.population.kernel_arguments()
    return {
        "spin/shape_codes": np.array(codes, dtype=np.int32),
        "spin/shape_weights": np.diff(arguments.cumulative_weights, prepend=0.0),
        "spin/ratio_range": np.array([ratio_range(config.population, code) for code in codes]),
        "spin/aspect": arguments.aspect,
        "spin/speed_coordinate": np.array(speed_coordinate(config)),
        "spin/alpha_range_deg": np.array(config.domain.alpha_deg),
        "spin/speed_range": np.array(Range.of(config).speed),
    }


def _forest(shapes: list[ShapeConditions]) -> dict[str, NDArray[Any]]:
    """Trees of all shapes one after another."""
    nodes = np.cumsum([0, *(len(shape.axis) for shape in shapes)])
    leaves = np.cumsum([0, *(shape.leaves for shape in shapes)])
    child = [
        np.where(shape.child >= 0, shape.child + node, shape.child - leaf)
        for shape, node, leaf in zip(shapes, nodes[:-1], leaves[:-1], strict=True)
    ]
    return {
        "spin/roots": nodes[:-1].astype(np.int32),
        "spin/node_axis": np.concatenate([shape.axis for shape in shapes]),
        "spin/node_cut": np.concatenate([shape.cut for shape in shapes]),
        "spin/node_child": np.concatenate(child).astype(np.int32),
    }


def speed_coordinate(config: Config) -> SpeedCoordinate:
    """Choose the coordinate of the speed: that of the restitution law if a file can have it."""
    law = config.pair.restitution
    if isinstance(law, ExponentialRestitution):
        own = SpeedCoordinate(law.coefficient, law.exponent)
        if all(SPEED_COORDINATE[0] <= number <= SPEED_COORDINATE[1] for number in own):
            return own
    half = _HALF_WAY * Range.of(config).speed[1]
    return SpeedCoordinate(math.log(2.0) / half**_EXPONENT, _EXPONENT)


def _simulated(
    config: Config, conditions: FloatArray, grains: FloatArray, stream: int
) -> FloatArray:
    """States (n, 6) after rebounds of given grains."""
    return DirectModel(config).sample(
        conditions[:, 0],
        conditions[:, 1],
        spin=conditions[:, 2:],
        grain=grains,
        seed=config.table.seed,
        index=np.arange(len(conditions), dtype=np.uint64),
        hit=stream,
        threads=1,
    )


def _stream(key: str, number: int = 0) -> int:
    """Stream of random numbers of a task, below 2**32 and apart from those of nodes."""
    return (2**31 + stable_number(key, 31) + number) % 2**32


def conditions_task(config: Config, shape_code: int, sizes: SpinSizes, key: str) -> Arrays:
    """Draw the conditions of the leaves of a shape, and grow their tree: `ShapeConditions`."""
    watch, domain = Stopwatch(), Range.of(config)
    rng = np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))

    def rebound(conditions: FloatArray, grains: FloatArray, hit: int) -> FloatArray:
        return _simulated(config, conditions, grains, _stream(key, hit))

    spinning, grains = spinning_conditions(
        domain, config.population, shape_code, sizes.conditions, rebound, rng
    )
    count = math.ceil(_STILL * sizes.rebounds) * sizes.still_leaves
    still = still_conditions(domain, count, rng)
    still_ratios = draw_ratios(config.population, shape_code, count, rng)
    watch.stage("simulation")
    first, parts = _grown(config, still, still_ratios, sizes.still_leaves, sizes.rebounds)
    second, others = _grown(config, spinning, grains[:, 1:], sizes.leaves, sizes.rebounds)
    tree, parts = joined(first, len(parts), second), [*parts, *others]
    met, ratios, inside = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    starts = np.cumsum([0, *(len(part.inside) for part in parts)])
    whole = ShapeConditions(met, ratios, inside, starts, *tree)
    watch.stage("fit")
    return {**whole._asdict(), SECONDS: watch.seconds}


def _grown(
    config: Config, conditions: FloatArray, ratios: FloatArray, leaves: int, most: int
) -> tuple[Tree, list[LeafConditions]]:
    """Tree of conditions, and at most ``most`` conditions of each leaf."""
    q, _ = folded(coordinates(conditions, speed_coordinate(config)))
    tree, found = grow(q, leaves)
    parts = []
    for leaf in found:
        rows = leaf.rows[:most]
        own = conditions[rows].astype("f4"), ratios[rows].astype("f4")
        parts.append(LeafConditions(*own, leaf.inside[:most]))
    return tree, parts


def leaf_task(
    config: Config, shape_code: int, place: LeafConditions, sizes: SpinSizes, key: str
) -> Arrays:
    """Simulate rebounds at the conditions of a leaf, and fit it: `LeafArrays`."""
    watch = Stopwatch()
    rng = np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))

    def rebounds(rows: NDArray[np.int64], number: int) -> Rebounds:
        # each condition about equally often, in random order
        order = rng.permutation(np.resize(rng.permutation(rows), sizes.rebounds))
        met, drawn = place.conditions[order].astype("f8"), place.ratios[order].astype("f8")
        # pi/2 in single precision is above pi/2
        met[:, 0] = np.minimum(met[:, 0], math.pi / 2.0)
        grains = np.column_stack([np.full(len(met), float(shape_code)), drawn])
        return Rebounds(met, drawn, _simulated(config, met, grains, _stream(key, number)))

    around = rebounds(np.arange(len(place.conditions)), 0)
    within = rebounds(np.flatnonzero(place.inside), 1)
    watch.stage("simulation")
    # one BLAS thread: leaves are fitted in parallel, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        leaf = fit_leaf(around, within, speed_coordinate(config), sizes, rng)
    watch.stage("fit")
    return {**leaf._asdict(), SECONDS: watch.seconds}
