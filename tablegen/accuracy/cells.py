"""Cells of conditions in which a spin law is compared with direct simulation.

A spin goes with orientations that only a history makes: particles that have rebounded before. So a
law is not judged at a point, but in cells of conditions among particles that have left a wall; size
of the spin and speed are scaled into the cell, as a gas does, and the next wall has any direction.
"""

import math
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    FASTEST,
    Departures,
    Impacts,
    depart,
    energy_factor,
    joined_impacts,
    meet,
    occurring_impacts,
    possible,
    with_spins,
)

#: Ends of the cells: impact angles [degrees] and sizes of the spin [V/a]. Effective speeds are
#: split at the geometric mean of their range.
ANGLES_DEG = (0.5, 5.0, 30.0, 90.0)
SIZES = (0.05, 1.0, 3.0, 10.0)

#: Direction of the spin about the axis across the plane of impact, z: a particle that rolls along
#: the wall has a negative component. The others are mostly along or normal to the wall.
DIRECTIONS = ("rolling", "across", "against")

#: Share of the size of a spin beyond which it counts as rolling, or against that.
_TURN = 0.5


class Cell(NamedTuple):
    """Box of conditions: impact angles [degrees], effective speeds [m/s], spins."""

    alpha_deg: tuple[float, float]
    speed: tuple[float, float]
    size: tuple[float, float]
    direction: str

    @property
    def words(self) -> str:
        """The cell in words."""
        (a, b), (v, w), (s, t) = self[:3]
        return (
            f"{a:g} to {b:g} degrees, {v:.3g} to {w:.3g} m/s, spin {s:g} to {t:g}, {self.direction}"
        )


def cells_of(config: Config) -> list[Cell]:
    """List the cells within the domain of a configuration."""
    (first, last), (slow, fast) = config.domain.alpha_deg, config.speeds
    ends = np.clip(ANGLES_DEG, first, last)
    angles = [(a, b) for a, b in pairwise(ends.tolist()) if a < b]
    middle = float(np.sqrt(slow * FASTEST * fast))
    speeds = ((slow, middle), (middle, FASTEST * fast))
    sizes = tuple(pairwise(SIZES))
    return [Cell(*one) for one in product(angles, speeds, sizes, DIRECTIONS)]


def cell_departures(
    config: Config, seed: int, count: int, threads: int | None = None
) -> tuple[DirectModel, Departures]:
    """Simulate particles that have just left a wall, about ``count``, from chains of impacts."""
    model, index = DirectModel(config), np.arange(count, dtype=np.uint64)
    impacts = occurring_impacts(config, model, seed, index, threads)
    return model, depart(model, impacts, seed, threads)


def cell_impacts(
    model: DirectModel, departures: Departures, cell: Cell, count: int, rng: np.random.Generator
) -> Impacts:
    """Draw ``count`` impacts in a cell, of particles that have just left a wall."""
    parts: list[Impacts] = []
    while sum(len(part.index) for part in parts) < count:
        size = _between(cell.size, count, rng)
        taken = with_spins(departures, size, rng)
        alpha = np.radians(rng.uniform(*cell.alpha_deg, count))
        impacts = meet(model, taken, np.minimum(alpha, 0.5 * np.pi), rng.random((count, 2)))
        speed = _between(cell.speed, count, rng) / energy_factor(impacts.spin)
        impacts = impacts._replace(speed=speed)
        parts.append(impacts.of(_has(cell.direction, impacts.spin)))
    found = joined_impacts(parts).of(slice(0, count))
    # keys of their own: a departure may be taken more than once
    index = np.arange(len(found.index), dtype=np.uint64)
    return possible(found._replace(index=index))


def _between(ends: tuple[float, float], count: int, rng: np.random.Generator) -> FloatArray:
    """Draw numbers that are uniform in the logarithm."""
    return np.exp(rng.uniform(math.log(ends[0]), math.log(ends[1]), count))


def _has(direction: str, spin: FloatArray) -> NDArray[np.bool_]:
    """Tell which spins (n, 3) have a direction."""
    turn = spin[:, 2] / np.maximum(np.linalg.norm(spin, axis=1), 1e-300)
    return np.asarray(np.digitize(turn, (-_TURN, _TURN)) == DIRECTIONS.index(direction))
