"""Chains of impacts: particles that meet one wall after another, with grain, spin and inertia.

Nothing acts on a particle between two walls but a gas that may turn its velocity. It tumbles
freely, so that its mean angular velocity and the inertia about it stay; in which orientation it
meets the next wall is the matter of the law there.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import HALF_SIZE, MOST_TURNED, SPEED
from tablegen.simulation.direct import DirectModel

#: The next wall of a particle. "same": the one it left, met at the angle of the departure, as on
#: the outside of a bend. "opposite": parallel to it, as in a channel. "any": met at an angle
#: uniform in `ANY_ANGLES` in a random plane, as in a cyclone or a row of blades. "corner":
#: perpendicular to the wall it left and to its velocity along it.
WALLS = ("same", "opposite", "any", "corner")

#: Angles [rad] at which walls of any direction are met.
ANY_ANGLES = (np.radians(5.0), np.radians(85.0))

#: Logarithm of the ratio of spins that are nearly equal, and the share of departures whose spins
#: are so large that they hardly occur.
_NEARLY, _RARE = 0.2, 0.02

#: Hits from which impacts are taken, in equal shares; before the first hit no particle spins.
HITS = (2, 3, 4, 5, 6)

#: Key of the random numbers, next to the seed.
_KEY = 2**31 + 16

#: Least angle [rad] for each V/a of spin, with a margin: the direct model does not simulate
#: particles that turn too often before they meet the wall.
_TURNED = 2.0 * 1.01 / MOST_TURNED

#: Least speed V [m/s], with a margin for rounding to single precision.
_LEAST_SPEED = 1.001 * SPEED.low

#: Largest V_e over the largest speed V: a spin of 2.1 V/a reaches it there.
FASTEST = 2.0

#: Largest spin of a table, times a/V.
_MOST_SPIN = 10.0


class Impacts(NamedTuple):
    """Impacts of n particles, one each, in the axes of the wall; the unit of length is a."""

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

    def of(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "Impacts":
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

    def of(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "Departures":
        """Select some of the particles."""
        return Departures(self.impacts.of(rows), *(array[rows] for array in self[1:]))


def effective_speed(impacts: Impacts) -> FloatArray:
    """Compute the speeds V_e [m/s] at which translation alone had all of the energy, (n,)."""
    return impacts.speed * energy_factor(impacts.spin, impacts.inertia)


def energy_factor(spin: FloatArray, inertia: FloatArray) -> FloatArray:
    """Compute V_e over V of spins (n, 3), times a/V and the inertia about them, shape (n,)."""
    return np.sqrt(1.0 + inertia * np.square(spin).sum(axis=1))


def depart(
    model: DirectModel, impacts: Impacts, seed: int, threads: int | None = None
) -> Departures:
    """Simulate impacts directly, with the grains that they have."""
    n = len(impacts.index)
    velocity = impacts.speed[:, None] * _towards(impacts.alpha1)
    keys: dict[str, Any] = {
        "seed": seed,
        "index": impacts.index,
        "hit": impacts.hit,
        "threads": threads,
    }
    turning = impacts.speed[:, None] / HALF_SIZE  # V/a
    given: dict[str, Any] = {
        "omega": impacts.spin * turning,
        "inertia": impacts.inertia,
        "grain": impacts.grain,
    }
    # wall axes: at exactly normal impact the frame of `rebound` is turned at random, and then the
    # law is symmetric about the normal
    works = np.empty((n, 2))
    wall = np.array([0.0, 1.0, 0.0])
    after = model.rebound(velocity, wall, HALF_SIZE, **given, **keys, works=works)
    states = np.hstack([after.velocity / impacts.speed[:, None], after.omega / turning])
    over = works / (0.5 * np.square(impacts.speed)[:, None])
    return Departures(impacts, states, after.inertia, over)


def _towards(alpha1: FloatArray) -> FloatArray:
    """Make unit vectors of velocities that meet the wall y = 0 at some angles, (n, 3)."""
    sine = np.minimum(np.sin(alpha1), 1.0)
    return np.column_stack([np.sqrt(1.0 - sine * sine), -sine, np.zeros(len(alpha1))])


def next_impacts(departures: Departures, walls: NDArray[np.intp], uniform: FloatArray) -> Impacts:
    """Let particles fly to their next walls; returns the impacts in the axes of those.

    ``walls`` (n,) are places in `WALLS`; ``uniform`` (n, 2 or more) random numbers from 0 to 1:
    angle and plane.
    """
    low, high = ANY_ANGLES
    direction = _direction(departures)
    normal = _normals_at(direction, low + (high - low) * uniform[:, 0], uniform[:, 1])
    same, opposite, _, corner = (walls == k for k in range(len(WALLS)))
    normal[same | opposite] = np.where(same, 1.0, -1.0)[same | opposite, None] * [0.0, 1.0, 0.0]
    along = direction * [1.0, 0.0, 1.0]
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-300)[:, None]
    normal[corner] = -along[corner]
    direction = np.where(same[:, None], direction * [1.0, -1.0, 1.0], direction)
    return _arrive(departures, direction, normal)


def meet(departures: Departures, alpha1: FloatArray, plane: FloatArray) -> Impacts:
    """Let particles fly to walls that they meet at given angles [rad], in random planes.

    ``plane`` (n,) are random numbers from 0 to 1.
    """
    direction = _direction(departures)
    normal = _normals_at(direction, alpha1, plane)
    return _arrive(departures, direction, normal)._replace(alpha1=alpha1)


def with_spins(departures: Departures, size: FloatArray, rng: np.random.Generator) -> Departures:
    """Take departures with spins of some sizes over the V/a after the wall, (n,).

    An inertia goes with the spins that walls make, and a large spin with another than a small one.
    So each is that of a particle whose spin was nearly as large, scaled to the size; for sizes
    that hardly occur, that of one with a large spin.
    """
    own = spin_sizes_after(departures)
    order = np.argsort(own, kind="stable")
    wanted = size * np.exp(rng.uniform(-_NEARLY, _NEARLY, len(size)))
    rank = np.searchsorted(own[order], wanted)
    rare = int((1.0 - _RARE) * len(own))
    rank = np.where(rank < rare, rank, rng.integers(rare, len(own), len(size)))
    taken, own = departures.of(order[rank]), own[order[rank]]
    scale = np.column_stack([np.ones(len(size)), size / np.maximum(own, 1e-9)])
    return taken._replace(states=taken.states * np.repeat(scale, 3, axis=1))


def spin_sizes_after(departures: Departures) -> FloatArray:
    """Sizes of the spins after a wall, over the V/a after it, (n,)."""
    states = departures.states
    return np.linalg.norm(states[:, 3:], axis=1) / np.linalg.norm(states[:, :3], axis=1)


def _direction(departures: Departures) -> FloatArray:
    """Directions of motion, (n, 3)."""
    velocity = departures.states[:, :3]
    return velocity / np.linalg.norm(velocity, axis=1)[:, None]


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


def _normals_at(direction: FloatArray, alpha1: FloatArray, plane: FloatArray) -> FloatArray:
    """Find normals (n, 3) of walls that particles meet at some angles [rad], in random planes."""
    first = _perpendicular(direction)
    azimuth = 2.0 * np.pi * plane[:, None]
    side = np.cos(azimuth) * first + np.sin(azimuth) * np.cross(direction, first)
    return np.cos(alpha1)[:, None] * side - np.sin(alpha1)[:, None] * direction


def _perpendicular(vectors: FloatArray) -> FloatArray:
    """Find unit vectors perpendicular to unit vectors, (n, 3)."""
    axis = np.where(np.abs(vectors[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    across = np.cross(vectors, axis)
    return across / np.linalg.norm(across, axis=1)[:, None]


def _frame(direction: FloatArray, normal: FloatArray) -> FloatArray:
    """Axes x, y, z of the impacts, the rows of (n, 3, 3) matrices."""
    along = direction - np.einsum("ni,ni->n", direction, normal)[:, None] * normal
    size = np.linalg.norm(along, axis=1)
    # any direction along the wall, if there is none
    along = np.where((size > 1e-9)[:, None], along, _perpendicular(normal))
    along /= np.linalg.norm(along, axis=1)[:, None]
    along -= np.einsum("ni,ni->n", along, normal)[:, None] * normal
    along /= np.linalg.norm(along, axis=1)[:, None]
    return np.stack([along, normal, np.cross(along, normal)], axis=1)


def possible(impacts: Impacts) -> Impacts:
    """Raise angles and speeds to the least that the direct model simulates."""
    steepest = _TURNED * np.sqrt(np.sum(impacts.spin**2, axis=1))
    alpha = np.minimum(np.maximum(impacts.alpha1, steepest), 0.5 * np.pi)
    return impacts._replace(alpha1=alpha, speed=np.maximum(impacts.speed, _LEAST_SPEED))


def speeds_measured(config: Config) -> tuple[float, float]:
    """Return the part of the domain's speeds [m/s] in which the law was measured; all if none."""
    first, last = config.domain.speed
    low, high = config.pair.restitution.valid_speed or (first, last)
    low, high = max(low, first), min(high, last)
    return (low, high) if low < high else (first, last)


