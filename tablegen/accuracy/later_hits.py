"""Compare what a table says of later hits with direct simulation that keeps the orientation.

Chains: particles are followed through six hits, by draws from the table on one side and by direct
simulation on the other, with the same grains between the same walls; what one wall gets wrong is
carried to the next. Cells: see `tablegen.accuracy.cells`; both sides have the same conditions.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from tablegen.accuracy.cells import Cell, cell_departures, cell_impacts, cells_of
from tablegen.accuracy.joint_law import Draw
from tablegen.accuracy.noise_corrected import Estimate, ks_estimate, ratio_estimate
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    WALLS,
    Departures,
    Impacts,
    depart,
    energy_factor,
    first_impacts,
    next_impacts,
    speeds_measured,
    uniform_numbers,
)

#: First impacts of the chains [degrees], hits, and particles a side.
FIRST_DEG = (10.0, 30.0, 50.0, 75.0)
HITS = 6
CHAIN_SAMPLES = 100_000

#: States a side in a cell, and particles that have left a wall.
CELL_SAMPLES = 20_000
_DEPARTURES = 40_000

#: First speed over the fastest of those at which the law was measured.
_FIRST_SPEED = 0.8

#: Least angle [rad] at which a chain goes on: a particle that leaves along the wall meets it there.
_GRAZING = 2e-4

#: Key of the random numbers of cells, next to the seed.
_CELLS = 2**31 + 3


@dataclass(frozen=True)
class LaterHit:
    """Table against direct simulation in a cell of conditions, or at a hit of a chain."""

    #: Cell or chain in words.
    place: str
    #: By limit: ``cell_ks``, ``cell_energy``, or ``chain_ks``, ``chain_energy``, ``chain_spin``.
    estimates: dict[str, Estimate]
    #: Energy after the hit, and squared spin, over those of direct simulation.
    energy: float
    spin: float

    def to_dict(self) -> dict[str, Any]:
        """Give every number for JSON."""
        found = {name: estimate.to_dict() for name, estimate in self.estimates.items()}
        return {"place": self.place, "energy": self.energy, "spin": self.spin, "estimates": found}


def compare_cell(
    draw: Draw,
    model: DirectModel,
    departures: Departures,
    cell: Cell,
    seed: int,
    number: int,
    samples: int = CELL_SAMPLES,
) -> list[LaterHit]:
    """Compare the outcomes in a cell: KS of all variables, and mean energy."""
    rng = np.random.default_rng([seed, _CELLS, number])
    impacts = cell_impacts(model, departures, cell, samples, rng)
    impacts = impacts._replace(hit=impacts.hit + np.uint32(2**20 + number))
    drawn, direct = draw(impacts), depart(model, impacts, seed, threads=1).states
    factor, speed = energy_factor(impacts.spin)[:, None], impacts.speed[:, None]
    energy, spin = _ratios(drawn * speed, direct * speed)
    estimates = {"cell_ks": ks_estimate(drawn / factor, direct / factor), "cell_energy": energy[0]}
    return [LaterHit(cell.words, estimates, energy[1], spin[1])]


def compare_chain(
    draw: Draw, config: Config, walls: str, alpha_deg: float, seed: int, samples: int
) -> list[LaterHit]:
    """Follow particles through six hits on one kind of `WALLS`; one comparison a hit."""
    model, index = DirectModel(config), np.arange(samples, dtype=np.uint64)
    alpha1 = np.full(samples, np.radians(alpha_deg))
    speed = np.full(samples, _FIRST_SPEED * speeds_measured(config)[1])
    first = first_impacts(alpha1, speed, model.grains(seed, index), index)
    kinds = np.full(samples, WALLS.index(walls))
    drawn, direct, found = first, first, []
    for hit in range(1, HITS + 1):
        simulated = depart(model, direct, seed, threads=1)
        states = draw(drawn)
        by_table = Departures(drawn, states, np.zeros((samples, 4)), np.zeros((samples, 2)))
        place = f"hit {hit}, {walls} wall, {alpha_deg:g} degrees first"
        found.append(after_hit(place, by_table, simulated))
        numbers = uniform_numbers(seed, index, hit)
        drawn, direct = (
            _grazing(next_impacts(of, departures, kinds, numbers))
            for of, departures in ((None, by_table), (model, simulated))
        )
    return found


def _grazing(impacts: Impacts) -> Impacts:
    return impacts._replace(alpha1=np.maximum(impacts.alpha1, _GRAZING))


def after_hit(place: str, drawn: Departures, direct: Departures) -> LaterHit:
    """Compare speed, angle, size of the spin and its components after a hit."""
    sides = [side.states * side.impacts.speed[:, None] for side in (drawn, direct)]
    seen = [_observed(states) for states in sides]
    energy, spin = _ratios(*sides)
    estimates = {
        "chain_ks": ks_estimate(*seen),
        "chain_energy": energy[0],
        "chain_spin": spin[0],
    }
    return LaterHit(place, estimates, energy[1], spin[1])


def _observed(states: FloatArray) -> FloatArray:
    """Speed, sine of the angle, size of the spin and its components, (n, 6)."""
    speed = np.linalg.norm(states[:, :3], axis=1)
    size = np.linalg.norm(states[:, 3:], axis=1)
    return np.column_stack([speed, states[:, 1] / speed, size, states[:, 3:]])


def _ratios(
    drawn: FloatArray, direct: FloatArray
) -> tuple[tuple[Estimate, float], tuple[Estimate, float]]:
    """Errors of translational energy and squared spin of states (n, 6), and their ratios."""
    squares = [
        [np.sum(states[:, part] ** 2, axis=1) for states in (drawn, direct)]
        for part in (slice(0, 3), slice(3, 6))
    ]
    energy, spin = ((ratio_estimate(a, b), float(a.mean() / b.mean())) for a, b in squares)
    return energy, spin


def later_hits(
    draw: Draw, config: Config, seed: int, samples: int | None = None
) -> list[Callable[[], list[LaterHit]]]:
    """List the comparisons in all cells and of all chains of a configuration, to be called.

    ``samples`` are the states a side, by default `CELL_SAMPLES` and `CHAIN_SAMPLES`.
    """
    few = min(samples or CELL_SAMPLES, CELL_SAMPLES)
    many = min(samples or CHAIN_SAMPLES, CHAIN_SAMPLES)
    model, departures = cell_departures(config, seed, _DEPARTURES)
    shared = draw, model, departures
    work: list[Callable[[], list[LaterHit]]] = [
        partial(compare_cell, *shared, cell, seed, number, few)
        for number, cell in enumerate(cells_of(config))
    ]
    first, last = config.domain.alpha_deg
    angles = [alpha for alpha in FIRST_DEG if first <= alpha <= last]
    return work + [
        partial(compare_chain, draw, config, walls, alpha_deg, seed, many)
        for walls, alpha_deg in product(WALLS, angles)
    ]
