"""Spin laws in cells of conditions: angle, speed, size and direction of the spin, and inertia.

A condition needs no history, because the four numbers of rotation say all that a free grain keeps.
"""

from itertools import pairwise, product

import numpy as np
import pytest

import sampler
from tablegen.accuracy.metrics import ks, ratio
from tablegen.config.config import stored_config
from tablegen.simulation.direct import DirectModel

#: Ends of the cells, degrees, m/s (of V_e) and V/a, and particles in each.
ANGLES_DEG, SPEEDS, SIZES = (0.05, 1.0, 5.0, 30.0, 90.0), (5.0, 40.0, 300.0), (1e-3, 0.1, 1.0, 10.0)
COUNT = 20_000


def axis_of(direction, rng):
    """Axes of spins: along z (-1 rolling, 1 against it) within 60 degrees, or more across (0)."""
    cosine = {-1: (-1.0, -0.5), 0: (-0.5, 0.5), 1: (0.5, 1.0)}[direction]
    z, turn = rng.uniform(*cosine, COUNT), rng.uniform(0.0, 2.0 * np.pi, COUNT)
    across = np.sqrt(1.0 - z * z)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), z])


@pytest.mark.study  # minutes
@pytest.mark.parametrize(
    ("name", "most_ks", "most_energy"),
    [("corundum-steel", 0.035, 0.03), ("corundum-steel-compact", 0.06, 0.05)],
)
def test_shipped_tables_hold_in_all_cells(name, most_ks, most_energy):
    """Bounds are the errors of the tables as they are, less three errors."""
    table, seed = sampler.load(name), 3
    model = DirectModel(stored_config(table.config, name))
    keys = {"seed": seed, "index": np.arange(COUNT)}
    # inertias that grains have: those after a first impact
    inertia = np.empty(COUNT)
    model.sample(0.5, 100.0, spin=np.zeros(3), **keys, hit=0, inertia_after=inertia)
    cells = product(pairwise(ANGLES_DEG), pairwise(SPEEDS), pairwise(SIZES), (-1, 0, 1))
    for number, cell in enumerate(cells, 1):
        angles, speeds, sizes, direction = cell
        rng = np.random.default_rng([seed, number])
        size = np.exp(rng.uniform(*np.log(sizes), COUNT))
        factor = np.sqrt(1.0 + inertia * size**2)
        condition = {
            "alpha1": np.radians(np.exp(rng.uniform(*np.log(angles), COUNT))),
            "speed": np.exp(rng.uniform(*np.log(speeds), COUNT)) / factor,
            "spin": size[:, None] * axis_of(direction, rng),
            "inertia": inertia,
        }
        after = [np.empty(COUNT), np.empty(COUNT)]
        sides = [
            np.column_stack([law.sample(**condition, **keys, hit=number, inertia_after=k), k])
            for law, k in zip((table, model), after, strict=True)
        ]
        assert ks(*(side / factor[:, None] for side in sides)).certain <= most_ks, cell
        energies = (np.sum((side[:, :3]) ** 2, axis=1) for side in sides)
        assert ratio(*energies).certain <= most_energy, cell
