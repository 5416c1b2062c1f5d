"""The spin law of a configuration: its tasks, and the datasets that they make.

One task draws the conditions of a shape and grows its tree, and one task fits each leaf. Random
numbers are keyed by the seed of the configuration and the key of the task.
"""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.formats.bounds import FOLD, SPEED_COORDINATE
from sampler.formats.channels import has_works
from tablegen.checkpoints import Arrays, Task, TaskRunner, stable_number
from tablegen.config.config import Config
from tablegen.config.pairs import ExponentialRestitution
from tablegen.fitting.law_conditions import (
    Range,
    grains_of,
    inertia_coefficients,
    ratio_range,
    spinning_impacts,
    still_impacts,
)
from tablegen.fitting.leaf import LeafArrays, Rebounds, fit_leaf
from tablegen.fitting.resolution import SpinSizes
from tablegen.fitting.round_grains import less_spheres, sphere_laws, sphere_states
from tablegen.fitting.spin_coordinates import (
    SPIN_RANGE,
    SpeedCoordinate,
    coordinates,
    folded,
    work_shares,
)
from tablegen.fitting.tree import Tree, grow, joined
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import Impacts, depart, energy_factor

#: Speed coordinate where the law of restitution has none of this form: its exponent, and the part
#: of the largest V_e at which it is 1/2.
_EXPONENT, _HALF_WAY = 0.5, 0.2

#: Number of conditions without spin over the rebounds of a leaf.
_STILL = 0.5

#: Angles [rad] by which particles tumble on before each rebound of a fit.
_TUMBLED = 3.0, 15.0


class LeafConditions(NamedTuple):
    """Conditions of a leaf, float32, which are reflected, and which are in it, (n,) bool.

    Conditions (n, 5), ratios (n, 2), and quaternions (n, 4) from body to wall axes; zeros: random.
    """

    conditions: NDArray[np.float32]
    ratios: NDArray[np.float32]
    orientation: NDArray[np.float32]
    turned: NDArray[np.bool_]
    inside: NDArray[np.bool_]


class ShapeConditions(NamedTuple):
    """Conditions of the leaves of a shape, one leaf after another, and the tree of the leaves.

    The first five are those of `LeafConditions`; ``starts`` (leaves + 1,) is where each leaf
    begins; the others are those of `Tree`.
    """

    conditions: NDArray[np.float32]
    ratios: NDArray[np.float32]
    orientation: NDArray[np.float32]
    turned: NDArray[np.bool_]
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
        return LeafConditions._make(column[part] for column in self[:5])


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
        **stacked,
        **({"spin/laws": sphere_laws(config)} if less_spheres(config) else {}),
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
    """Choose the coordinate of the speed: that of the restitution law if a file can have it."""
    law = config.pair.restitution
    if isinstance(law, ExponentialRestitution):
        own = SpeedCoordinate(law.coefficient, law.exponent)
        if all(SPEED_COORDINATE[0] <= number <= SPEED_COORDINATE[1] for number in own):
            return own
    half = _HALF_WAY * Range.of(config).speed[1]
    return SpeedCoordinate(math.log(2.0) / half**_EXPONENT, _EXPONENT)


def _stream(key: str, number: int = 0) -> int:
    """Stream of random numbers of a task, below 2**32 and apart from those of nodes."""
    return (2**31 + stable_number(key, 31) + number) % 2**32


def conditions_task(config: Config, shape_code: int, sizes: SpinSizes, key: str) -> Arrays:
    """Draw the conditions of the leaves of a shape, and grow their tree: `ShapeConditions`."""
    domain, population = Range.of(config), config.population
    rng = np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))
    spinning = spinning_impacts(
        DirectModel(config),
        domain,
        population,
        shape_code,
        sizes.conditions,
        partial(_stream, key),
        rng,
    )
    count = math.ceil(_STILL * sizes.rebounds) * sizes.still_leaves
    still = still_impacts(domain, grains_of(population, shape_code, count, rng), rng)
    first, parts = _grown(config, still, sizes.still_leaves, sizes.rebounds)
    second, others = _grown(config, spinning, sizes.leaves, sizes.rebounds)
    tree, parts = joined(first, len(parts), second), [*parts, *others]
    columns = (np.concatenate(column) for column in zip(*parts, strict=True))
    starts = np.cumsum([0, *(len(part.inside) for part in parts)])
    whole = ShapeConditions._make([*columns, starts, *tree])
    return whole._asdict()


