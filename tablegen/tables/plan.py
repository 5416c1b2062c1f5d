"""Plan of a table: the first grid and the sizes that a configuration asks for, decided once."""

from collections.abc import Mapping
from dataclasses import dataclass

from tablegen.config.config import Config
from tablegen.fitting.resolution import LADDER, Resolution, SpinSizes, resolution, spin_sizes
from tablegen.tables.axes import first_grid, most_nodes
from tablegen.tables.intervals import Grid

#: Mixtures that reach an AUC of 0.5 + x have about this over x components.
_COMPONENTS_BY_AUC = 23.0


@dataclass(frozen=True)
class Plan:
    """What is decided before anything is simulated."""

    config: Config
    #: First grid, and the most angles and speeds to which it is refined.
    grid: Grid
    most: tuple[int, int]
    #: Sizes of a node to choose from: the smallest mixture first, or the one that is named.
    sizes: tuple[Resolution, ...]
    #: Sizes of the spin law by code of the shape; none without such a law.
    spin: Mapping[int, SpinSizes]

    @property
    def first(self) -> tuple[int, int]:
        """Angles and speeds of the first grid."""
        return len(self.grid.alpha_deg), len(self.grid.speed)

    @property
    def leaves(self) -> int:
        """Leaves of the spin law."""
        return sum(size.leaves + size.nonspinning_leaves for size in self.spin.values())


def make_plan(config: Config) -> Plan:
    """Decide on the first grid and the sizes; refuses a range that no grid can cover."""
    grid, spin = first_grid(config), spin_sizes(config) if config.spin else {}
    named = config.table.components
    sizes = tuple(resolution(config, k) for k in ([named] if named else _ladder(config)))
    return Plan(config, grid, most_nodes(config, grid), sizes, spin)


def _ladder(config: Config) -> list[int]:
    """Sizes of the mixture to choose from, up to the first with room for the allowed AUC."""
    wanted = _COMPONENTS_BY_AUC / max(config.accuracy.auc - 0.5, 0.002)
    return list(LADDER[: 1 + sum(components < 0.98 * wanted for components in LADDER[:-1])])
