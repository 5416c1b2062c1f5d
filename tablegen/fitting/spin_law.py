"""Fit the spin law of a configuration, and return its datasets.

There are two kinds of tasks. For each shape, `conditions_task` draws conditions and grows the tree
that divides them into leaves. For each leaf, `leaf_task` simulates rebounds at its conditions and
fits the mixture of experts. The random numbers of a task are keyed by the seed of the configuration
and the key of the task, so a law depends neither on the number of workers nor on their order.
"""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.formats.bounds import N_DIRECTIONS, N_INPUTS, N_KAPPA_QUANTILES, SPEED_COORDINATE
from sampler.formats.channels import has_works
from sampler.formats.layout import BY_SPHERE
from tablegen.checkpoints import Arrays, Task, TaskRunner, stable_number
from tablegen.config.config import Config
from tablegen.config.pairs import ExponentialRestitution, TabulatedRestitution
from tablegen.config.population import Population
from tablegen.fitting.law_conditions import (
    covered_range,
    draw_grains,
    grain_moments,
    inertia_coefficients,
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
    beside_sphere,
    choose_reflected,
    impact_inputs,
    inertia_from_kappa,
    nominal_contact,
    normal_work_outcome,
    rebound_outcomes,
    reflect,
)
from tablegen.fitting.tree import Tree, grow_tree, join_trees
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct_law import DirectLaw
from tablegen.simulation.impact_chains import Impacts, simulate_departures
from tablegen.simulation.sphere_rebounds import (
    counts_from_spheres,
    sphere_laws,
    sphere_rebounds,
)

#: Speed coordinates to choose from if the restitution does not fall exponentially with a power of
#: the speed: exponents, and parts of the largest V_e at which the coordinate is 1/2. The first pair
#: is for restitution laws that are not tables.
_SPEED_COORDINATES = [(0.5, 0.2), (0.5, 1.0), (1.0, 0.2), (1.0, 0.5), (1.0, 2.0)]

#: Conditions that are drawn at a time: their impacts take three times as much memory.
_BATCH = 50_000

#: Rebounds that are simulated at a time: their impacts take four times as much memory.
_BLOCK = 10_000


class LeafConditions(NamedTuple):
    """Conditions in a leaf and a little beyond it."""

    #: (n, 6): angle [rad], speed V [m/s], spin [V/a] in wall axes, place kappa of its inertia.
    conditions: NDArray[np.float32]
    #: (n, 2): b/a and c/b.
    ratios: NDArray[np.float32]
    #: (n,): whether the mirror image of the condition is fitted.
    is_reflected: NDArray[np.bool_]
    #: (n,): whether the condition is in the leaf.
    inside: NDArray[np.bool_]

    def select(self, rows: NDArray[np.int64], inside: NDArray[np.bool_]) -> "LeafConditions":
        """Select the conditions of a smaller leaf; ``inside`` tells which ones are in it."""
        return LeafConditions(
            self.conditions[rows], self.ratios[rows], self.is_reflected[rows], inside
        )


class ShapeConditions(NamedTuple):
    """Conditions of the leaves of a shape, and the tree that finds the leaf of a condition."""

    #: Arrays of `LeafConditions`, one leaf after another.
    conditions: NDArray[np.float32]
    ratios: NDArray[np.float32]
    is_reflected: NDArray[np.bool_]
    inside: NDArray[np.bool_]
    #: (leaves + 1,): row at which each leaf begins, and the end of the last leaf.
    starts: NDArray[np.int64]
    #: Arrays of `Tree`.
    axis: NDArray[np.int8]
    cut: FloatArray
    child: NDArray[np.int32]
    #: Quantiles of the place kappa after first hits.
    kappa: FloatArray

    @property
    def leaves(self) -> int:
        """Number of leaves."""
        return len(self.starts) - 1

    def leaf_conditions(self, number: int) -> LeafConditions:
        """Select the conditions of a leaf."""
        rows = slice(self.starts[number], self.starts[number + 1])
        return LeafConditions._make(column[rows] for column in self[:4])


#: Function that draws impacts, from their count and the number of the batch.
Draw = Callable[[int, int], Impacts]


