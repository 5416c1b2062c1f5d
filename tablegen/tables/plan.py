"""Plan a table: choose its first grid and its sizes from the configuration, once."""

from collections.abc import Mapping
from dataclasses import dataclass

from tablegen.config.config import Config
from tablegen.fitting.resolution import LADDER, Resolution, SpinSizes, resolution, spin_sizes
from tablegen.tables.axes import first_grid, most_nodes
from tablegen.tables.intervals import Grid

#: A mixture needs about this number over x components to reach an AUC of 0.5 + x.
_COMPONENTS_BY_AUC = 23.0


@dataclass(frozen=True)
class Plan:
    """First grid and sizes of a table, chosen before anything is simulated."""

    config: Config
    #: First grid.
    grid: Grid
    #: Most angles and speeds to which the grid is refined.
    most: tuple[int, int]
    #: Sizes of a node to choose from, the smallest mixture first. If the configuration names the
    #: number of components, there is one.
    sizes: tuple[Resolution, ...]
    #: Sizes of the spin law by code of the shape; empty for a table without spin law.
    spin: Mapping[int, SpinSizes]

    @property
    def first(self) -> tuple[int, int]:
        """Number of angles and of speeds of the first grid."""
        return len(self.grid.alpha_deg), len(self.grid.speed)

    @property
    def leaves(self) -> int:
        """Number of leaves of the spin law."""
        return sum(size.leaves + size.nonspinning_leaves for size in self.spin.values())


def make_plan(config: Config) -> Plan:
    """Choose the first grid and the sizes.

    Raises `InputError` if no grid can cover the range of the configuration.
    """
    grid = first_grid(config)
    most = most_nodes(config.table, grid)
    named = config.table.components
    components = [named] if named else _ladder(config.accuracy.auc)
    sizes = tuple(resolution(config, k) for k in components)
    return Plan(config, grid, most, sizes, spin_sizes(config) if config.spin else {})


def _ladder(auc: float) -> list[int]:
    """List numbers of components to choose from, up to the first that may reach the allowed AUC."""
    needed = _COMPONENTS_BY_AUC / max(auc - 0.5, 0.002)
    return list(LADDER[: 1 + sum(components < 0.98 * needed for components in LADDER[:-1])])
