"""The spin law of a configuration: its tasks, and the datasets that they make.

One task draws the conditions of a shape and grows its tree, and one task fits each leaf. Random
numbers are keyed by the seed of the configuration and the key of the task.
"""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.formats.bounds import N_KAPPA_QUANTILES, SPEED_COORDINATE
from sampler.formats.channels import has_works
from tablegen.checkpoints import Arrays, Task, TaskRunner, stable_number
from tablegen.config.config import Config
from tablegen.config.pairs import ExponentialRestitution, TabulatedRestitution
from tablegen.config.population import Population
from tablegen.fitting.law_conditions import (
    Range,
    grains_of,
    inertia_coefficients,
    moments_of,
    nonspinning_impacts,
    ratio_range,
    spinning_impacts,
)
from tablegen.fitting.leaf import LeafArrays, Rebounds, fit_leaf
from tablegen.fitting.resolution import SpinSizes
from tablegen.fitting.spin_coordinates import (
    INPUT_SIGNS,
    OUTCOME_SIGNS,
    SPIN_RANGE,
    Moments,
    SpeedCoordinate,
    inertia_at,
    inputs_of,
    kappa_of,
    normal_share,
    outcomes_of,
    reflected,
    turned_by_chance,
)
from tablegen.fitting.tree import Tree, grow, joined
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import Impacts, depart, energy_factor

#: Speed coordinates where the law of restitution has none of this form: exponents, and parts of the
#: largest V_e at which the coordinate is 1/2. The first is that of laws without a table.
_SHAPES = [(0.5, 0.2), (0.5, 1.0), (1.0, 0.2), (1.0, 0.5), (1.0, 2.0)]

#: Column of kappa among the inputs.
_KAPPA = 5

#: Conditions that are drawn at a time.
_BATCH = 50_000


class LeafConditions(NamedTuple):
    """Conditions of a leaf, float32, which are reflected, and which are in it, (n,) bool.

    Conditions (n, 6) are angle, speed, the spin's components, and kappa; ratios (n, 2).
    """

    conditions: NDArray[np.float32]
    ratios: NDArray[np.float32]
    turned: NDArray[np.bool_]
    inside: NDArray[np.bool_]

    def part(self, rows: NDArray[np.int64], inside: NDArray[np.bool_]) -> "LeafConditions":
        """Select the conditions of a smaller leaf, and say which are in it."""
        return LeafConditions(self.conditions[rows], self.ratios[rows], self.turned[rows], inside)


class ShapeConditions(NamedTuple):
    """Conditions of the leaves of a shape, one leaf after another, and the tree of the leaves.

    The first four are those of `LeafConditions`; ``starts`` (leaves + 1,) is where each leaf
    begins; ``axis``, ``cut`` and ``child`` are those of `Tree`; ``kappa`` are quantiles.
    """

    conditions: NDArray[np.float32]
    ratios: NDArray[np.float32]
    turned: NDArray[np.bool_]
    inside: NDArray[np.bool_]
    starts: NDArray[np.int64]
    axis: NDArray[np.int8]
    cut: FloatArray
    child: NDArray[np.int32]
    kappa: FloatArray

    @property
    def leaves(self) -> int:
        """Number of leaves."""
        return len(self.starts) - 1

    def of_leaf(self, number: int) -> LeafConditions:
        """Conditions of one leaf."""
        part = slice(self.starts[number], self.starts[number + 1])
        return LeafConditions._make(column[part] for column in self[:4])


#: Draws some impacts, the number of a batch being given.
Draw = Callable[[int, int], Impacts]


