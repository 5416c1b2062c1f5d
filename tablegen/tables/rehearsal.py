"""Rehearse a table: write and read a rough one before hours are spent on the finished one.

The rough table has the sizes of the finished table, but its nodes are fitted to few particles. It
is refused for the same reasons as the finished table would be.
"""

from collections.abc import Iterable
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from sampler.errors import InputError
from sampler.formats.hdf5 import write_table
from sampler.table import load
from tablegen.config.config import Config
from tablegen.fitting.node import NodeArrays, fit_node
from tablegen.fitting.resolution import Resolution
from tablegen.simulation.scene_variables import simulated_variables
from tablegen.simulation.simulate import simulate
from tablegen.tables.assembly import assemble
from tablegen.tables.axes import make_axes
from tablegen.tables.plan import Plan

#: Particles and mixture components of a rough node.
_PARTICLES, _COMPONENTS = 400, 2

#: Largest spread of a variable that counts as constant.
_CONSTANT_SPREAD = 1e-5


def rehearse(plan: Plan) -> None:
    """Refuse a plan whose finished table would be refused.

    Raises `InputError` if a variable is constant at all conditions, if nodes are too close to each
    other, or if the table exceeds a limit of the file format.
    """
    config, grid, size = plan.config, plan.grid, plan.sizes[0]
    axes = make_axes(config, grid)
    _check_variables_vary(config, product(*grid))
    ends = [list(dict.fromkeys((nodes[0], nodes[-1]))) for nodes in grid]
    conditions = list(product(*ends))
    rough_nodes = [_rough_node(config, alpha_deg, speed, size) for alpha_deg, speed in conditions]
    count = len(grid.alpha_deg) * len(grid.speed)
    contents = assemble(config, axes, [rough_nodes[k % len(rough_nodes)] for k in range(count)])
    with TemporaryDirectory() as folder:
        path = Path(folder) / "rehearsal.h5"
        write_table(path, contents)
        load(path)


def _check_variables_vary(config: Config, conditions: Iterable[tuple[float, ...]]) -> None:
    """Refuse variables that are the same for all particles at all conditions.

    A law may have friction at a few angles only, so all nodes of the first grid are tried. The
    number of collisions may be constant, because a table stores whole numbers exactly.
    """
    constant = [name for name in config.domain.columns if name != "collisions"]
    for alpha_deg, speed in conditions:
        if not constant:
            return
        simulation = simulate(
            config, np.radians(alpha_deg), speed, _PARTICLES, seed=config.table.seed, threads=1
        )
        spread = np.ptp(simulated_variables(simulation, constant), axis=0)
        constant = [
            name for name, width in zip(constant, spread, strict=True) if width <= _CONSTANT_SPREAD
        ]
    if constant:
        raise InputError(
            "domain.variables",
            ", ".join(constant),
            problem="the same for all particles at every condition",
            remedy="leave them out, because a formula gives them; or change particles or laws",
        )


def _rough_node(config: Config, alpha_deg: float, speed: float, size: Resolution) -> NodeArrays:
    """Fit a node to few particles, and repeat its components up to the final number."""
    rough_size = Resolution(_PARTICLES, size.knots, min(_COMPONENTS, size.components))
    node = fit_node(config, alpha_deg, speed, rough_size)
    repeated = {
        name: np.resize(values, (size.components, *values.shape[1:]))
        for name, values in node._asdict().items()
        if name not in ("quantiles", "first_of_class")
    }
    return node._replace(**repeated)
