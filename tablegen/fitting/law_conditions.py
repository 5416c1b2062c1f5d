"""Draw the conditions of impacts to which the spin law is fitted.

Angle, speed, spin, the inertia about the spin and the grain decide the law of a rebound, whatever
happened to the grain before. So the conditions of the fit need no history, and can be dense where
flows have many impacts. There are three kinds:

- *Impacts of chains.* A grain hits one wall after another, on the inside of a cylinder, between two
  opposite walls, or on walls of any direction, and gets its speed back after each hit: the velocity
  keeps its direction, or the gas drives the grain along the wall, which it meets as fast as it left
  the one before. In such chains grains settle into rolling, with spins that differ by a few
  hundredths. These spins depend on the pair, the grain and the gas, and only chains find them. Some
  chains are short, because the first hits differ; some are long; and in some, on one wall, nearly
  round grains settle, which in a flow make most of the hits.
- *Neighbours* of impacts of chains, because gas and the curvature of walls change the angle between
  two hits: more than half have another angle alone, and the others another spin, too.
- *Spread impacts*, over the whole range of the law.

``tablegen/fitting/EXPERIMENTS.md`` compares fits with and without chains.

Units: angles in rad; speeds V in m/s; spins in V/a; inertias over m a^2. The effective speed V_e is
the speed whose translational energy is the whole energy of a grain, V_e = V sqrt(1 + k |s|^2).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import Config
from tablegen.config.grain_ranges import inertia_coefficients, ratio_range
from tablegen.config.population import Population
from tablegen.fitting.spin_coordinates import (
    SPIN_RANGE,
    Moments,
    inertia_from_kappa,
    kappa_from_inertia,
    kappa_from_place,
)
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import SPEED
from tablegen.simulation.direct_law import DirectLaw
from tablegen.simulation.impact_chains import (
    ANY_WALL,
    OPPOSITE_WALL,
    SAME_WALL,
    Impacts,
    energy_factor,
    first_impacts,
    join_impacts,
    next_impacts,
    raise_to_limits,
    simulate_departures,
)

#: Angles [degrees] that a spin law covers, whatever the angles of first impacts are: grains leave a
#: wall at any angle, and meet the next wall at any angle.
LAW_ALPHA_DEG = (0.05, 90.0)

#: Least and largest V_e over the largest speed V of a configuration; a draw for a grain with
#: another V_e uses the nearest one, and is counted. Hits take energy, so grains that are about to
#: rest are a thousand times slower than when they came in. Few grains have a spin of 2.7 V/a or
#: more at the largest speed.
SLOWEST, FASTEST = 3e-4, 2.0

#: Shares of the impacts of chains and of their neighbours; the other impacts are spread.
_CHAIN_SHARE, _NEIGHBOUR_SHARE = 0.45, 0.43


class Chains(NamedTuple):
    """A kind of chains."""

    #: Their weight among the impacts of chains.
    weight: float
    hits: int
    #: The impact of one hit in this many is taken, so that the impacts are of more grains.
    every: int
    #: Shares of the chains on one wall, between two opposite walls, and on walls of any direction.
    walls: dict[int, float]
    #: Share of those on one or two walls in which the gas makes up for what a hit takes from the
    #: motion along the wall.
    along_wall: float
    #: Share of the ellipsoids that are rounder: 1 - b/a is multiplied by a uniform random number.
    rounder: float


_ALL_WALLS = {SAME_WALL: 0.42, OPPOSITE_WALL: 0.28, ANY_WALL: 0.3}

#: Nearly round grains settle within a hundred hits. Grains of other shapes do not settle, so their
#: chains are of the first two kinds. The impacts of a chain are of one grain, and alike. So long
#: chains give one impact in four, and the impacts are of four times as many grains.
SHORT_CHAINS = Chains(0.3, 5, 1, _ALL_WALLS, along_wall=0.5, rounder=0.0)
LONG_CHAINS = Chains(0.4, 121, 4, _ALL_WALLS, along_wall=0.5, rounder=0.3)
SETTLED_CHAINS = Chains(0.3, 101, 4, {SAME_WALL: 1.0}, along_wall=0.3, rounder=1.0)

#: Range of the exponents by which the gas of such a chain slows down the spin from hit to hit, and
#: the part of it by which the velocity towards the wall gets slower. Of a sphere in Stokes's drag
#: that a constant force presses to the wall, this part is a tenth for short hops: the spin is
#: slowed down at 10/3 times the rate of a velocity, and a hop returns a third of its drag.
_DAMPING, _HOP_PART = (3e-3, 3.0), 0.1

#: Share of the neighbours that keep their rotation, and the standard deviation of the logarithm of
#: their angles: grains that roll come to rest at angles that are rare in chains.
_TURNED_SHARE, _TURNED_DEVIATION = 0.6, 1.0

#: Standard deviations of the changes from an impact to another neighbour: of the logarithm of the
#: size of the spin and of the angle, of the three numbers of the spin over its size, and of the
#: logarithm of the odds of kappa.
_SIZE_DEVIATION, _ANGLE_DEVIATION = 0.4, 0.5
_DIRECTION_DEVIATION, _ODDS_DEVIATION = 0.1, 0.5
#: A third of these neighbours has a spin that is scaled down, at most by this factor.
_LEAST_SLOWDOWN = 1e-3

#: Sizes [V/a] of slow, usual and fast spins of spread impacts, and shares of the first two.
_SLOW_SPINS, _USUAL_SPINS, _FAST_SPINS = (1e-3, 0.1), (0.02, 2.0), (1.0, SPIN_RANGE[1])
_SPIN_SHARES = (0.15, 0.65)

#: Share of the impacts without spin that are crowded at the steepest angle.
_STEEP_SHARE = 0.33

#: Share of the grains whose ratios are uniform, so that the law serves other populations. Uniform
#: ratios lie within this number of standard deviations of the mean, so a fixed ratio stays fixed.
_EVEN_SHARE, _DEVIATIONS = 0.5, 4.0


class LawRange(NamedTuple):
    """Range of impacts that a spin law covers."""

    #: Least and largest angle [rad].
    alpha: tuple[float, float]
    #: Least and largest speed V [m/s].
    speed: tuple[float, float]
    #: Least and largest effective speed V_e [m/s].
    effective: tuple[float, float]


def covered_range(config: Config) -> LawRange:
    """Find the range of impacts that the spin law of a configuration covers."""
    first, last = min(config.domain.alpha_deg[0], LAW_ALPHA_DEG[0]), LAW_ALPHA_DEG[1]
    alpha = math.radians(first), min(math.radians(last), math.pi / 2.0)
    slow, high = config.domain.speed
    low = max(min(slow, SLOWEST * high), SPEED.low)
    return LawRange(alpha, (low, high), (low, FASTEST * high))


def grain_moments(population: Population, shape_code: int, ratios: FloatArray) -> Moments:
    """Compute the moments of inertia of grains of a shape or mesh from their ratios (n, 2)."""
    first, third = inertia_coefficients(population, shape_code)
    beta, gamma = np.square(ratios).T
    return Moments(first * (1.0 + beta), third * beta * (1.0 + gamma))


def draw_ratios(
    population: Population, shape_code: int, count: int, rng: np.random.Generator
) -> FloatArray:
    """Draw b/a and c/b of grains of a shape or mesh, (count, 2).

    Half of the grains follow the law of the population. The ratios of the others are uniform over
    the range that the population has.
    """
    low, high = ratio_range(population, shape_code).T
    lawful = rng.random(count) >= _EVEN_SHARE
    if not (low < high).any():
        return rng.uniform(low, high, (count, 2))
    mean, deviation, least, most = population.aspect_rows.T
    around = _DEVIATIONS * deviation
    first, last = np.clip(mean - around, low, high), np.clip(mean + around, low, high)
    ratios = rng.uniform(first, last, (count, 2))
    u = rng.uniform(least, most, (int(lawful.sum()), 2))
    ratios[lawful] = np.clip(mean + deviation * ndtri(u), low, high)
    return ratios


def _rounder(
    ellipsoids: FloatArray, population: Population, share: float, rng: np.random.Generator
) -> FloatArray:
    """Make a share of ellipsoids (n, 3) rounder, up to the largest b/a of the population."""
    largest, n = ratio_range(population, SHAPE_CODES["ellipsoid"])[0, 1], len(ellipsoids)
    part = np.where(rng.random(n) < share, rng.random(n), 1.0)
    return np.column_stack(
        [ellipsoids[:, 0], largest - part * (largest - ellipsoids[:, 1]), ellipsoids[:, 2]]
    )


def draw_grains(
    population: Population, shape_code: int, count: int, rng: np.random.Generator
) -> FloatArray:
    """Draw grains of a shape or mesh: shape code, b/a and c/b, (count, 3)."""
    ratios = draw_ratios(population, shape_code, count, rng)
    return np.column_stack([np.full(count, float(shape_code)), ratios])


def _draw_speeds(low: float, high: float, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw speeds that are uniform in the cube root, so that slow ones are not rare."""
    return rng.uniform(np.cbrt(low), np.cbrt(high), count) ** 3


