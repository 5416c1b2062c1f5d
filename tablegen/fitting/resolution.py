"""How finely a table is resolved: the sizes of its nodes and of its spin law."""

import math
from typing import NamedTuple

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import Config

#: Sizes of a mixture that the generator chooses from, about a factor of 1.4 apart.
LADDER = (32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536)

#: The empirical distribution functions of n points are typically off by 1.4 / sqrt(n) in the worst
#: of six channels: a fifth of the allowed distance at n = _SAMPLES / distance^2.
_SAMPLES = 25.0
_LEAST_SAMPLES = 100_000

#: Least allowed Kolmogorov-Smirnov distance for which a number of knots is enough.
_KNOTS = ((0.015, 65), (0.004, 129), (0.0, 257))

#: Conditions that are drawn for each rebound that a leaf is fitted to, most of a leaf, and least of
#: all leaves. Each is simulated several times, with other phases of its tumbling.
_CONDITIONS, _MOST_CONDITIONS, _LEAST_CONDITIONS = 0.15, 18_000, 1000


class Resolution(NamedTuple):
    """Sizes of one node: particles, knots of a quantile function, components of all classes."""

    samples: int
    knots: int
    components: int


def resolution(config: Config, components: int | None = None) -> Resolution:
    """Find the resolution that a configuration names, or that its accuracy needs.

    ``components``, by default the first of `LADDER`, are for a configuration that names none.
    """
    table, ks = config.table, config.accuracy.ks
    return Resolution(
        samples=table.samples_per_node or max(int(_SAMPLES / ks**2), _LEAST_SAMPLES),
        knots=table.quantile_knots or next(knots for least, knots in _KNOTS if ks >= least),
        components=table.components or components or LADDER[0],
    )


class SpinSizes(NamedTuple):
    """Sizes of a spin law."""

    leaves: int  # for conditions with spin
    nonspinning_leaves: int  # for conditions without
    groups: int  # of a leaf; a file has room for 8
    experts: int  # of a group; a file has room for 16
    rebounds: int  # for the fit of a leaf, and as many again for its quantiles
    knots: int  # of each quantile function

    def conditions(self, leaves: int) -> int:
        """Compute how many conditions are drawn for some leaves of a shape."""
        of_leaf = min(_CONDITIONS * self.rebounds, _MOST_CONDITIONS)
        return max(int(of_leaf * leaves), _LEAST_CONDITIONS)

    def of_share(self, share: float) -> "SpinSizes":
        """Sizes with a share of the leaves."""
        leaves, others = (math.ceil(share * n) for n in (self.leaves, self.nonspinning_leaves))
        return self._replace(leaves=max(leaves, 1), nonspinning_leaves=max(others, 1))


#: Sizes by preset of the accuracy, with the leaves of all shapes together.
SPIN_SIZES = {
    "compact": SpinSizes(70, 50, 8, 8, 120_000, 65),
    "standard": SpinSizes(155, 90, 8, 16, 200_000, 97),
    "fine": SpinSizes(384, 240, 8, 16, 300_000, 129),
}

#: How many leaves a shape gets over others: ellipsoids settle into rolling, where the law is steep,
#: and rebounds of spheres are not random.
_MORE_LEAVES = {SHAPE_CODES["ellipsoid"]: 2.0, SHAPE_CODES["sphere"]: 0.25}


def spin_sizes(config: Config) -> dict[int, SpinSizes]:
    """Find the sizes of each shape: those that a configuration names, or of its preset of accuracy.

    All shapes share the leaves of a preset, so that tables of few shapes are as large and finer. A
    configuration names the leaves of one shape.
    """
    table, preset = config.table, SPIN_SIZES[config.accuracy.preset]
    preset = preset._replace(
        groups=table.spin_groups or preset.groups,
        experts=table.spin_experts or preset.experts,
        rebounds=table.spin_rebounds or preset.rebounds,
    )
    codes = [int(code) for code in config.population.kernel_arguments().shape_codes]
    weights = {code: _MORE_LEAVES.get(code, 1.0) for code in codes}
    total = sum(weights.values())
    sizes = {code: preset.of_share(weight / total) for code, weight in weights.items()}
    if table.spin_leaves is None:
        return sizes
    return {
        code: own._replace(
            leaves=max(math.ceil(min(weights[code], 1.0) * table.spin_leaves), 1),
            nonspinning_leaves=min(own.nonspinning_leaves, table.spin_leaves),
        )
        for code, own in sizes.items()
    }