def spin_law(
    config: Config, runner: TaskRunner, sizes: Mapping[int, SpinSizes]
) -> dict[str, NDArray[Any]]:
    """Fit the spin law of a configuration.

    Parameters
    ----------
    config : Config
    runner : TaskRunner
        Runs the tasks, and keeps finished results.
    sizes : mapping
        Sizes of the law by code of the shape.

    Returns
    -------
    dict
        Arrays by path of the dataset: all datasets of the spin law but those of its accuracy.
    """
    codes = list(sizes)
    keys = {code: f"spin conditions {code} {tuple(sizes[code])}" for code in codes}
    tasks = {
        key: Task(conditions_task, (config, code, sizes[code], key)) for code, key in keys.items()
    }
    # they take a thirtieth of the time of the leaves, and ten times as many bytes
    results = runner.run("conditions with spin", tasks, stored=False)
    shapes = [
        ShapeConditions(**{name: results[key][name] for name in ShapeConditions._fields})
        for key in keys.values()
    ]
    leaves = {}
    for code, shape in zip(codes, shapes, strict=True):
        for number in range(shape.leaves):
            key = f"spin leaf {code} {number} {tuple(sizes[code])}"
            leaves[key] = Task(
                leaf_task, (config, code, shape.leaf_conditions(number), sizes[code], key)
            )
    fitted = runner.run("fitting leaves", leaves).values()
    stacked = {
        f"spin/{name}": np.stack([arrays[name] for arrays in fitted]) for name in LeafArrays._fields
    }
    by_sphere = any(counts_from_spheres(config, code) for code in codes)
    return {
        **({BY_SPHERE.path: sphere_laws(config)} if by_sphere else {}),
        **_coverage_datasets(config, codes),
        **_tree_datasets(shapes),
        "spin/kappa_quantiles": np.array([shape.kappa for shape in shapes]),
        **stacked,
    }


def _coverage_datasets(config: Config, codes: list[int]) -> dict[str, NDArray[Any]]:
    """Make the datasets of the grains of the population, and of the range that the law covers."""
    arguments, geometry = config.population.kernel_arguments(), config.population.shape_geometry()
    return {
        "spin/shape_codes": np.array(codes, dtype=np.int32),
        "spin/shape_weights": np.diff(arguments.cumulative_weights, prepend=0.0),
        "spin/ratio_range": np.array([ratio_range(config.population, code) for code in codes]),
        "spin/aspect": arguments.aspect,
        "spin/speed_coordinate": np.array(speed_coordinate(config)[:2]),
        "spin/alpha_range_deg": np.degrees(covered_range(config).alpha),
        "spin/speed_range": np.array(covered_range(config).effective),
        "spin/spin_range": np.array(SPIN_RANGE),
        "spin/shape_inertia": np.array(
            [inertia_coefficients(config.population, code) for code in codes]
        ),
        "spin/shape_geometry": np.array([geometry[code] for code in codes]),
    }


def _tree_datasets(shapes: list[ShapeConditions]) -> dict[str, NDArray[Any]]:
    """Make the datasets of the trees of all shapes, one after another."""
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
    """Choose the coordinate of the speed, in which the experts are linear.

    If restitution falls as exp(-A V^n), this is the coordinate, provided that a file can store A
    and n. For a tabulated restitution it is the coordinate in which the mean restitution comes
    nearest to a line. It is constant if restitution does not depend on the speed.
    """
    law, (low, high) = config.pair.restitution, covered_range(config).effective
    if not law.depends_on_speed:
        least = SPEED_COORDINATE[0]
        return SpeedCoordinate(least, least, high)
    if isinstance(law, ExponentialRestitution):
        coordinate = SpeedCoordinate(law.coefficient, law.exponent, high)
        if all(SPEED_COORDINATE[0] <= number <= SPEED_COORDINATE[1] for number in coordinate[:2]):
            return coordinate
    candidates = [
        SpeedCoordinate(math.log(2.0) / (part * high) ** n, n, high)
        for n, part in _SPEED_COORDINATES
    ]
    if not isinstance(law, TabulatedRestitution):
        return candidates[0]
    speeds = np.linspace(low, high, 200)
    mean = np.interp(speeds, law.speed, np.mean(law.value, axis=0))

    def misfit(coordinate: SpeedCoordinate) -> float:
        return float(np.polyfit(coordinate.transform(speeds), mean, 1, full=True)[1].sum())

    return min(candidates, key=misfit)


