"""Choose the sizes of a table: particles, knots and components of a node, leaves of a spin law.

The sizes follow the accuracy that a configuration asks for, unless the configuration names them.
EXPERIMENTS.md has the measurements behind the constants.
"""

import math
from typing import NamedTuple

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import Config

#: Numbers of components that the generator chooses from, about a factor of 1.4 apart.
LADDER = (32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536)

#: A node has _SAMPLES / ks^2 particles for an allowed Kolmogorov-Smirnov distance ks, and at least
#: _LEAST_SAMPLES. The empirical distribution functions of n particles are typically off by
#: 1.4 / sqrt(n) in the worst of six channels, which is then a quarter of the allowed distance.
_SAMPLES = 25.0
_LEAST_SAMPLES = 100_000

#: Numbers of knots, each with the least allowed Kolmogorov-Smirnov distance for which it is enough.
_KNOTS = ((0.015, 65), (0.004, 129), (0.0, 257))

#: Conditions that are drawn for a leaf over the rebounds to which it is fitted, the most conditions
#: of a leaf, and the least of all leaves of a tree. A condition is simulated several times, each
#: time with other phases of its tumbling.
_CONDITIONS, _MOST_CONDITIONS, _LEAST_CONDITIONS = 0.15, 18_000, 1000


class Resolution(NamedTuple):
    """Sizes of a node."""

    #: Particles that are simulated.
    samples: int
    #: Knots of each quantile function.
    knots: int
    #: Mixture components of all classes together.
    components: int


def resolution(config: Config, components: int | None = None) -> Resolution:
    """Find the sizes of a node that a configuration names, or that its accuracy needs.

    Parameters
    ----------
    config : Config
    components : int, optional
        Number of components if the configuration names none; by default the first of `LADDER`.

    Returns
    -------
    Resolution
    """
    table, ks = config.table, config.accuracy.ks
    return Resolution(
        samples=table.samples_per_node or max(int(_SAMPLES / ks**2), _LEAST_SAMPLES),
        knots=table.quantile_knots or next(knots for least, knots in _KNOTS if ks >= least),
        components=table.components or components or LADDER[0],
    )


class SpinSizes(NamedTuple):
    """Sizes of a spin law."""

    #: Leaves of conditions with spin.
    leaves: int
    #: Leaves of conditions without spin.
    nonspinning_leaves: int
    #: Groups of a leaf; a file has room for 8.
    groups: int
    #: Experts of a group, in leaves with spin and without; a file has room for 8.
    experts: int
    nonspinning_experts: int
    #: Rebounds for the fit of a leaf. Its quantiles are those of the rebounds that lie in it.
    rebounds: int
    #: Knots of each quantile function.
    knots: int

    def conditions(self, leaves: int) -> int:
        """Compute the number of conditions that are drawn for a tree with this many leaves."""
        leaf_conditions = min(_CONDITIONS * self.rebounds, _MOST_CONDITIONS)
        return max(int(leaf_conditions * leaves), _LEAST_CONDITIONS)

    def with_share(self, share: float) -> "SpinSizes":
        """Return the same sizes with a share of the leaves, but at least one leaf of each kind."""
        return self._replace(
            leaves=max(math.ceil(share * self.leaves), 1),
            nonspinning_leaves=max(math.ceil(share * self.nonspinning_leaves), 1),
        )


#: Sizes for each preset of the accuracy, with the leaves of all shapes together.
SPIN_SIZES = {
    "compact": SpinSizes(71, 42, 8, 4, 8, 120_000, 65),
    "standard": SpinSizes(265, 110, 8, 4, 8, 120_000, 97),
    "fine": SpinSizes(600, 240, 8, 8, 8, 250_000, 129),
}

#: Leaves of a shape over those of other shapes. Ellipsoids settle into rolling, where the law
#: changes quickly, and rebounds of spheres are not random.
_LEAF_WEIGHTS = {SHAPE_CODES["ellipsoid"]: 2.5, SHAPE_CODES["sphere"]: 0.25}

#: Rebounds of a leaf over those of other shapes, unless a configuration names their number.
_REBOUND_WEIGHTS = {SHAPE_CODES["ellipsoid"]: 2}


def spin_sizes(config: Config) -> dict[int, SpinSizes]:
    """Find the sizes of the spin law of each shape, by its code.

    They are those that a configuration names, or those of its preset of the accuracy. All shapes
    share the leaves of a preset, so the tables of all populations are about equally large, and
    finer if there are few shapes. Leaves of ellipsoids have twice the rebounds of the preset. If a
    configuration names the number of leaves, each shape gets this number, and spheres a quarter of
    it.
    """
    table, preset = config.table, SPIN_SIZES[config.accuracy.preset]
    preset = preset._replace(
        groups=table.spin_groups or preset.groups,
        experts=table.spin_experts or preset.experts,
        nonspinning_experts=table.spin_experts or preset.nonspinning_experts,
    )
    codes = config.population.shape_codes
    weights = {code: _LEAF_WEIGHTS.get(code, 1.0) for code in codes}
    total = sum(weights.values())
    sizes = {
        code: preset.with_share(weight / total)._replace(
            rebounds=table.spin_rebounds or _REBOUND_WEIGHTS.get(code, 1) * preset.rebounds
        )
        for code, weight in weights.items()
    }
    if table.spin_leaves is None:
        return sizes
    return {
        code: shape_sizes._replace(
            leaves=max(math.ceil(min(weights[code], 1.0) * table.spin_leaves), 1),
            nonspinning_leaves=min(shape_sizes.nonspinning_leaves, table.spin_leaves),
        )
        for code, shape_sizes in sizes.items()
    }
