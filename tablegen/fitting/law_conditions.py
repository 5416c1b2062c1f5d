"""Conditions to which the spin law is fitted: impacts that occur, and all others.

The impacts that occur are the later ones of chains, simulated with the particle's own grain: on the
wall of the last impact, as on the outside of a bend, or on the opposite one, as in a channel. Half
of the chains keep their geometry and depart at the angle at which they left; the others change
walls and angles at random, as a gas and a curved wall make them. Conditions spread over the whole
domain cover everything else.
"""

import math
from collections.abc import Callable
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from sampler.formats.bounds import INERTIA, N_CONDITIONS
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from tablegen.config.config import Config
from tablegen.config.population import FixedAspect, Population
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import MOST_TURNED, SPEED
from tablegen.simulation.impact_chains import Impacts, energy_factor, next_impacts, speeds_measured

#: Share of the conditions that come from chains, and hits of a chain.
_CHAINS, _HITS = 0.5, 6

#: Largest spin over V_e/a of conditions spread over the domain; none is above sqrt(3/2) = 1.2247.
_MOST_SPIN = 1.21

#: Impacts of chains with a larger spin over V/a, or a lower speed [m/s], are left out.
_FASTEST_SPIN, _SLOWEST = 100.0, 1e-3

#: Least angle [rad] for each V/a of spin, with a margin: the direct model does not simulate
#: particles that turn too often before they meet the wall.
_TURNED = 2.0 * 1.01 / MOST_TURNED

#: Least speed V [m/s], with a margin for rounding to single precision.
_LEAST_SPEED = 1.001 * SPEED.low

#: Largest V_e over the largest speed V: a spin of 2.1 V/a reaches it there.
FASTEST = 2.0

#: Share of the grains with ratios spread evenly over their range, for other populations.
_EVEN = 0.5

#: Simulates rebounds: conditions (n, 5), grains (n, 3) and number of the hit, to states (n, 6).
Rebound = Callable[[FloatArray, FloatArray, int], FloatArray]


class Range(NamedTuple):
    """Impacts that are covered: angles [rad], V_e [m/s], and speeds V at which chains begin."""

    alpha: tuple[float, float]
    speed: tuple[float, float]
    first_speed: tuple[float, float]

    @classmethod
    def of(cls, config: Config) -> Self:
        """Find the range that the spin law of a configuration covers."""
        first, last = (min(math.radians(x), math.pi / 2.0) for x in config.domain.alpha_deg)
        low, high = config.domain.speed
        return cls((first, last), (low, FASTEST * high), speeds_measured(config))

    def holds(self, conditions: FloatArray) -> NDArray[np.bool_]:
        """Tell which conditions (n, 5) are covered, (n,)."""
        alpha, speed, spin = conditions[:, 0], conditions[:, 1], conditions[:, 2:]
        effective = speed * energy_factor(spin)
        return (
            (self.alpha[0] <= alpha)
            & (alpha <= self.alpha[1])
            & (self.speed[0] <= effective)
            & (effective <= self.speed[1])
            & (speed > _SLOWEST)
            & (np.sum(spin * spin, axis=1) < _FASTEST_SPIN**2)
        )


def _possible(conditions: FloatArray) -> FloatArray:
    """Raise angles and speeds to the least that the direct model simulates."""
    steepest = _TURNED * np.sqrt(np.sum(conditions[:, 2:] ** 2, axis=1))
    alpha = np.minimum(np.maximum(conditions[:, 0], steepest), math.pi / 2.0)
    return np.column_stack([alpha, np.maximum(conditions[:, 1], _LEAST_SPEED), conditions[:, 2:]])


def ratio_range(population: Population, shape_code: int) -> FloatArray:
    """Find the range of b/a and of c/b of the grains of a shape or mesh, (2, 2)."""
    if shape_code >= FIRST_MESH:
        b, c = population.kernel_arguments().meshes.sizes[shape_code - FIRST_MESH, :2]
        return np.array([[b, b], [c / b, c / b]])
    aspect = population.aspect
    if shape_code == SHAPE_CODES["sphere"] or aspect is None:
        return np.ones((2, 2))
    if isinstance(aspect, FixedAspect):
        return np.array([[value, value] for value in aspect.values])
    return np.array([aspect.range, aspect.range])


