"""Spin laws in cells of conditions, beside direct simulation of particles that have left a wall.

A spin goes with orientations that only a history makes. So size of the spin and speed of particles
that have just left a wall are scaled into a cell, as a gas does, and the next wall has any angle.
"""

from itertools import pairwise, product

import numpy as np
import pytest

import sampler
from tablegen.accuracy.chains import drawn_from
from tablegen.accuracy.metrics import ks, ratio
from tablegen.config.config import stored_config
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    FASTEST,
    depart,
    energy_factor,
    joined_impacts,
    meet,
    occurring_impacts,
    possible,
    with_spins,
)

#: Ends of the cells, degrees and V/a, and particles in each.
ANGLES_DEG, SIZES, COUNT = (0.5, 5.0, 30.0, 90.0), (0.05, 1.0, 3.0, 10.0), 20_000


def impacts_of(model, departures, cell, rng):
    """Impacts in a cell; rolling (-1), across (0) or against (1) by the share of spin along z."""
    alpha_deg, speed, size, direction = cell
    parts, found = [], 0
    while found < COUNT:
        sizes, speeds = (np.exp(rng.uniform(*np.log(ends), COUNT)) for ends in (size, speed))
        taken = with_spins(departures, sizes, rng)
        alpha = np.radians(rng.uniform(*alpha_deg, COUNT))
        impacts = meet(model, taken, np.minimum(alpha, 0.5 * np.pi), rng.random((COUNT, 2)))
        impacts = impacts._replace(speed=speeds / energy_factor(impacts.spin))
        turn = impacts.spin[:, 2] / np.linalg.norm(impacts.spin, axis=1)
        parts.append(impacts.of(np.digitize(turn, (-0.5, 0.5)) == direction + 1))
        found += len(parts[-1].index)
    # keys of their own: a departure may be taken more than once
    index = np.arange(COUNT, dtype=np.uint64)
    return possible(joined_impacts(parts).of(slice(0, COUNT))._replace(index=index))


@pytest.mark.study  # a minute each
@pytest.mark.parametrize(
    ("name", "most_ks", "most_energy"),
    [("corundum-steel", 0.035, 0.03), ("corundum-steel-compact", 0.06, 0.05)],
)
def test_shipped_tables_hold_in_all_cells(name, most_ks, most_energy):
    """Bounds are the errors of the tables as they are, less three errors."""
    table, seed = sampler.load(name), 3
    config = stored_config(table.config, name)
    model, draw, (slow, fast) = DirectModel(config), drawn_from(table, seed), config.speeds
    index = np.arange(2 * COUNT, dtype=np.uint64)
    departures = depart(model, occurring_impacts(config, model, seed, index), seed)
    speeds = pairwise((slow, np.sqrt(slow * FASTEST * fast), FASTEST * fast))
    cells = product(pairwise(ANGLES_DEG), speeds, pairwise(SIZES), (-1, 0, 1))
    for number, cell in enumerate(cells):
        impacts = impacts_of(model, departures, cell, np.random.default_rng([seed, number]))
        impacts = impacts._replace(hit=impacts.hit + np.uint32(2**20 + number))
        sides = draw(impacts), depart(model, impacts, seed).states
        factor = energy_factor(impacts.spin)[:, None]
        assert ks(*(side / factor for side in sides)).certain <= most_ks, cell
        energies = (np.sum((side[:, :3] * impacts.speed[:, None]) ** 2, axis=1) for side in sides)
        assert ratio(*energies).certain <= most_energy, cell


@pytest.mark.study
@pytest.mark.parametrize("name", ["corundum-steel", "corundum-steel-compact"])
def test_spins_along_the_normal_which_hardly_occur(name):
    """Less exact than others; prints the distances."""
    table, rng = sampler.load(name), np.random.default_rng(1)
    config = stored_config(table.config, name)
    model, index = DirectModel(config), np.arange(3 * COUNT, dtype=np.uint64)
    departures = depart(model, occurring_impacts(config, model, 9, index), 9)
    for size, degrees in product((1.5, 3.5), (10.0, 30.0, 60.0)):
        taken = with_spins(departures, np.full(20 * COUNT, size), rng)
        alpha = np.full(20 * COUNT, np.radians(degrees))
        impacts = meet(model, taken, alpha, rng.random((20 * COUNT, 2)))
        along = np.abs(impacts.spin[:, 1]) > 0.95 * np.linalg.norm(impacts.spin, axis=1)
        impacts = possible(impacts.of(along)._replace(speed=np.full(along.sum(), 100.0)))
        impacts = impacts._replace(index=np.arange(along.sum(), dtype=np.uint64))
        found = ks(drawn_from(table, 11)(impacts), depart(model, impacts, 10).states)
        print(f"{name}: spin {size:g}, {degrees:g} degrees: KS {found.value:.3f}")
        assert found.certain <= 0.15