def joined_impacts(parts: list[Impacts]) -> Impacts:
    """Put impacts one after another."""
    return Impacts._make(map(np.concatenate, zip(*parts, strict=True)))


def first_impacts(
    alpha1: FloatArray, speed: FloatArray, grain: FloatArray, index: NDArray[np.uint64]
) -> Impacts:
    """Make first impacts: no spin."""
    n = len(index)
    hit = np.zeros(n, dtype=np.uint32)
    return Impacts(alpha1, speed, np.zeros((n, 3)), np.zeros(n), grain, index, hit)


def uniform_numbers(seed: int, index: NDArray[np.uint64], hit: int) -> FloatArray:
    """Draw four numbers from 0 to 1 for each of some particles at a hit, the same in any call.

    The indices ascend.
    """
    if not index.size:
        return np.empty((0, 4))
    bits = np.random.Philox(key=[seed % 2**64, _KEY + hit])
    bits.advance(int(index[0]))  # a step gives four numbers
    count = int(index[-1] - index[0]) + 1
    rows = (index - index[0]).astype(np.intp)
    return np.random.Generator(bits).random((count, 4))[rows]


def occurring_impacts(
    config: Config,
    model: DirectModel,
    seed: int,
    index: NDArray[np.uint64],
    threads: int | None = None,
) -> Impacts:
    """Simulate chains of a configuration with its model, and take one impact from each.

    A third of the particles meets each of the first three `WALLS` again and again; each gives its
    impact number 2, 3, 4, 5 or 6. First angles and speeds are uniform over the table's range, as
    far as the law was measured. A particle that has left the table's range of angles, or is slower
    by its effective speed, gives none. The indices ascend.
    """
    share = uniform_numbers(seed, index, 0)
    low, high = np.radians(config.domain.alpha_deg)
    slow, fast = speeds_measured(config)
    alpha1, speed = low + (high - low) * share[:, 0], slow + (fast - slow) * share[:, 1]
    impacts = first_impacts(alpha1, speed, model.grains(seed, index), index)
    walls = np.minimum((share[:, 2] * 3.0).astype(np.intp), 2)
    wanted = np.array(HITS)[index % np.uint64(len(HITS))]
    taken: list[Impacts] = []
    for number in range(2, max(HITS) + 1):
        departures = depart(model, impacts, seed, threads)
        numbers = uniform_numbers(seed, impacts.index, number)
        impacts = next_impacts(departures, walls, numbers)
        inside = _inside(config, impacts)
        taken.append(impacts.of(inside & (wanted == number)))
        going = inside & (wanted > number)
        impacts, walls, wanted = impacts.of(going), walls[going], wanted[going]
    impacts = joined_impacts(taken)
    return impacts.of(np.argsort(impacts.index))


def _inside(config: Config, impacts: Impacts) -> NDArray[np.bool_]:
    """Whether impacts are within a table's range."""
    (low, high), slowest = np.radians(config.domain.alpha_deg), config.speeds[0]
    turning = np.linalg.norm(impacts.spin, axis=1)
    angles: NDArray[np.bool_] = (low <= impacts.alpha1) & (impacts.alpha1 <= high)
    return angles & (effective_speed(impacts) >= slowest) & (turning <= _MOST_SPIN)
