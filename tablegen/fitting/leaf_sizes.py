"""How finely a spin law is resolved."""

from typing import NamedTuple

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import Config

#: Conditions with spin that are drawn for each rebound that a leaf is fitted to.
_CONDITIONS = 0.2


class SpinSizes(NamedTuple):
    """Sizes of a spin law.

    Attributes
    ----------
    leaves, still_leaves : int
        Of the tree of a shape: of conditions with spin, and of those without.
    groups, experts : int
        Groups of a leaf, and experts of a group; the file has room for 8 of 16.
    rebounds : int
        Simulated for the fit of a leaf, and once more for its quantiles.
    knots : int
        Of each quantile function.
    """

    leaves: int
    still_leaves: int
    groups: int
    experts: int
    rebounds: int
    knots: int

    @property
    def conditions(self) -> int:
        """Conditions with spin, of one shape, from which those of the leaves are taken."""
        return max(int(_CONDITIONS * self.rebounds * self.leaves), 1000)

    def of_shape(self, shape_code: int) -> "SpinSizes":
        """Sizes of one shape: a sphere's law is simple, because nothing in it is random."""
        if shape_code != SHAPE_CODES["sphere"]:
            return self
        return self._replace(leaves=max(self.leaves // 4, 1), still_leaves=1)


#: By preset of the accuracy.
SPIN_SIZES = {
    "compact": SpinSizes(16, 4, 8, 8, 120_000, 65),
    "standard": SpinSizes(38, 6, 8, 16, 240_000, 97),
    "fine": SpinSizes(96, 12, 8, 16, 480_000, 129),
}


def spin_sizes(config: Config) -> SpinSizes:
    """Sizes that a configuration names, or those of its preset of accuracy."""
    table, preset = config.table, SPIN_SIZES[config.accuracy.preset]
    return preset._replace(
        leaves=table.spin_leaves or preset.leaves,
        still_leaves=min(preset.still_leaves, table.spin_leaves or preset.still_leaves),
        groups=table.spin_groups or preset.groups,
        experts=table.spin_experts or preset.experts,
        rebounds=table.spin_rebounds or preset.rebounds,
    )