def _stream(key: str, number: int = 0) -> int:
    """Compute a stream of random numbers of a task, below 2**32 and apart from those of nodes."""
    return (2**31 + stable_number(key, 31) + number) % 2**32


def conditions_task(config: Config, shape_code: int, sizes: SpinSizes, key: str) -> Arrays:
    """Draw the conditions of a shape and grow the tree of its leaves.

    Conditions without spin and conditions with spin have trees of their own, which are joined.
    Returns the arrays of `ShapeConditions`.
    """
    domain, population, law = (
        covered_range(config),
        config.population,
        DirectLaw.from_config(config),
    )
    rng = np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))
    kappa_by_batch = []

    def draw_nonspinning(count: int, _: int) -> Impacts:
        return nonspinning_impacts(domain, draw_grains(population, shape_code, count, rng), rng)

    def draw_spinning(count: int, batch: int) -> Impacts:
        seed = partial(_stream, f"{key} {batch}")
        impacts, kappa = spinning_impacts(law, domain, population, shape_code, count, seed, rng)
        kappa_by_batch.append(kappa)
        return impacts

    def divide(draw: Draw, count: int, number: int) -> tuple[Tree, list[LeafConditions]]:
        conditions, inputs = _draw_conditions(config, draw, sizes.conditions(count), rng)
        seed = _stream(key, number)

        def simulate_outcomes(rows: NDArray[np.int64]) -> FloatArray:
            return _rebounds(law, config, shape_code, conditions, rows, seed).outcomes

        # one BLAS thread: the tasks run in parallel, and sums keep their order
        with threadpool_limits(limits=1, user_api="blas"):
            tree, leaves = grow_tree(inputs, simulate_outcomes, count, rng)
        del inputs
        return tree, [conditions.select(rows, inside) for rows, inside in leaves]

    nonspinning_tree, leaves = divide(draw_nonspinning, sizes.nonspinning_leaves, 0)
    nonspinning_leaves = len(leaves)
    spinning_tree, spinning_leaves = divide(draw_spinning, sizes.leaves, 1)
    leaves.extend(spinning_leaves)
    del spinning_leaves
    tree = join_trees(nonspinning_tree, nonspinning_leaves, spinning_tree)
    starts = np.cumsum([0, *(len(leaf.inside) for leaf in leaves)])
    probabilities = np.linspace(0.0, 1.0, N_KAPPA_QUANTILES)
    quantiles = np.quantile(np.concatenate(kappa_by_batch), probabilities)
    return ShapeConditions._make([*_take_columns(leaves), starts, *tree, quantiles])._asdict()


def _take_columns(parts: list[Any]) -> list[NDArray[Any]]:
    """Empty a list of tuples of arrays, and concatenate the first arrays, the second ones, ...

    The parts of an array are freed before the next array is made, because they are large.
    """
    columns = [list(column) for column in zip(*parts, strict=True)]
    parts.clear()
    return [np.concatenate(columns.pop(0)) for _ in range(len(columns))]


def _draw_conditions(
    config: Config, draw: Draw, count: int, rng: np.random.Generator
) -> tuple[LeafConditions, NDArray[np.float32]]:
    """Draw the conditions of a whole tree, and their folded inputs (n, 13)."""
    batches = math.ceil(count / _BATCH)
    impacts_by_batch = (draw(math.ceil(count / batches), batch) for batch in range(batches))
    parts = [_rounded_conditions(config, impacts, rng) for impacts in impacts_by_batch]
    columns, ratios, is_reflected, inputs = _take_columns(parts)
    inside = np.ones(len(columns), dtype=bool)
    return LeafConditions(columns, ratios, is_reflected, inside), inputs


def _rounded_conditions(
    config: Config, impacts: Impacts, rng: np.random.Generator
) -> list[NDArray[Any]]:
    """Convert impacts of a shape to the first three arrays of `LeafConditions`, and folded inputs.

    All of them are rounded to single precision.
    """
    ratios = impacts.grain[:, 1:]
    moments = grain_moments(config.population, int(impacts.grain[0, 0]), ratios)
    contact = nominal_contact(impacts, moments)
    inputs = impact_inputs(impacts, moments, contact, speed_coordinate(config))
    is_reflected = choose_reflected(inputs, rng)
    columns = np.column_stack([impacts.alpha1, impacts.speed, impacts.spin, contact.kappa])
    inputs = reflect(inputs, is_reflected, INPUT_SIGNS)
    return [columns.astype("f4"), ratios.astype("f4"), is_reflected, inputs.astype("f4")]


