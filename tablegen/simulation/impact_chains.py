"""Chains of impacts: particles that meet one wall after another, with grain, spin and inertia.

Between two walls a particle tumbles freely, so its mean angular velocity and the inertia about it
are constant. A gas may turn its velocity, and nothing else acts on it. The law of the next wall
draws the orientation in which the particle arrives there.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.errors import OK
from sampler.library import Rows
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import MOST_TURNED, SPEED
from tablegen.simulation.direct_law import DirectLaw, simulate_impacts

#: The next wall of a particle: the wall that it left, as on the inside of a cylinder, the opposite
#: wall of a channel, or a wall of any direction.
SAME_WALL, OPPOSITE_WALL, ANY_WALL = range(3)

#: Angles [rad] at which walls of any direction are met.
ANY_ANGLES = (np.radians(5.0), np.radians(85.0))

#: Least angle [rad] over the spin [V/a] at which the direct model simulates a particle, with a
#: margin. At smaller angles it would turn too often before it meets the wall.
_LEAST_ANGLE_PER_SPIN = 2.0 * 1.01 / MOST_TURNED

#: Least speed V [m/s], with a margin for rounding to single precision.
_LEAST_SPEED = 1.001 * SPEED.low


class Impacts(NamedTuple):
    """Impacts of n particles, one each, in wall axes; the unit of length is a."""

    #: (n,): angles [rad] from the wall, speeds V [m/s].
    alpha1: FloatArray
    speed: FloatArray
    #: (n, 3): mean angular velocity before the impact times a/V.
    spin: FloatArray
    #: (n,): inertia about the spin over m a^2; 0 without spin, or where it is not known.
    inertia: FloatArray
    #: (n, 3): shape code, b/a and c/b.
    grain: FloatArray
    #: (n,): keys of the particles; `hit` counts the walls met before.
    index: NDArray[np.uint64]  # type: ignore[assignment]  # hides tuple.index
    hit: NDArray[np.uint32]

    def select(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "Impacts":
        """Select some of the particles."""
        return Impacts._make(array[rows] for array in self)


class Departures(NamedTuple):
    """Particles after an impact, in the axes of the wall that they left."""

    impacts: Impacts
    #: (n, 6): states; velocities over V, angular velocities times a/V.
    states: FloatArray
    #: (n,): inertia about the spin over m a^2; 0 without spin.
    inertia: FloatArray
    #: (n, 2): energies that the normal and the tangential impulses took, over m V^2 / 2.
    works: FloatArray


def energy_factor(spin: FloatArray, inertia: FloatArray) -> FloatArray:
    """Compute V_e over V from spins (n, 3) in V/a and the inertias about them, shape (n,).

    V_e is the speed whose translational energy is the whole energy.
    """
    return np.sqrt(1.0 + inertia * np.square(spin).sum(axis=1))


def simulate_departures(
    law: DirectLaw, impacts: Impacts, seed: int, threads: int | None = None
) -> Departures:
    """Simulate impacts of given grains directly."""
    names = ("alpha1", "speed", "spin", "inertia", "grain", "index", "hit")
    arrays = {name: np.ascontiguousarray(getattr(impacts, name)) for name in names}
    run = simulate_impacts(law, Rows(len(impacts.index), seed, arrays, fresh=False), threads)
    if (run.codes < OK).any():
        raise RuntimeError(f"the particle in row {(run.codes < OK).argmax()} does not leave a wall")
    return Departures(impacts, run.variables[:, :6], run.inertia, run.variables[:, 8:])


def next_impacts(departures: Departures, walls: NDArray[np.int64], uniform: FloatArray) -> Impacts:
    """Let particles fly to their next walls; return the impacts in the axes of those walls.

    ``walls`` (n,) are `SAME_WALL`, `OPPOSITE_WALL` or `ANY_WALL`. A particle meets the first two at
    the angle of its departure. Angle and plane of an impact on a wall of any direction follow from
    ``uniform`` (n, 2), random numbers from 0 to 1.
    """
    velocity = departures.states[:, :3]
    direction = velocity / np.linalg.norm(velocity, axis=1)[:, None]
    elsewhere = normals_of_any_walls(direction, *uniform.T)
    up = np.where(walls == SAME_WALL, 1.0, -1.0)
    normal = np.where((walls == ANY_WALL)[:, None], elsewhere, np.outer(up, [0.0, 1.0, 0.0]))
    direction[:, 1] *= -up
    return _arrive(departures, direction, normal)


def _arrive(departures: Departures, direction: FloatArray, normal: FloatArray) -> Impacts:
    """Turn to the axes of walls with some normals (n, 3)."""
    before, states, inertia, _ = departures
    speed = np.linalg.norm(states[:, :3], axis=1)
    spin = states[:, 3:] / speed[:, None]
    frame = _frame(direction, normal)
    sine = -np.einsum("ni,ni->n", direction, normal)
    return before._replace(
        alpha1=np.arctan2(sine, np.sqrt(np.maximum(1.0 - sine * sine, 0.0))),
        speed=before.speed * speed,
        spin=np.einsum("nij,nj->ni", frame, spin),
        inertia=inertia,
        hit=before.hit + np.uint32(1),
    )


def normals_of_any_walls(direction: FloatArray, angle: FloatArray, plane: FloatArray) -> FloatArray:
    """Find normals (n, 3) of walls of any direction that particles meet.

    Angle and plane of each impact follow from two random numbers (n,) from 0 to 1.
    """
    low, high = ANY_ANGLES
    alpha1, first = low + (high - low) * angle, _perpendicular(direction)
    azimuth = 2.0 * np.pi * plane[:, None]
    side = np.cos(azimuth) * first + np.sin(azimuth) * np.cross(direction, first)
    return np.cos(alpha1)[:, None] * side - np.sin(alpha1)[:, None] * direction


def _perpendicular(vectors: FloatArray) -> FloatArray:
    """Find unit vectors perpendicular to unit vectors, (n, 3)."""
    axis = np.where(np.abs(vectors[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    across = np.cross(vectors, axis)
    return across / np.linalg.norm(across, axis=1)[:, None]


def _frame(direction: FloatArray, normal: FloatArray) -> FloatArray:
    """Compute the wall axes x, y and z of the impacts, the rows of matrices (n, 3, 3)."""
    along = direction - np.einsum("ni,ni->n", direction, normal)[:, None] * normal
    size = np.linalg.norm(along, axis=1)
    # at normal impact, any direction along the wall
    along = np.where((size > 1e-9)[:, None], along, _perpendicular(normal))
    along /= np.linalg.norm(along, axis=1)[:, None]
    along -= np.einsum("ni,ni->n", along, normal)[:, None] * normal
    along /= np.linalg.norm(along, axis=1)[:, None]
    return np.stack([along, normal, np.cross(along, normal)], axis=1)


def raise_to_limits(impacts: Impacts) -> Impacts:
    """Raise angles and speeds to the least that the direct model simulates."""
    steepest = _LEAST_ANGLE_PER_SPIN * np.sqrt(np.sum(impacts.spin**2, axis=1))
    alpha = np.minimum(np.maximum(impacts.alpha1, steepest), 0.5 * np.pi)
    return impacts._replace(alpha1=alpha, speed=np.maximum(impacts.speed, _LEAST_SPEED))


def join_impacts(parts: list[Impacts]) -> Impacts:
    """Put impacts one after another."""
    return Impacts._make(map(np.concatenate, zip(*parts, strict=True)))


def first_impacts(
    alpha1: FloatArray, speed: FloatArray, grain: FloatArray, index: NDArray[np.uint64]
) -> Impacts:
    """Make first impacts, of particles that do not spin."""
    n = len(index)
    hit = np.zeros(n, dtype=np.uint32)
    return Impacts(alpha1, speed, np.zeros((n, 3)), np.zeros(n), grain, index, hit)
