"""Conditions to which the spin law is fitted: impacts that occur, and all others.

The impacts that occur are the later ones of chains, simulated with the particle's own grain and
orientation: on the wall of the last impact, as on the outside of a bend, on the opposite one, as in
a channel, and on walls of any direction. Half of the chains keep their kind of wall. All others are
of particles that have just left a wall, too: the size of their spin and their speed are scaled, as
a gas does, and they meet a wall of any direction. So a spin and the orientations that go with it
are always those of tumbling bodies.
"""

import math
from collections.abc import Callable
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from sampler.formats.bounds import INERTIA
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from tablegen.config.config import Config
from tablegen.config.population import FixedAspect, Population
from tablegen.fitting.spin_coordinates import SPIN_RANGE
from tablegen.model.float_array import FloatArray
from tablegen.model.shapes import inertia
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    FASTEST,
    Departures,
    Impacts,
    depart,
    energy_factor,
    first_impacts,
    joined_impacts,
    meet,
    next_impacts,
    possible,
    speeds_measured,
    with_spins,
)

#: Share of the conditions that come from chains, and hits of a chain.
_CHAINS, _HITS = 0.55, 6

#: Share of the chains that go on after the second impact. Orientations at a second impact differ
#: from those at later ones, which the spin does not show; if all went on, one in five were second.
_ON = 0.6

#: Kinds of walls in chains: the first of `tablegen.simulation.impact_chains.WALLS`.
_KINDS = 3

#: Largest spin of conditions over the largest that the law covers.
_BEYOND = 1.25

#: Shares of the impacts without spin: crowded at the steepest angle, and with effective speeds V_e
#: that only spinning particles have.
_STEEP, _FAST = 0.33, 0.05

#: Impacts of chains with a larger spin over V/a, or a lower speed [m/s], are left out.
_FASTEST_SPIN, _SLOWEST = 100.0, 1e-3

#: Share of the grains whose ratios are spread evenly, so that the law serves other populations, and
#: the standard deviations to either side of the mean that they cover: a fixed ratio stays fixed.
_EVEN, _DEVIATIONS = 0.5, 4.0


class Range(NamedTuple):
    """Impacts that are covered: angles [rad], V_e [m/s], and speeds V at which chains begin."""

    alpha: tuple[float, float]
    speed: tuple[float, float]
    first_speed: tuple[float, float]

    @classmethod
    def of(cls, config: Config) -> Self:
        """Find the range that the spin law of a configuration covers."""
        first, last = (min(math.radians(x), math.pi / 2.0) for x in config.domain.alpha_deg)
        low, high = config.speeds
        return cls((first, last), (low, FASTEST * high), speeds_measured(config))

    def holds(self, impacts: Impacts) -> NDArray[np.bool_]:
        """Tell which impacts are covered, (n,)."""
        effective = impacts.speed * energy_factor(impacts.spin)
        return (
            (self.alpha[0] <= impacts.alpha1)
            & (impacts.alpha1 <= self.alpha[1])
            & (self.speed[0] <= effective)
            & (effective <= self.speed[1])
            & (impacts.speed > _SLOWEST)
            & (np.sum(impacts.spin**2, axis=1) < _FASTEST_SPIN**2)
        )


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


def inertia_coefficients(population: Population, shape_code: int) -> tuple[float, float]:
    """Find g_1 and g_3 of the grains of a shape or mesh.

    With the ratios beta = b/a and gamma = c/b their largest moment of inertia is
    g_1 (1 + beta^2) m a^2, and their smallest g_3 beta^2 (1 + gamma^2) m a^2.
    """
    if shape_code < FIRST_MESH:
        largest = float(inertia(shape_code, 1.0, 1.0, population.truncation)[2])
        return 0.5 * largest, 0.5 * largest
    meshes = population.kernel_arguments().meshes
    moments = meshes.moments[shape_code - FIRST_MESH]
    b, c = meshes.sizes[shape_code - FIRST_MESH, :2]
    return float(moments.max() / (1.0 + b * b)), float(moments.min() / (b * b + c * c))


def least_inertia(population: Population) -> float:
    """Find the smallest principal moment of inertia over m a^2 of any grain of a population."""
    moments = []
    for code in population.kernel_arguments().shape_codes:
        (b, _), (c, _) = ratio_range(population, int(code))
        moments.append(inertia_coefficients(population, int(code))[1] * b * b * (1.0 + c * c))
    return float(min(moments))


def draw_ratios(
    population: Population, shape_code: int, count: int, rng: np.random.Generator
) -> FloatArray:
    """Draw b/a and c/b of grains of a shape, (count, 2).

    Half follow the law of the population, and half are uniform where it has grains.
    """
    low, high = ratio_range(population, shape_code).T
    lawful = rng.random(count) >= _EVEN
    if not (low < high).any():
        return rng.uniform(low, high, (count, 2))
    mean, deviation, least, most = population.kernel_arguments().aspect.T
    around = _DEVIATIONS * deviation
    first, last = np.clip(mean - around, low, high), np.clip(mean + around, low, high)
    ratios = rng.uniform(first, last, (count, 2))
    u = rng.uniform(least, most, (int(lawful.sum()), 2))
    ratios[lawful] = np.clip(mean + deviation * ndtri(u), low, high)
    return ratios