def _grown(
    config: Config, impacts: Impacts, leaves: int, most: int
) -> tuple[Tree, list[LeafConditions]]:
    """Tree of impacts, and at most ``most`` conditions of each leaf.

    Leaves at the fold have the conditions next to it on the other side, too.
    """
    speed = impacts.speed
    if not config.pair.restitution.depends_on_speed:
        # all at one V_e: no leaf is cut in it
        speed = config.speeds[1] / energy_factor(impacts.spin)
    conditions = np.column_stack([impacts.alpha1, speed, impacts.spin])
    q, tilt = coordinates(conditions, speed_coordinate(config)), impacts.spin[:, 0]
    near = np.flatnonzero((tilt != 0.0) & (np.abs(q[:, 2]) < FOLD))
    number = np.concatenate([np.arange(len(q)), near])
    order = np.argsort(number, kind="stable")
    number, beyond = number[order], order >= len(q)
    turned = (tilt[number] < 0.0) != beyond
    tree, grown = grow(folded(q[number], turned)[0], leaves, ~beyond)
    parts = []
    for leaf in grown:
        rows = number[leaf.rows[:most]]
        columns = conditions[rows], impacts.grain[rows, 1:], impacts.orientation[rows]
        met, ratios, pose = (column.astype("f4") for column in columns)
        reflected = turned[leaf.rows[:most]]
        parts.append(LeafConditions(met, ratios, pose, reflected, leaf.inside[:most]))
    return tree, parts


def leaf_task(
    config: Config, shape_code: int, place: LeafConditions, sizes: SpinSizes, key: str
) -> Arrays:
    """Simulate rebounds at the conditions of a leaf, and fit it: `LeafArrays`."""
    model = DirectModel(config)
    rng = np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))
    largest, smallest = inertia_coefficients(config.population, shape_code)

    def rebounds(rows: NDArray[np.int64], number: int) -> Rebounds:
        # each condition about equally often, in random order
        order = rng.permutation(np.resize(rng.permutation(rows), sizes.rebounds))
        met, ratios, pose = (column[order].astype("f8") for column in place[:3])
        # pi/2 in single precision is above pi/2
        met[:, 0] = np.minimum(met[:, 0], math.pi / 2.0)
        grains = np.column_stack([np.full(len(met), float(shape_code)), ratios])
        impacts = Impacts(met[:, 0], met[:, 1], met[:, 2:], pose, grains, *_keys(len(met)))
        left = depart(model, _turned(model, impacts, rng), _stream(key, number), threads=1)
        beta, gamma = np.square(ratios).T
        energy = 1.0 + largest * (1.0 + beta) * np.sum(met[:, 2:] ** 2, axis=1)
        shares = work_shares(left.states, left.works, energy, smallest * beta * (1.0 + gamma))
        held = shares if has_works(config.domain.columns) else shares[:, :0]
        spheres = sphere_states(config, met, ratios) if less_spheres(config) else None
        return Rebounds(met, ratios, left.states, energy, held, place.turned[order], spheres)

    around = rebounds(np.arange(len(place.conditions)), 0)
    within = rebounds(np.flatnonzero(place.inside), 1)
    # one BLAS thread: leaves are fitted in parallel, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        leaf = fit_leaf(around, within, speed_coordinate(config), sizes, rng)
    return leaf._asdict()


def _keys(count: int) -> tuple[NDArray[np.uint64], NDArray[np.uint32]]:
    """Index and hit of rebounds whose seed is their own."""
    return np.arange(count, dtype=np.uint64), np.zeros(count, dtype=np.uint32)


def _turned(model: DirectModel, impacts: Impacts, rng: np.random.Generator) -> Impacts:
    """Tumble on: a condition that is simulated again has another orientation."""
    if not impacts.orientation.any():
        return impacts
    size = np.linalg.norm(impacts.spin, axis=1)
    time = rng.uniform(*_TUMBLED, len(size)) / np.maximum(size, 1e-9)
    turned, _ = model.tumble(impacts.orientation, impacts.spin, impacts.grain, 1.0, time)
    return impacts._replace(orientation=turned)
