"""Direct rebounds from rough walls: from facet to facet until a particle leaves.

The facets are those that `tablegen.model.roughness` draws with the same keys. A bounce begins with
the spin and the orientation after the one before, and all bounces of a hit have one grain.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.errors import CASCADE_NOT_ENDED, OK
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import CONDITION_SIZE, lab_conditions, states_to_lab
from tablegen.model.orientation import axes_from, orientations_from
from tablegen.model.particle_run import simulate_batch
from tablegen.model.random_particles import ParticleKeys
from tablegen.model.roughness import MAX_BOUNCES, facet_normals, mark_leaving, seed_of_bounce
from tablegen.simulation.direct_rows import DirectArrays, Particles

_NO_GRAIN_KEYS = np.empty(0, dtype=np.uint32)


class RoughImpacts(NamedTuple):
    """Impacts of m particles on rough walls, a row each."""

    #: Velocity relative to the wall before the next bounce [m/s], and angular velocity [rad/s].
    moving: FloatArray
    omega: FloatArray
    #: Normal of the mean wall.
    normal: FloatArray
    half_size: FloatArray
    wall_velocity: FloatArray
    #: Standard deviation of the tilt of facets [rad].
    roughness: FloatArray
    #: That of their tilt across the plane of incidence [rad].
    across: FloatArray
    index: NDArray[np.uint64]  # type: ignore[assignment]  # hides tuple.index
    hit: NDArray[np.uint32]
    grains: FloatArray
    #: Quaternions (m, 4), or (m, 0): drawn by the keys.
    orientation: FloatArray

    @classmethod
    def of_rows(cls, particles: Particles, part: slice, arrays: DirectArrays) -> "RoughImpacts":
        """Take some rows of a call, with their grains."""

        def taken(name: str) -> NDArray[Any]:
            array = particles.array(name)
            if len(array) > 1:
                return array[part].copy()
            return np.repeat(array, part.stop - part.start, axis=0)

        wall = taken("wall_velocity")
        return cls(
            moving=taken("velocity") - wall,
            omega=taken("omega"),
            normal=taken("normal"),
            half_size=taken("half_size"),
            wall_velocity=wall,
            roughness=taken("roughness"),
            across=taken("across"),
            index=taken("index"),
            hit=taken("hit"),
            grains=particles.grains(arrays, part),
            orientation=taken("orientation")
            if "orientation" in particles.call.rows.arrays
            else np.empty((part.stop - part.start, 0)),
        )


def rough_rebounds(
    arrays: DirectArrays,
    seed: np.uint64,
    impacts: RoughImpacts,
    states: FloatArray,
    orientation: FloatArray,
) -> tuple[int, int]:
    """Rebound particles from rough walls; every impact on the mean wall must be possible.

    Writes velocities [m/s] and angular velocities [rad/s] in the lab frame to `states` (m, 6), and
    quaternions to `orientation` (m, 4). Returns the first row that failed, or -1, and its code: 0
    if it never left a facet.
    """
    rows = np.arange(len(states))
    for bounce in range(MAX_BOUNCES):
        # compiled code takes an int of Python for a signed number
        key = np.uint64(seed_of_bounce(seed, bounce))
        turned = np.empty((len(rows), 4))
        row, code = _bounce(arrays, key, impacts, out := np.empty((len(rows), 6)), turned)
        if row >= 0:
            return int(rows[row]), code
        states[rows], orientation[rows] = out, turned
        leaving = np.empty(len(rows), dtype=np.bool_)
        mark_leaving(out, impacts.normal, leaving)
        states[rows[leaving], :3] += impacts.wall_velocity[leaving]
        stays = np.flatnonzero(~leaving)
        if len(stays) == 0:
            return -1, OK
        rows = rows[stays]
        moved = impacts._replace(moving=out[:, :3], omega=out[:, 3:], orientation=turned)
        impacts = RoughImpacts._make(array[stays] for array in moved)
    return int(rows[0]), CASCADE_NOT_ENDED


def _bounce(
    arrays: DirectArrays,
    seed: np.uint64,
    impacts: RoughImpacts,
    out: FloatArray,
    turned: FloatArray,
) -> tuple[int, int]:
    """Rebound each particle once, from its facet; return the first row that failed and its code.

    Writes states to `out` (m, 6) and quaternions to `turned` (m, 4).
    """
    count, still = len(out), np.zeros((1, 3))
    keys = seed, impacts.index, impacts.hit
    facets = np.empty((count, 3))
    wall = impacts.normal, impacts.roughness, impacts.across
    facet_normals(impacts.moving, *wall, keys, facets)
    numbers = np.ascontiguousarray(impacts.moving), facets, impacts.half_size, still
    conditions, omega = np.empty((count, CONDITION_SIZE)), np.ascontiguousarray(impacts.omega)
    row, code = lab_conditions(numbers, omega, keys, arrays.numerics, conditions, 0)
    if row >= 0:
        return row, code
    unused = np.empty(count, dtype=np.int64), impacts.grains.copy(), np.empty((count, 2))
    oriented, axes = impacts.orientation.shape[1] > 0, np.empty((count, 6))
    if oriented:
        given = np.ascontiguousarray(impacts.orientation)
        row, code = axes_from(given, numbers, keys, axes, 0)
        if row >= 0:
            return row, code
    particles = ParticleKeys(*keys, _NO_GRAIN_KEYS, oriented)
    how = arrays.law, arrays.population, conditions, particles
    stuck = simulate_batch(*how, axes, out, *unused)
    if stuck >= 0:
        return stuck, 0
    orientations_from(axes, numbers, keys, turned, 0)
    states_to_lab(numbers, keys, out, 0)
    return -1, OK
