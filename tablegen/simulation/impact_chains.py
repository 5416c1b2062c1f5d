"""Chains of impacts: the conditions at which particles meet one wall after another.

Nothing acts on a particle between two walls, and it keeps its grain. The next wall is either the
same one again, met at the angle of the departure, as on the outside of a bend, or the opposite one,
as in a channel.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import INERTIA
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.simulation.direct import DirectModel

#: Hits from which impacts are taken, in equal shares; before the first hit no particle spins.
HITS = (2, 3, 4, 5, 6)

#: Key of the random numbers, next to the seed.
_KEY = 2**31 + 1

#: Largest spin, times a/V; less than one particle in a hundred thousand has more.
_MOST_SPIN = 100.0


class Impacts(NamedTuple):
    """Impacts of n particles, one each."""

    #: (n,): angles [rad] from the wall, speeds V [m/s].
    alpha1: FloatArray
    speed: FloatArray
    #: (n, 3): spin before the impact times a/V, wall axes.
    spin: FloatArray
    #: (n,): keys of the particles; `hit` counts the walls met before.
    index: NDArray[np.uint64]  # type: ignore[assignment]  # hides tuple.index
    hit: NDArray[np.uint32]

    def of(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "Impacts":
        """Select some of the particles."""
        return Impacts._make(array[rows] for array in self)


def effective_speed(impacts: Impacts) -> FloatArray:
    """Compute the speed V_e [m/s] that bounds the speed after an impact, (n,)."""
    return impacts.speed * energy_factor(impacts.spin)


def energy_factor(spin: FloatArray) -> FloatArray:
    """Compute V_e over V of spins (n, 3) times a/V, shape (n,)."""
    return np.sqrt(1.0 + INERTIA * np.square(spin).sum(axis=1))


def next_impacts(before: Impacts, state: FloatArray, opposite: NDArray[np.bool_]) -> Impacts:
    """Compute the impacts that follow, in the axes of the next wall.

    `state` (n, 6) are the states after the impacts before. `opposite` (n,) says whether the next
    wall is the opposite one; else it is the same again.
    """
    u, v, w = state[:, 0], state[:, 1], state[:, 2]
    along = np.hypot(u, w)
    speed = np.hypot(along, v)
    # the direction along the wall; any, if there is none
    x = np.divide(u, along, out=np.ones_like(u), where=along > 0.0)
    z = np.divide(w, along, out=np.zeros_like(w), where=along > 0.0)
    # the opposite wall reverses y, and z = x cross y with it
    side = np.where(opposite, -1.0, 1.0)
    spin = np.column_stack(
        [
            state[:, 3] * x + state[:, 5] * z,
            side * state[:, 4],
            side * (state[:, 5] * x - state[:, 3] * z),
        ]
    )
    alpha1, hit = np.arctan2(v, along), before.hit + np.uint32(1)
    return Impacts(alpha1, before.speed * speed, spin / speed[:, None], before.index, hit)


def speeds_measured(config: Config) -> tuple[float, float]:
    """Return the part of the domain's speeds [m/s] in which the law was measured; all if none."""
    first, last = config.domain.speed
    low, high = config.pair.restitution.valid_speed or (first, last)
    low, high = max(low, first), min(high, last)
    return (low, high) if low < high else (first, last)


def first_impacts(config: Config, seed: int, index: NDArray[np.uint64]) -> Impacts:
    """Draw first impacts: no spin, angles and speeds uniform over the table's range.

    `index` has consecutive keys of the particles.
    """
    n, share = len(index), _uniform(seed, index)
    low, high = np.radians(config.domain.alpha_deg)
    slow, fast = speeds_measured(config)
    alpha1, speed = low + (high - low) * share[:, 0], slow + (fast - slow) * share[:, 1]
    return Impacts(alpha1, speed, np.zeros((n, 3)), index, np.zeros(n, dtype=np.uint32))


def occurring_impacts(
    config: Config,
    model: DirectModel,
    seed: int,
    index: NDArray[np.uint64],
    threads: int | None = None,
) -> Impacts:
    """Simulate chains of a configuration with its model, and take one impact from each.

    Half of the particles meet the same wall again and again, half the opposite one each time; each
    gives its impact number 2, 3, 4, 5 or 6. A particle that has left the table's range of angles,
    or is slower by its effective speed, gives none. `index` has consecutive keys of the particles.
    """
    impacts = first_impacts(config, seed, index)
    opposite = _uniform(seed, index)[:, 2] < 0.5
    wanted = np.array(HITS)[index % np.uint64(len(HITS))]
    taken: list[Impacts] = []
    for number in range(2, max(HITS) + 1):
        impacts = next_impacts(impacts, simulated(model, impacts, seed, threads), opposite)
        inside = _inside(config, impacts)
        taken.append(impacts.of(inside & (wanted == number)))
        going = inside & (wanted > number)
        impacts, opposite, wanted = impacts.of(going), opposite[going], wanted[going]
    found = Impacts._make(map(np.concatenate, zip(*taken, strict=True)))
    return found.of(np.argsort(found.index))


def simulated(
    model: DirectModel, impacts: Impacts, seed: int, threads: int | None = None
) -> FloatArray:
    """Simulate impacts directly with the particles' own grains: states (n, 6)."""
    alpha1, speed, spin, index, hit = impacts
    return model.sample(alpha1, speed, spin=spin, seed=seed, index=index, hit=hit, threads=threads)


def _inside(config: Config, impacts: Impacts) -> NDArray[np.bool_]:
    """Whether impacts are within a table's range."""
    (low, high), slowest = np.radians(config.domain.alpha_deg), config.domain.speed[0]
    turning = np.abs(impacts.spin).max(axis=1, initial=0.0)
    angles: NDArray[np.bool_] = (low <= impacts.alpha1) & (impacts.alpha1 <= high)
    return angles & (effective_speed(impacts) >= slowest) & (turning <= _MOST_SPIN)


def _uniform(seed: int, index: NDArray[np.uint64]) -> FloatArray:
    """Draw three numbers from 0 to 1 for each of consecutive particles, the same in any call."""
    bits = np.random.Philox(key=[seed % 2**64, _KEY])
    bits.advance(int(index[0]))  # a step gives four numbers, of which the last is not used
    return np.random.Generator(bits).random((len(index), 4))[:, :3]