def _speeds(low: float, high: float, count: int, rng: np.random.Generator) -> FloatArray:
    """Speeds; half are uniform, half are uniform in the logarithm."""
    logarithm = np.exp(rng.uniform(math.log(low), math.log(high), count))
    return np.where(rng.random(count) < 0.5, logarithm, rng.uniform(low, high, count))


def _angles(domain: Range, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw angles; half are uniform in the square root, the others are uniform."""
    low, high = domain.alpha
    root = rng.uniform(math.sqrt(low), math.sqrt(high), count) ** 2
    even = rng.uniform(low, high, count)
    return np.clip(np.where(rng.random(count) < 0.5, root, even), low, high)


def still_impacts(domain: Range, grains: FloatArray, rng: np.random.Generator) -> Impacts:
    """Draw impacts without spin of some grains (n, 3).

    Some are crowded at the steepest angle, where the law changes most within a degree, and few are
    faster than a particle that does not spin can be.
    """
    n = len(grains)
    alpha, steep = _angles(domain, n, rng), rng.random(n) < _STEEP
    low, high = domain.alpha
    alpha[steep] = high - (high - low) * rng.random(int(steep.sum())) ** 2
    slow, fast = (
        _speeds(domain.speed[0], most, n, rng) for most in (domain.first_speed[1], domain.speed[1])
    )
    speed = np.where(rng.random(n) < _FAST, fast, slow)
    return first_impacts(alpha, speed, grains, np.arange(n, dtype=np.uint64))


def chain_impacts(
    model: DirectModel,
    domain: Range,
    grains: FloatArray,
    seed: Callable[[int], int],
    rng: np.random.Generator,
) -> tuple[Impacts, Departures]:
    """Simulate a chain for each grain (m, 3), until it leaves the domain.

    ``seed`` gives that of each hit. Returns the second to the last impacts of all chains, and all
    departures.
    """
    count = len(grains)
    alpha, speed = _angles(domain, count, rng), rng.uniform(*domain.first_speed, count)
    impacts = first_impacts(alpha, speed, grains, np.arange(count, dtype=np.uint64))
    kind, keeps = rng.integers(0, _KINDS, count), rng.random(count) < 0.5
    met, left = [impacts.of(slice(0, 0))], []
    for hit in range(1, _HITS):
        departures = depart(model, impacts, seed(hit), threads=1)
        left.append(departures)
        walls = np.where(keeps, kind, rng.integers(0, _KINDS, len(keeps)))
        impacts = next_impacts(model, departures, walls, rng.random((len(keeps), 3)))
        good = domain.holds(impacts)
        impacts, keeps, kind = possible(impacts.of(good)), keeps[good], kind[good]
        met.append(impacts)
        if hit == 1:
            on = (rng.random(len(good)) < _ON)[good]
            impacts, keeps, kind = impacts.of(on), keeps[on], kind[on]
        if not len(keeps):
            break
    return joined_impacts(met), joined_departures(left)


def spread_impacts(
    model: DirectModel,
    domain: Range,
    departures: Departures,
    count: int,
    rng: np.random.Generator,
) -> Impacts:
    """Draw impacts over the whole domain, of particles that have just left a wall.

    The size of tau is uniform (`tablegen.fitting.spin_coordinates`), and the wall has any
    direction.
    """
    most = (_BEYOND * SPIN_RANGE[1]) ** 2
    square = rng.uniform(0.0, math.sqrt(most / math.sqrt(1.0 + most)), count) ** 4
    # tau^4 = s^4 / (1 + s^2)
    size = np.sqrt(0.5 * (square + np.sqrt(square * (square + 4.0))))
    share = 1.0 / np.sqrt(1.0 + INERTIA * size * size)
    taken = with_spins(departures, size, rng)
    alpha = _angles(domain, count, rng)
    impacts = meet(model, taken, alpha, rng.random((count, 2)))
    return possible(impacts._replace(speed=_speeds(*domain.speed, count, rng) * share))


def spinning_impacts(
    model: DirectModel,
    domain: Range,
    population: Population,
    shape_code: int,
    count: int,
    seed: Callable[[int], int],
    rng: np.random.Generator,
) -> Impacts:
    """Draw impacts with spin in random order.

    There are about ``count``, and fewer if chains leave the domain.
    """
    chains = math.ceil(_CHAINS * count / (1.0 + _ON * (_HITS - 2.0)))
    grains = grains_of(population, shape_code, chains, rng)
    met, departures = chain_impacts(model, domain, grains, seed, rng)
    spread = spread_impacts(model, domain, departures, count - math.floor(_CHAINS * count), rng)
    both = joined_impacts([met, spread])
    return both.of(rng.permutation(len(both.index)))


def grains_of(
    population: Population, shape_code: int, count: int, rng: np.random.Generator
) -> FloatArray:
    """Draw grains of a shape, (count, 3)."""
    ratios = draw_ratios(population, shape_code, count, rng)
    return np.column_stack([np.full(count, float(shape_code)), ratios])


def joined_departures(parts: list[Departures]) -> Departures:
    """Put departures one after another."""
    impacts = joined_impacts([part.impacts for part in parts])
    return Departures(impacts, *(np.concatenate([part[k] for part in parts]) for k in (1, 2, 3)))