def spin_law(
    config: Config, runner: TaskRunner, sizes: Mapping[int, SpinSizes]
) -> dict[str, NDArray[Any]]:
    """Make the spin law of a configuration, with sizes by code of the shape.

    Returns the datasets of `sampler.formats.layout` by path, but for those of the accuracy.
    """
    codes = list(sizes)
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
        "spin/kappa_quantiles": np.array([shape.kappa for shape in shapes]),
        **stacked,
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
        "spin/alpha_range_deg": np.degrees(Range.of(config).alpha),
        "spin/speed_range": np.array(Range.of(config).effective),
        "spin/spin_range": np.array(SPIN_RANGE),
        "spin/shape_inertia": np.array(
            [inertia_coefficients(config.population, code) for code in codes]
        ),
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
    """Choose the coordinate of the speed: that of the restitution law if a file can have it.

    Of a tabulated law it is that in which the mean restitution comes nearest to a line.
    """
    law, covered = config.pair.restitution, Range.of(config).effective
    if isinstance(law, ExponentialRestitution):
        own = SpeedCoordinate(law.coefficient, law.exponent)
        if all(SPEED_COORDINATE[0] <= number <= SPEED_COORDINATE[1] for number in own):
            return own
    shapes = [SpeedCoordinate(math.log(2.0) / (part * covered[1]) ** n, n) for n, part in _SHAPES]
    if not isinstance(law, TabulatedRestitution) or not law.depends_on_speed:
        return shapes[0]
    speeds = np.linspace(*covered, 200)
    mean = np.interp(speeds, law.speed, np.mean(law.value, axis=0))

    def misfit(shape: SpeedCoordinate) -> float:
        return float(np.polyfit(shape.of(speeds), mean, 1, full=True)[1].sum())

    return min(shapes, key=misfit)


def _stream(key: str, number: int = 0) -> int:
    """Stream of random numbers of a task, below 2**32 and apart from those of nodes."""
    return (2**31 + stable_number(key, 31) + number) % 2**32


def conditions_task(config: Config, shape_code: int, sizes: SpinSizes, key: str) -> Arrays:
    """Draw the conditions of the leaves of a shape, and grow their tree: `ShapeConditions`."""
    domain, population, model = Range.of(config), config.population, DirectModel(config)
    rng = np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))
    kappa = []

    def nonspinning(count: int, _: int) -> Impacts:
        return nonspinning_impacts(domain, grains_of(population, shape_code, count, rng), rng)

    def spinning(count: int, batch: int) -> Impacts:
        seed = partial(_stream, f"{key} {batch}")
        impacts, after = spinning_impacts(model, domain, population, shape_code, count, seed, rng)
        kappa.append(after)
        return impacts

    def grown(draw: Draw, leaves: int, number: int) -> tuple[Tree, list[LeafConditions]]:
        whole, inputs = _drawn(config, draw, sizes.conditions(leaves), rng)

        def outcomes(rows: NDArray[np.int64]) -> FloatArray:
            return _rebounds(model, config, shape_code, whole, rows, _stream(key, number)).outcomes

        with threadpool_limits(limits=1, user_api="blas"):
            tree, parts = grow(inputs, outcomes, leaves, rng)
        return tree, [whole.part(rows, inside) for rows, inside in parts]

    first, parts = grown(nonspinning, sizes.nonspinning_leaves, 0)
    second, others = grown(spinning, sizes.leaves, 1)
    tree, parts = joined(first, len(parts), second), [*parts, *others]
    columns = (np.concatenate(column) for column in zip(*parts, strict=True))
    starts = np.cumsum([0, *(len(part.inside) for part in parts)])
    quantiles = np.quantile(np.concatenate(kappa), np.linspace(0.0, 1.0, N_KAPPA_QUANTILES))
    return ShapeConditions._make([*columns, starts, *tree, quantiles])._asdict()


def _drawn(
    config: Config, draw: Draw, count: int, rng: np.random.Generator
) -> tuple[LeafConditions, NDArray[np.float32]]:
    """Draw conditions, all of one leaf, and their folded inputs (n, 8).

    A batch of them is drawn at a time, because impacts take three times as much memory.
    """
    batches = math.ceil(count / _BATCH)
    drawn = (draw(math.ceil(count / batches), batch) for batch in range(batches))
    parts = [_stored(config, impacts, rng) for impacts in drawn]
    columns, ratios, turned, inputs = map(np.concatenate, zip(*parts, strict=True))
    return LeafConditions(columns, ratios, turned, np.ones(len(turned), dtype=bool)), inputs