def leaf_task(
    config: Config, shape_code: int, leaf: LeafConditions, sizes: SpinSizes, key: str
) -> Arrays:
    """Simulate rebounds at the conditions of a leaf, and fit it; returns arrays of `LeafArrays`."""
    law = DirectLaw.from_config(config)
    rng = np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))

    if not leaf.conditions[:, 2:5].any():
        sizes = sizes._replace(experts=sizes.nonspinning_experts)
    # rebounds are in random order, and each condition is simulated about equally often; if there
    # are more conditions than rebounds, some are left out
    conditions = rng.permutation(len(leaf.inside))
    rows = rng.permutation(np.resize(conditions, sizes.rebounds))
    # one BLAS thread: leaves are fitted in parallel, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        return fit_leaf(
            # no name here, so that `fit_leaf` can free them
            _rebounds(law, config, shape_code, leaf, rows, _stream(key)),
            leaf.inside[rows],
            sizes,
            rng,
        )._asdict()


def _rebounds(
    law: DirectLaw,
    config: Config,
    shape_code: int,
    leaf: LeafConditions,
    rows: NDArray[np.int64],
    seed: int,
) -> Rebounds:
    """Simulate a rebound at each condition of the given rows; inputs and outcomes are folded."""
    count, outcomes = len(rows), len(OUTCOME_SIGNS) + has_works(config.domain.columns)
    rebounds = Rebounds(np.empty((count, N_INPUTS + N_DIRECTIONS)), np.empty((count, outcomes)))
    for first in range(0, count, _BLOCK):
        block = slice(first, first + _BLOCK)
        rebounds.inputs[block], rebounds.outcomes[block] = _block_of_rebounds(
            law, config, shape_code, leaf, rows[block], first, seed
        )
    return rebounds


def _block_of_rebounds(
    law: DirectLaw,
    config: Config,
    shape_code: int,
    leaf: LeafConditions,
    rows: NDArray[np.int64],
    first: int,
    seed: int,
) -> Rebounds:
    """Simulate some of the rebounds of `_rebounds`; ``first`` is the number of the first one."""
    impacts, moments = _impacts(config.population, shape_code, leaf, rows, first)
    is_reflected, contact = leaf.is_reflected[rows], nominal_contact(impacts, moments)
    inputs = impact_inputs(impacts, moments, contact, speed_coordinate(config))
    inputs = reflect(inputs, is_reflected, INPUT_SIGNS)
    if counts_from_spheres(config, shape_code) and not impacts.spin.any():
        contact = beside_sphere(contact, impacts, sphere_rebounds(config, impacts))
    departures = simulate_departures(law, impacts, seed, threads=1)
    inertia = np.where(departures.inertia > 0.0, departures.inertia, moments.largest)
    outcomes = rebound_outcomes(departures.states, inertia, moments, contact)
    outcomes = reflect(outcomes, is_reflected, OUTCOME_SIGNS)
    if has_works(config.domain.columns):
        outcomes = np.column_stack([outcomes, normal_work_outcome(departures.works)])
    return Rebounds(inputs, outcomes)


def _impacts(
    population: Population,
    shape_code: int,
    leaf: LeafConditions,
    rows: NDArray[np.int64],
    first: int,
) -> tuple[Impacts, Moments]:
    """Make impacts of the given rows of conditions, and the moments of inertia of their grains.

    The keys of the impacts count from ``first``.
    """
    conditions, ratios = (column[rows].astype("f8") for column in leaf[:2])
    count = len(rows)
    grain = np.column_stack([np.full(count, float(shape_code)), ratios])
    spin, moments = conditions[:, 2:5], grain_moments(population, shape_code, ratios)
    inertia = np.where(spin.any(axis=1), inertia_from_kappa(conditions[:, 5], moments), 0.0)
    impacts = Impacts(
        # a right angle in single precision is above pi/2
        np.minimum(conditions[:, 0], math.pi / 2.0),
        conditions[:, 1],
        spin,
        inertia,
        grain,
        np.arange(first, first + count, dtype=np.uint64),
        np.ones(count, dtype=np.uint32),
    )
    return impacts, moments
