"""Tasks of a spin law: conditions and the tree of a shape, and the fit of a leaf.

Random numbers are keyed by the seed of the configuration and the key of the task.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.formats.spin_bounds import SPEED_COORDINATE
from tablegen.config.config import Config
from tablegen.config.pairs import ExponentialRestitution
from tablegen.fitting.coordinates import SpeedCoordinate, coordinates, folded
from tablegen.fitting.law_conditions import (
    Range,
    draw_ratios,
    spinning_conditions,
    still_conditions,
)
from tablegen.fitting.leaf import Rebounds, fit_leaf
from tablegen.fitting.leaf_sizes import SpinSizes
from tablegen.fitting.tree import Leaf, Tree, grow, joined
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel
from tablegen.tasks.runner import SECONDS, Arrays, Stopwatch, stable_number

#: Speed coordinate where the law of restitution has none of this form: a fifth of the largest V_e
#: is half way.
_EXPONENT, _HALF_WAY = 0.5, 0.2

#: Conditions without spin over the rebounds of a leaf.
_STILL = 0.5


class ShapeConditions(NamedTuple):
    """Conditions of a shape's leaves, one leaf after another, and the tree that finds the leaf.

    ``conditions`` (n, 5) and ``ratios`` (n, 2) float32; ``inside`` (n,) bool says which are in the
    leaf and not beside it; ``starts`` (leaves + 1,) where each leaf begins.
    """

    conditions: NDArray[np.float32]
    ratios: NDArray[np.float32]
    inside: NDArray[np.bool_]
    starts: NDArray[np.int64]
    axis: NDArray[np.int8]
    cut: FloatArray
    child: NDArray[np.int32]

    def of_leaf(self, number: int) -> tuple[NDArray[Any], ...]:
        """Conditions, ratios and what is inside of one leaf."""
        part = slice(self.starts[number], self.starts[number + 1])
        return self.conditions[part], self.ratios[part], self.inside[part]


def speed_coordinate(config: Config) -> SpeedCoordinate:
    """Coordinate of the speed: that of the restitution law if a file can have it."""
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


def _generator(config: Config, key: str) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=[config.table.seed, _stream(key)]))


def conditions_task(config: Config, shape_code: int, sizes: SpinSizes, key: str) -> Arrays:
    """Draw the conditions of the leaves of a shape, and grow their tree.

    Returns
    -------
    Arrays
        Those of `ShapeConditions`, and seconds.
    """
    watch, rng, domain = Stopwatch(), _generator(config, key), Range.of(config)

    def rebound(conditions: FloatArray, grains: FloatArray, hit: int) -> FloatArray:
        return _simulated(config, conditions, grains, _stream(key, hit))

    spinning, grains = spinning_conditions(
        domain, config.population, shape_code, sizes.conditions, rebound, rng
    )
    count = math.ceil(_STILL * sizes.rebounds) * sizes.still_leaves
    still = still_conditions(domain, count, rng)
    still_ratios = draw_ratios(config.population, shape_code, count, rng)
    watch.stage("simulation")
    found = [
        _grown(config, *part, sizes.rebounds)
        for part in (
            (still, still_ratios, sizes.still_leaves),
            (spinning, grains[:, 1:], sizes.leaves),
        )
    ]
    (one, one_parts), (other, other_parts) = found
    tree, parts = joined(one, len(one_parts), other), [*one_parts, *other_parts]
    lengths = [len(inside) for *_, inside in parts]
    conditions, ratios, inside = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    whole = ShapeConditions(conditions, ratios, inside, np.cumsum([0, *lengths]), *tree)
    watch.stage("fit")
    return {**whole._asdict(), SECONDS: watch.seconds}


def _grown(
    config: Config, conditions: FloatArray, ratios: FloatArray, leaves: int, most: int
) -> tuple[Tree, list[tuple[NDArray[Any], ...]]]:
    """Tree of conditions, and conditions, ratios and what is inside of each leaf, ``most`` each."""
    q, _ = folded(coordinates(conditions, speed_coordinate(config)))
    tree, found = grow(q, leaves)

    def part(leaf: Leaf) -> tuple[NDArray[Any], ...]:
        rows = leaf.rows[:most]
        return conditions[rows].astype("f4"), ratios[rows].astype("f4"), leaf.inside[:most]

    return tree, [part(leaf) for leaf in found]


def leaf_task(
    config: Config,
    shape_code: int,
    place: tuple[NDArray[Any], NDArray[Any], NDArray[np.bool_]],
    sizes: SpinSizes,
    key: str,
) -> Arrays:
    """Fit a leaf.

    Parameters
    ----------
    config : Config
    shape_code : int
    place : tuple of arrays
        `ShapeConditions.of_leaf`: conditions, ratios, and which of them are inside.
    sizes : SpinSizes
    key : str
        Of the task.

    Returns
    -------
    Arrays
        Those of `LeafArrays`, and seconds.
    """
    watch, rng = Stopwatch(), _generator(config, key)
    conditions, ratios, inside = place

    def rebounds(rows: NDArray[np.int64], number: int) -> Rebounds:
        # each condition about equally often, in random order
        order = rng.permutation(np.resize(rng.permutation(rows), sizes.rebounds))
        met, drawn = conditions[order].astype("f8"), ratios[order].astype("f8")
        # pi/2 in single precision is beyond it
        met[:, 0] = np.minimum(met[:, 0], math.pi / 2.0)
        grains = np.column_stack([np.full(len(met), float(shape_code)), drawn])
        return Rebounds(met, drawn, _simulated(config, met, grains, _stream(key, number)))

    around = rebounds(np.arange(len(conditions)), 0)
    within = rebounds(np.flatnonzero(inside), 1)
    watch.stage("simulation")
    shape = sizes.groups, sizes.experts, sizes.knots
    # one BLAS thread: the leaves are the parallel work, and sums keep their order
    with threadpool_limits(limits=1, user_api="blas"):
        leaf = fit_leaf(around, within, speed_coordinate(config), shape, rng)
    watch.stage("fit")
    return {**leaf._asdict(), SECONDS: watch.seconds}