def draw_ratios(
    population: Population, shape_code: int, count: int, rng: np.random.Generator
) -> FloatArray:
    """Draw b/a and c/b of grains of a shape, (count, 2).

    Half follow the law of the population, and half are uniform over its range.
    """
    low, high = ratio_range(population, shape_code).T
    ratios = rng.uniform(low, high, (count, 2))
    lawful = rng.random(count) >= _EVEN
    if (low < high).any():
        mean, deviation, least, most = population.kernel_arguments().aspect.T
        u = rng.uniform(least, most, (int(lawful.sum()), 2))
        ratios[lawful] = np.clip(mean + deviation * ndtri(u), low, high)
    return ratios


def _speeds(low: float, high: float, count: int, rng: np.random.Generator) -> FloatArray:
    """Speeds; half are uniform, half are uniform in the logarithm."""
    logarithm = np.exp(rng.uniform(math.log(low), math.log(high), count))
    return np.where(rng.random(count) < 0.5, logarithm, rng.uniform(low, high, count))


def _angles(domain: Range, count: int, rng: np.random.Generator) -> FloatArray:
    """Angles; a third are uniform in the square root, the others are uniform."""
    low, high = domain.alpha
    root = rng.uniform(math.sqrt(low), math.sqrt(high), count) ** 2
    even = rng.uniform(low, high, count)
    return np.clip(np.where(rng.random(count) < 1.0 / 3.0, root, even), low, high)


def still_conditions(domain: Range, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw conditions without spin, (count, 5)."""
    alpha, speed = _angles(domain, count, rng), _speeds(*domain.speed, count, rng)
    return np.column_stack([alpha, speed, np.zeros((count, 3))])


def spread_conditions(domain: Range, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw conditions over the whole domain, with spins of any direction, (count, 5)."""
    size = rng.uniform(0.0, _MOST_SPIN, count)
    direction = rng.standard_normal((count, 3))
    direction /= np.sqrt(np.sum(direction**2, axis=1))[:, None]
    share = np.sqrt(1.0 - INERTIA * size * size)
    alpha, speed = _angles(domain, count, rng), _speeds(*domain.speed, count, rng) * share
    return _possible(np.column_stack([alpha, speed, (size / share)[:, None] * direction]))


def _following(
    conditions: FloatArray, states: FloatArray, opposite: NDArray[np.bool_]
) -> FloatArray:
    """Impacts that follow rebounds without forces between, (n, 5)."""
    none = np.zeros(len(conditions), dtype=np.uint64), np.zeros(len(conditions), dtype=np.uint32)
    before = Impacts(conditions[:, 0], conditions[:, 1], conditions[:, 2:], *none)
    after = next_impacts(before, states, opposite)
    return np.column_stack([after.alpha1, after.speed, after.spin])


def chain_conditions(
    domain: Range, grains: FloatArray, rebound: Rebound, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Simulate a chain for each grain (m, 3), until it leaves the domain.

    Returns the conditions (n, 5) of the second to the last hit, and the grains (n, 3) of each.
    """
    count = len(grains)
    conditions = still_conditions(domain, count, rng)
    conditions[:, 1] = rng.uniform(*domain.first_speed, count)
    keeps, opposite = rng.random(count) < 0.5, rng.random(count) < 0.5
    found = [(np.empty((0, N_CONDITIONS)), np.empty((0, 3)))]
    for hit in range(1, _HITS):
        if not len(grains):
            break
        states = rebound(conditions, grains, hit)
        walls = np.where(keeps, opposite, rng.random(len(keeps)) < 0.5)
        conditions = _following(conditions, states, walls)
        other = ~keeps & (rng.random(len(keeps)) < 0.5)
        conditions[other, 0] = rng.uniform(*domain.alpha, int(other.sum()))
        good = domain.holds(conditions)
        conditions, grains = _possible(conditions[good]), grains[good]
        keeps, opposite = keeps[good], opposite[good]
        found.append((conditions, grains))
    parts, owners = zip(*found, strict=True)
    return np.concatenate(parts), np.concatenate(owners)


def spinning_conditions(
    domain: Range,
    population: Population,
    shape_code: int,
    count: int,
    rebound: Rebound,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Draw conditions (n, 5) with spin in random order, and the grains (n, 3) that meet them.

    There are about ``count``, and fewer if chains leave the domain.
    """
    chains = math.ceil(_CHAINS * count / (_HITS - 1.0))
    spread = count - math.floor(_CHAINS * count)
    ratios = draw_ratios(population, shape_code, chains + spread, rng)
    grains = np.column_stack([np.full(len(ratios), float(shape_code)), ratios])
    met, owners = chain_conditions(domain, grains[:chains], rebound, rng)
    conditions = np.concatenate([met, spread_conditions(domain, spread, rng)])
    grains = np.concatenate([owners, grains[chains:]])
    order = rng.permutation(len(conditions))
    return conditions[order], grains[order]