def _log_uniform(ends: tuple[float, float], count: int, rng: np.random.Generator) -> FloatArray:
    """Draw numbers that are uniform in the logarithm."""
    return np.exp(rng.uniform(math.log(ends[0]), math.log(ends[1]), count))


def _draw_angles(domain: LawRange, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw angles [rad]: some are uniform, some uniform in the square root or the cube root."""
    low, high = domain.alpha
    power = rng.choice([1.0, 2.0, 3.0], count, p=[0.4, 0.4, 0.2])
    root = rng.uniform(low ** (1.0 / power), high ** (1.0 / power))
    return np.clip(root**power, low, high)


def nonspinning_impacts(domain: LawRange, grains: FloatArray, rng: np.random.Generator) -> Impacts:
    """Draw impacts without spin of grains (n, 3).

    A third of the angles is crowded at the steepest one, where the law changes most within a
    degree.
    """
    n = len(grains)
    alpha, steep = _draw_angles(domain, n, rng), rng.random(n) < _STEEP_SHARE
    low, high = domain.alpha
    alpha[steep] = high - (high - low) * rng.random(int(steep.sum())) ** 2
    return first_impacts(
        alpha, _draw_speeds(*domain.speed, n, rng), grains, np.arange(n, dtype=np.uint64)
    )


def chain_impacts(
    law: DirectLaw,
    domain: LawRange,
    grains: FloatArray,
    kind: Chains,
    seed: Callable[[int], int],
    rng: np.random.Generator,
) -> tuple[Impacts, FloatArray]:
    """Simulate a kind of chains of hits of grains.

    Parameters
    ----------
    law : DirectLaw
    domain : LawRange
        Impacts outside this range are moved to its ends.
    grains : (m, 3) float64
    kind : Chains
    seed : callable
        Gives the seed of each hit from its number.
    rng : numpy.random.Generator

    Returns
    -------
    impacts : Impacts
        The impact of one hit in ``kind.every`` of each grain, hit after hit. The first hit of a
        chain is left out.
    inertia : (m,) float64
        Inertia of each grain after its first hit; 0 if it does not spin.
    """
    count, (least, _) = len(grains), domain.alpha
    impacts = nonspinning_impacts(domain, grains, rng)
    # after each hit, half of the grains get their first V back, and the others their first V_e
    speed, keeps_speed = impacts.speed, rng.random(count) < 0.5
    walls = rng.choice(list(kind.walls), count, p=list(kind.walls.values()))
    along_wall = (walls != ANY_WALL) & (rng.random(count) < kind.along_wall)
    keeps_speed |= along_wall
    damping = _log_uniform(_DAMPING, count, rng)
    inertia_after_first, impacts_by_hit = np.zeros(count), []
    for hit in range(1, kind.hits):
        departures = simulate_departures(law, impacts, seed(hit), threads=1)
        if hit == 1:
            inertia_after_first = departures.inertia
        impacts = next_impacts(departures, walls, rng.random((count, 2)))
        impacts = driven_along_wall(impacts, along_wall, speed, damping)
        alpha = np.maximum(impacts.alpha1, least)
        factor = energy_factor(impacts.spin, impacts.inertia)
        effective = speed * np.where(keeps_speed, factor, 1.0)
        impacts = impacts._replace(alpha1=alpha)
        impacts = _at_speed(impacts, impacts.spin, impacts.inertia, effective, domain)
        impacts_by_hit.append(impacts.select(slice(hit % kind.every, None, kind.every)))
    return join_impacts(impacts_by_hit), inertia_after_first


def driven_along_wall(
    impacts: Impacts, driven: NDArray[np.bool_], speed: FloatArray, damping: FloatArray
) -> Impacts:
    """Let a gas drive some grains along the wall to given speeds [m/s].

    It slows down the spin in rad/s by the exponential of ``damping``, and by a part of it the
    velocity towards the wall. So angles and spins in V/a get smaller.
    """
    part = np.where(driven, np.minimum(impacts.speed / speed, 1.0), 1.0)
    slower = np.where(driven, np.exp(-damping), 1.0)
    return impacts._replace(
        alpha1=np.arcsin(part * slower**_HOP_PART * np.sin(impacts.alpha1)),
        speed=impacts.speed / part,
        spin=(part * slower)[:, None] * impacts.spin,
    )


def _at_speed(
    impacts: Impacts, spin: FloatArray, inertia: FloatArray, effective: FloatArray, domain: LawRange
) -> Impacts:
    """Give impacts other spins, inertias and effective speeds, within the range of the law."""
    size = np.linalg.norm(spin, axis=1)
    spin = spin * np.minimum(1.0, SPIN_RANGE[1] / np.maximum(size, 1e-300))[:, None]
    factor = energy_factor(spin, inertia)
    speed = np.minimum(np.minimum(effective, domain.effective[1]) / factor, domain.speed[1])
    return raise_to_limits(impacts._replace(spin=spin, inertia=inertia, speed=speed))


def neighbouring_impacts(
    impacts: Impacts, domain: LawRange, moments: Moments, rng: np.random.Generator
) -> Impacts:
    """Change the angles, spins and inertias of impacts, as a gas might; draw speeds anew."""
    n, (least, most) = len(impacts.index), domain.alpha
    turned = rng.random(n) < _TURNED_SHARE
    size = np.linalg.norm(impacts.spin, axis=1)[:, None]
    slowdown = np.where(
        rng.random(n) < 1.0 / 3.0, _log_uniform((_LEAST_SLOWDOWN, 1.0), n, rng), 1.0
    )
    spin = impacts.spin + _DIRECTION_DEVIATION * size * rng.standard_normal((n, 3))
    spin *= (slowdown * np.exp(_SIZE_DEVIATION * rng.standard_normal(n)))[:, None]
    spin = np.where(turned[:, None], impacts.spin, spin)
    deviation = np.where(turned, _TURNED_DEVIATION, _ANGLE_DEVIATION)
    alpha = np.clip(impacts.alpha1 * np.exp(deviation * rng.standard_normal(n)), least, most)
    kappa = kappa_from_inertia(impacts.inertia, moments)
    odds = np.exp(np.where(turned, 0.0, _ODDS_DEVIATION * rng.standard_normal(n)))
    inertia = inertia_from_kappa(kappa * odds / (1.0 - kappa + kappa * odds), moments)
    effective = _draw_speeds(*domain.effective, n, rng)
    return _at_speed(impacts._replace(alpha1=alpha), spin, inertia, effective, domain)


def spread_impacts(
    domain: LawRange, grains: FloatArray, moments: Moments, rng: np.random.Generator
) -> Impacts:
    """Spread impacts of grains (n, 3) over the whole range of the law.

    Half of the spins have any direction, and half lie about that of a rolling grain. Half of the
    inertias are uniform in kappa, and half are those of spins with any direction in the grain.
    """
    n = len(grains)
    slow, fast = (_log_uniform(ends, n, rng) for ends in (_SLOW_SPINS, _FAST_SPINS))
    choice = rng.random(n)
    size = np.where(choice < _SPIN_SHARES[0], slow, rng.uniform(*_USUAL_SPINS, n))
    size = np.where(choice < sum(_SPIN_SHARES), size, fast)
    direction = _unit_vectors(rng.standard_normal((n, 3)))
    rolling = _unit_vectors(0.5 * direction * [1.0, 1.0, 2.0] - [0.0, 0.0, 1.2])
    direction = np.where((rng.random(n) < 0.5)[:, None], rolling, direction)
    cosine = rng.random(n)  # of the angle between the spin and the grain's shortest axis
    kappa = np.where(rng.random(n) < 0.5, rng.random(n), kappa_from_place(cosine**2))
    alpha, index = _draw_angles(domain, n, rng), np.arange(n, dtype=np.uint64)
    impacts = first_impacts(alpha, np.ones(n), grains, index)
    inertia = inertia_from_kappa(kappa, moments)
    effective = _draw_speeds(*domain.effective, n, rng)
    return _at_speed(impacts, size[:, None] * direction, inertia, effective, domain)


def _unit_vectors(vectors: FloatArray) -> FloatArray:
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def spinning_impacts(
    law: DirectLaw,
    domain: LawRange,
    population: Population,
    shape_code: int,
    count: int,
    seed: Callable[[int], int],
    rng: np.random.Generator,
) -> tuple[Impacts, FloatArray]:
    """Draw impacts with spin of a shape or mesh: impacts of chains, their neighbours, spread ones.

    Returns
    -------
    impacts : Impacts
        At least ``count`` impacts.
    kappa : (m,) float64
        Places kappa of the inertias after the first hits of chains.
    """
    from_chains = (_CHAIN_SHARE + _NEIGHBOUR_SHARE) * count
    occurring, to_change, kappa = _occurring_impacts(
        law, domain, population, shape_code, from_chains, seed, rng
    )
    moments = grain_moments(population, shape_code, to_change.grain[:, 1:])
    near = neighbouring_impacts(to_change, domain, moments, rng)
    grains = draw_grains(population, shape_code, count - math.floor(from_chains), rng)
    moments = grain_moments(population, shape_code, grains[:, 1:])
    impacts = join_impacts([occurring, near, spread_impacts(domain, grains, moments, rng)])
    index = np.arange(len(impacts.index), dtype=np.uint64)
    return impacts._replace(index=index, hit=np.ones(len(index), dtype=np.uint32)), kappa


def _occurring_impacts(
    law: DirectLaw,
    domain: LawRange,
    population: Population,
    shape_code: int,
    count: float,
    seed: Callable[[int], int],
    rng: np.random.Generator,
) -> tuple[Impacts, Impacts, FloatArray]:
    """Simulate chains with ``count`` impacts or more, and take the impacts with spin.

    Returns the impacts to fit as they are, the impacts whose neighbours are to be fitted, and the
    places kappa after the first hits of short chains.
    """
    settle = shape_code == SHAPE_CODES["ellipsoid"]
    kinds = [SHORT_CHAINS, LONG_CHAINS, *[SETTLED_CHAINS] * settle]
    weights = sum(kind.weight for kind in kinds)

    def simulate_chains(kind: Chains, first: int) -> tuple[Impacts, FloatArray]:
        size = math.ceil(kind.weight / weights * count / (kind.hits - 1) * kind.every)
        grains = draw_grains(population, shape_code, size, rng)
        if settle:
            grains = _rounder(grains, population, kind.rounder, rng)
        impacts, inertia = chain_impacts(
            law, domain, grains, kind, lambda hit: seed(first + hit), rng
        )
        moments = grain_moments(population, shape_code, grains[:, 1:])
        spins = inertia > 0.0
        kappa = kappa_from_inertia(np.where(spins, inertia, moments.largest), moments)
        return impacts, kappa[spins]

    chains, first = [], 0
    for kind in kinds:
        chains.append(simulate_chains(kind, first))
        first += kind.hits
    impacts, kappa = join_impacts([some for some, _ in chains]), chains[0][1]
    spins = (impacts.inertia > 0.0) & (np.square(impacts.spin).sum(axis=1) > 0.0)
    rows = rng.permutation(np.flatnonzero(spins))
    near = math.floor(len(rows) * _NEIGHBOUR_SHARE / (_CHAIN_SHARE + _NEIGHBOUR_SHARE))
    return impacts.select(rows[near:]), impacts.select(rows[:near]), kappa
