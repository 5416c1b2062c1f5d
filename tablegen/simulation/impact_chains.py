"""Chains of impacts: which conditions occur when particles meet one wall after another.

Between two walls nothing acts on a particle, and it keeps its grain. The next wall is either the
same one again, met at the angle of the departure, as on the outside of a bend, or the opposite one,
as in a channel.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import INERTIA
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel

#: Hits from which impacts are taken, each by as many particles; before the first none spins.
HITS = (2, 3, 4, 5, 6)

#: Purpose of the random numbers, next to the seed.
_KEY = 2**31 + 1

#: Spins beyond this, times V/a, are left out: less than one in a hundred thousand.
_MOST_SPIN = 100.0


@dataclass(frozen=True)
class Impacts:
    """Impacts of n particles, one each."""

    #: Shape (n,). Angles [rad] from the wall, speeds V [m/s].
    alpha1: FloatArray
    speed: FloatArray
    #: Shape (n, 3). Spin before the impact times a/V, wall axes.
    spin: FloatArray
    #: Shape (n,). Keys of the particles; `hit` counts the walls met before.
    index: NDArray[np.uint64]
    hit: NDArray[np.uint32]

    def of(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "Impacts":
        """Impacts of some of the particles."""
        return Impacts(
            self.alpha1[rows], self.speed[rows], self.spin[rows], self.index[rows], self.hit[rows]
        )


def effective_speed(impacts: Impacts) -> FloatArray:
    """Speed V_e [m/s] that no particle can leave the wall with, (n,)."""
    return impacts.speed * energy_factor(impacts.spin)


def energy_factor(spin: FloatArray) -> FloatArray:
    """Give V_e over V of spins (n, 3) times a/V, shape (n,)."""
    return np.sqrt(1.0 + INERTIA * np.square(spin).sum(axis=1))


def next_impacts(before: Impacts, state: FloatArray, opposite: NDArray[np.bool_]) -> Impacts:
    """Impacts that follow.

    Parameters
    ----------
    before : Impacts
    state : float64 array, shape (n, 6)
        After these, in the frame of their wall.
    opposite : bool array, shape (n,)
        Whether the next wall is the opposite one; else it is the same again.

    Returns
    -------
    Impacts
        In the axes of the next wall: x along the tangential velocity, y into the gas.
    """
    u, v, w = state[:, 0], state[:, 1], state[:, 2]
    along = np.hypot(u, w)
    speed = np.hypot(along, v)
    # the direction along the wall; any, if there is none
    x = np.divide(u, along, out=np.ones_like(u), where=along > 0.0)
    z = np.divide(w, along, out=np.zeros_like(w), where=along > 0.0)
    # of the opposite wall y is turned round, and z = x cross y with it
    side = np.where(opposite, -1.0, 1.0)
    spin = np.column_stack(
        [
            state[:, 3] * x + state[:, 5] * z,
            side * state[:, 4],
            side * (state[:, 5] * x - state[:, 3] * z),
        ]
    )
    return Impacts(
        np.arctan2(v, along),
        before.speed * speed,
        spin / speed[:, None],
        before.index,
        before.hit + np.uint32(1),
    )


def speeds_measured(config: Config) -> tuple[float, float]:
    """Speeds [m/s] of a domain in which its law of restitution was measured; all of it if none."""
    first, last = config.domain.speed
    low, high = config.pair.restitution.valid_speed or (first, last)
    low, high = max(low, first), min(high, last)
    return (low, high) if low < high else (first, last)


def first_impacts(config: Config, seed: int, index: NDArray[np.uint64]) -> Impacts:
    """First impacts of particles: no spin, angles and speeds uniform over the table's range.

    Parameters
    ----------
    config : Config
    seed : int
    index : uint64 array, shape (n,)
        Consecutive keys of the particles.
    """
    n = len(index)
    share = _uniform(seed, index)
    low, high = np.radians(config.domain.alpha_deg)
    slow, fast = speeds_measured(config)
    return Impacts(
        low + (high - low) * share[:, 0],
        slow + (fast - slow) * share[:, 1],
        np.zeros((n, 3)),
        index,
        np.zeros(n, dtype=np.uint32),
    )


def occurring_impacts(
    config: Config,
    model: DirectModel,
    seed: int,
    index: NDArray[np.uint64],
    threads: int | None = None,
) -> Impacts:
    """Impacts that occur in chains, one of each particle, simulated up to it.

    Half of the particles meet the same wall again and again, half the opposite one each time; each
    gives its impact number 2, 3, 4, 5 or 6. A particle that has left the table's range of angles,
    or is slower by its effective speed, gives none.

    Parameters
    ----------
    config : Config
    model : DirectModel
        Of the same configuration.
    seed : int
        0 to 2**64 - 1.
    index : uint64 array, shape (n,)
        Consecutive keys of the particles.
    threads : int, optional

    Returns
    -------
    Impacts
        Of at most n particles, in their order.
    """
    impacts = first_impacts(config, seed, index)
    opposite = _uniform(seed, index)[:, 2] < 0.5
    wanted = np.array(HITS)[index % np.uint64(len(HITS))]
    taken: list[Impacts] = []
    for number in range(2, max(HITS) + 1):
        state = simulated(model, impacts, seed, threads)
        impacts = next_impacts(impacts, state, opposite)
        inside = _inside(config, impacts)
        taken.append(impacts.of(inside & (wanted == number)))
        going = inside & (wanted > number)
        impacts, opposite, wanted = impacts.of(going), opposite[going], wanted[going]
    found = Impacts(
        np.concatenate([part.alpha1 for part in taken]),
        np.concatenate([part.speed for part in taken]),
        np.concatenate([part.spin for part in taken]),
        np.concatenate([part.index for part in taken]),
        np.concatenate([part.hit for part in taken]),
    )
    return found.of(np.argsort(found.index))


def simulated(
    model: DirectModel, impacts: Impacts, seed: int, threads: int | None = None
) -> FloatArray:
    """States after impacts by direct simulation, with the particles' own grains, (n, 6)."""
    if len(impacts.index) == 0:
        return np.empty((0, 6))
    return model.sample(
        impacts.alpha1,
        impacts.speed,
        spin=impacts.spin,
        seed=seed,
        index=impacts.index,
        hit=impacts.hit,
        threads=threads,
    )


def _inside(config: Config, impacts: Impacts) -> NDArray[np.bool_]:
    """Whether impacts are within a table's range."""
    (low, high), slowest = np.radians(config.domain.alpha_deg), config.domain.speed[0]
    turning = np.abs(impacts.spin).max(axis=1, initial=0.0)
    angles: NDArray[np.bool_] = (low <= impacts.alpha1) & (impacts.alpha1 <= high)
    return angles & (effective_speed(impacts) >= slowest) & (turning <= _MOST_SPIN)


def _uniform(seed: int, index: NDArray[np.uint64]) -> FloatArray:
    """Three numbers from 0 to 1 for each of consecutive particles, the same in any call."""
    bits = np.random.Philox(key=[seed % 2**64, _KEY])
    bits.advance(int(index[0]))  # a step has four numbers, of which the last is not used
    return np.random.Generator(bits).random((len(index), 4))[:, :3]