def _stored(config: Config, impacts: Impacts, rng: np.random.Generator) -> list[NDArray[Any]]:
    """Round impacts of a shape to the first three arrays of `LeafConditions`, and folded inputs."""
    if not config.pair.restitution.depends_on_speed:
        # all at one V_e: no leaf is cut in it
        speed = Range.of(config).effective[1] / energy_factor(impacts.spin, impacts.inertia)
        impacts = impacts._replace(speed=speed)
    ratios = impacts.grain[:, 1:]
    moments = moments_of(config.population, int(impacts.grain[0, 0]), ratios)
    inputs = inputs_of(impacts, moments, speed_coordinate(config))
    turned = turned_by_chance(inputs, rng)
    columns = np.column_stack([impacts.alpha1, impacts.speed, impacts.spin, inputs[:, _KAPPA]])
    inputs = reflected(inputs, turned, INPUT_SIGNS)
    return [columns.astype("f4"), ratios.astype("f4"), turned, inputs.astype("f4")]


def leaf_task(
    config: Config, shape_code: int, place: LeafConditions, sizes: SpinSizes, key: str
) -> Arrays:
    """Simulate rebounds at the conditions of a leaf, and fit it: `LeafArrays`."""
    model = DirectModel(config)
    rng = np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))

    def rebounds(rows: NDArray[np.int64], number: int) -> Rebounds:
        # each condition about equally often, or some of many, in random order
        order = rng.permutation(np.resize(rng.permutation(rows), sizes.rebounds))
        return _rebounds(model, config, shape_code, place, order, _stream(key, number))

    # one BLAS thread: leaves are fitted in parallel, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        around = rebounds(np.arange(len(place.inside)), 0)
        within = rebounds(np.flatnonzero(place.inside), 1)
        leaf = fit_leaf(around, within, sizes, rng)
    return leaf._asdict()


def _rebounds(
    model: DirectModel,
    config: Config,
    shape_code: int,
    place: LeafConditions,
    rows: NDArray[np.int64],
    seed: int,
) -> Rebounds:
    """Simulate a rebound at each of some conditions of a leaf: folded inputs and outcomes."""
    impacts, moments = _impacts(config.population, shape_code, place, rows)
    turned = place.turned[rows]
    inputs = reflected(inputs_of(impacts, moments, speed_coordinate(config)), turned, INPUT_SIGNS)
    left = depart(model, impacts, seed, threads=1)
    energy = energy_factor(impacts.spin, impacts.inertia) ** 2
    after = np.where(left.inertia > 0.0, left.inertia, moments.largest)
    values = np.column_stack([outcomes_of(left.states, after, energy), kappa_of(after, moments)])
    values = reflected(values, turned, OUTCOME_SIGNS)
    if has_works(config.domain.columns):
        values = np.column_stack([values, normal_share(left.works)])
    return Rebounds(inputs, values)


def _impacts(
    population: Population, shape_code: int, place: LeafConditions, rows: NDArray[np.int64]
) -> tuple[Impacts, Moments]:
    """Make impacts of some conditions of a leaf, with the moments of inertia of their grains."""
    conditions, ratios = (column[rows].astype("f8") for column in place[:2])
    count = len(rows)
    grain = np.column_stack([np.full(count, float(shape_code)), ratios])
    spin, moments = conditions[:, 2:5], moments_of(population, shape_code, ratios)
    inertia = np.where(spin.any(axis=1), inertia_at(conditions[:, 5], moments), 0.0)
    impacts = Impacts(
        # pi/2 in single precision is above pi/2
        np.minimum(conditions[:, 0], math.pi / 2.0),
        conditions[:, 1],
        spin,
        inertia,
        grain,
        np.arange(count, dtype=np.uint64),
        np.ones(count, dtype=np.uint32),
    )
    return impacts, moments
