"""Direct rebounds from rough walls: from one facet after another, until a particle leaves.

Facets are those that `tablegen.model.roughness` draws with the same keys. A bounce has the spin
that the one before has left, and all bounces of a hit have one grain.
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import Rows
from sampler.errors import CASCADE_NOT_ENDED, OK
from tablegen.model.facets import facet_normals, mark_leaving, seed_of_bounce
from tablegen.model.float_array import FloatArray
from tablegen.model.impact_condition import CONDITION_SIZE
from tablegen.model.impacts import lab_conditions, states_to_lab
from tablegen.model.one_rebound import DirectArrays
from tablegen.model.particle_run import simulate_batch
from tablegen.model.random_particles import ParticleKeys
from tablegen.model.roughness import MAX_BOUNCES, facet_normals, mark_leaving, seed_of_bounce
from tablegen.tasks.side_by_side import go_on

_NO_GRAIN_KEYS = np.empty(0, dtype=np.uint32)


@dataclass(frozen=True)
class RoughImpacts:
    """Impacts of m particles on rough walls; every array has a row for each."""

    #: Velocity relative to the wall before the next bounce [m/s], and angular velocity [rad/s].
    moving: FloatArray
    omega: FloatArray
    #: Of the mean wall.
    normal: FloatArray
    half_size: FloatArray
    wall_velocity: FloatArray
    #: Standard deviation of the tilt of facets [rad].
    roughness: FloatArray
    seed: np.uint64
    index: NDArray[np.uint64]
    hit: NDArray[np.uint32]
    grains: FloatArray

    @classmethod
    def of_rows(cls, rows: Rows, part: slice, grains: FloatArray) -> "RoughImpacts":
        """Take some rows of a call; `grains` has theirs."""
        count = part.stop - part.start

        def taken(array: NDArray[Any]) -> NDArray[Any]:
            if len(array) > 1:
                return array[part].copy()
            return np.repeat(array, count, axis=0)

        values: dict[str, Any] = {name: taken(array) for name, array in rows.values.items()}
        seed, index, hit = rows.keys
        moving = values.pop("velocity") - values["wall_velocity"]
        values |= {"seed": seed, "index": taken(index), "hit": taken(hit)}
        return cls(moving=moving, grains=grains, **values)

    def of(self, which: NDArray[np.int64]) -> "RoughImpacts":
        """Take those of some particles."""
        arrays = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "seed"}
        return replace(self, **{name: array[which] for name, array in arrays.items()})


def rough_rebounds(
    arrays: DirectArrays, impacts: RoughImpacts, states: FloatArray
) -> tuple[int, int]:
    """Rebound particles from rough walls.

    Parameters
    ----------
    arrays : DirectArrays
    impacts : RoughImpacts
        Each a possible impact on its mean wall.
    states : (m, 6) float64
        Output: velocity [m/s] and angular velocity [rad/s], lab frame.

    Returns
    -------
    tuple of two int
        First row that failed, or -1, and its code: 0 if it never left a facet.
    """
    rows = np.arange(len(states))
    for bounce in range(MAX_BOUNCES):
        go_on()
        row, code = _bounce(arrays, impacts, bounce, out := np.empty((len(rows), 6)))
        if row >= 0:
            return int(rows[row]), code
        states[rows] = out
        leaving = np.empty(len(rows), dtype=np.bool_)
        mark_leaving(out, impacts.normal, leaving)
        states[rows[leaving], :3] += impacts.wall_velocity[leaving]
        stays = np.flatnonzero(~leaving)
        if len(stays) == 0:
            return -1, OK
        rows = rows[stays]
        impacts = replace(impacts, moving=out[:, :3], omega=out[:, 3:]).of(stays)
    return int(rows[0]), CASCADE_NOT_ENDED


def _bounce(
    arrays: DirectArrays, impacts: RoughImpacts, bounce: int, out: FloatArray
) -> tuple[int, int]:
    """One bounce of each particle, from the facet that it meets; first row that failed, code."""
    count, still = len(out), np.zeros((1, 3))
    # compiled code would take a number of Python for a signed one
    keys = np.uint64(seed_of_bounce(impacts.seed, bounce)), impacts.index, impacts.hit
    facets = np.empty((count, 3))
    row, code = facet_normals(impacts.moving, impacts.normal, impacts.roughness, keys, facets)
    if row >= 0:
        return row, code
    numbers = np.ascontiguousarray(impacts.moving), facets, impacts.half_size, still
    conditions, omega = np.empty((count, CONDITION_SIZE)), np.ascontiguousarray(impacts.omega)
    row, code = lab_conditions(numbers, omega, keys, arrays.numerics, conditions, 0)
    if row >= 0:
        return row, code
    unused = np.empty(count, dtype=np.int64), impacts.grains.copy(), np.empty((count, 2))
    particles = ParticleKeys(*keys, _NO_GRAIN_KEYS)
    stuck = simulate_batch(arrays.law, arrays.population, conditions, particles, out, *unused)
    if stuck >= 0:
        return stuck, 0
    states_to_lab(numbers, keys, out, 0)
    return -1, OK
