"""Conditions to which the spin law is fitted: impacts that occur, those beside them, the others.

A condition is complete: angle, speed, spin, the inertia about it and the grain decide the law of a
rebound, whatever happened to the grain before. So conditions may be spread as flows need them.

- Impacts that occur are those of long chains of hits, on the inside of a cylinder and on walls of
  any direction, whose speed is set back after each hit. Grains that settle into rolling do so
  within a few hundredths of a spin; which spins these are, depends on the pair and on the grain,
  and only chains find them. Half of these impacts are early ones.
- Their neighbours have other angles and spins of other sizes, as a gas leaves grains.
- All others are spread over the whole range.
"""

import math
from collections.abc import Callable
from typing import NamedTuple, Self

import numpy as np
from scipy.special import ndtri

from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from tablegen.config.config import Config
from tablegen.config.population import FixedAspect, Population
from tablegen.fitting.spin_coordinates import (
    SPIN_RANGE,
    Moments,
    inertia_at,
    kappa_at,
    kappa_of,
)
from tablegen.model.float_array import FloatArray
from tablegen.model.shapes import inertia
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import (
    Impacts,
    depart,
    energy_factor,
    first_impacts,
    joined_impacts,
    next_impacts,
    possible,
)

#: Angles [degrees] that a spin law covers, whatever a scene's first impacts are: grains leave a
#: wall at any angle, and meet the next one so.
LAW_ALPHA_DEG = (0.05, 90.0)

#: Largest V_e over the largest speed V. A particle with more is drawn at this V_e, and counted: few
#: have a spin of 2.7 V/a and more at the largest speed.
FASTEST = 2.0

#: Shares of the impacts that occur, half of them early ones, and of their neighbours.
_OCCUR, _NEIGHBOURS = 0.45, 0.2

#: Hits of early chains and of long ones, and the share of chains between walls of any direction.
_EARLY, _LONG, _ANY = 5, 40, 0.4

#: Neighbours: standard deviations of the logarithms of spin and angle, of the spin's components
#: over its size, and of kappa; a third of the spins is scaled down by up to _SLOWED.
_SPIN, _ANGLE, _TURN, _KAPPA, _SLOWED = 0.4, 0.5, 0.1, 0.05, 1e-3

#: Spread impacts: sizes of slow spins, of most and of fast ones, and the shares of the first two.
_SLOW, _MOST, _FAST, _SHARES = (1e-3, 0.1), (0.02, 2.0), (1.0, SPIN_RANGE[1]), (0.15, 0.65)

#: Shares of the impacts without spin that are crowded at the steepest angle.
_STEEP = 0.33

#: Share of the grains whose ratios are spread evenly, so that the law serves other populations, and
#: the standard deviations to either side of the mean that they cover: a fixed ratio stays fixed.
_EVEN, _DEVIATIONS = 0.5, 4.0


class Range(NamedTuple):
    """Impacts that are covered: angles [rad], speeds V and effective speeds V_e [m/s]."""

    alpha: tuple[float, float]
    speed: tuple[float, float]
    effective: tuple[float, float]

    @classmethod
    def of(cls, config: Config) -> Self:
        """Find the range that the spin law of a configuration covers."""
        first, last = min(config.domain.alpha_deg[0], LAW_ALPHA_DEG[0]), LAW_ALPHA_DEG[1]
        low, high = config.speeds
        alpha = math.radians(first), min(math.radians(last), math.pi / 2.0)
        return cls(alpha, (low, high), (low, FASTEST * high))


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


def moments_of(population: Population, shape_code: int, ratios: FloatArray) -> Moments:
    """Compute the moments of inertia of grains of a shape or mesh with ratios (n, 2)."""
    first, third = inertia_coefficients(population, shape_code)
    beta, gamma = np.square(ratios).T
    return Moments(first * (1.0 + beta), third * beta * (1.0 + gamma))


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


def grains_of(
    population: Population, shape_code: int, count: int, rng: np.random.Generator
) -> FloatArray:
    """Draw grains of a shape, (count, 3)."""
    ratios = draw_ratios(population, shape_code, count, rng)
    return np.column_stack([np.full(count, float(shape_code)), ratios])


def _speeds(low: float, high: float, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw speeds; half are uniform, half are uniform in the logarithm."""
    logarithmic = _log_uniform((low, high), count, rng)
    return np.where(rng.random(count) < 0.5, logarithmic, rng.uniform(low, high, count))


def _log_uniform(ends: tuple[float, float], count: int, rng: np.random.Generator) -> FloatArray:
    """Draw numbers that are uniform in the logarithm."""
    return np.exp(rng.uniform(math.log(ends[0]), math.log(ends[1]), count))


def _angles(domain: Range, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw angles, uniform in their square root, in their cube root, and uniform."""
    low, high = domain.alpha
    power = rng.choice([1.0, 2.0, 3.0], count, p=[0.4, 0.4, 0.2])
    root = rng.uniform(low ** (1.0 / power), high ** (1.0 / power))
    return np.clip(root**power, low, high)


def nonspinning_impacts(domain: Range, grains: FloatArray, rng: np.random.Generator) -> Impacts:
    """Draw impacts without spin of some grains (n, 3).

    Some are crowded at the steepest angle, where the law changes most within a degree.
    """
    n = len(grains)
    alpha, steep = _angles(domain, n, rng), rng.random(n) < _STEEP
    low, high = domain.alpha
    alpha[steep] = high - (high - low) * rng.random(int(steep.sum())) ** 2
    return first_impacts(
        alpha, _speeds(*domain.speed, n, rng), grains, np.arange(n, dtype=np.uint64)
    )


def chain_impacts(
    model: DirectModel,
    domain: Range,
    grains: FloatArray,
    hits: int,
    seed: Callable[[int], int],
    rng: np.random.Generator,
) -> tuple[Impacts, FloatArray]:
    """Simulate chains of hits of grains (m, 3).

    ``seed`` gives that of each hit. Returns the second to the last impacts of all chains, and the
    inertias after the first hit, (m,).
    """
    count, (least, _) = len(grains), domain.alpha
    impacts = nonspinning_impacts(domain, grains, rng)
    # half of the chains keep their speed V, and half their V_e
    speed, keeps = impacts.speed, rng.random(count) < 0.5
    any_wall = rng.random(count) < _ANY
    after_first, met = np.zeros(count), []
    for hit in range(1, hits):
        departures = depart(model, impacts, seed(hit), threads=1)
        if hit == 1:
            after_first = departures.inertia
        impacts = next_impacts(departures, any_wall, rng.random((count, 2)))
        alpha = np.maximum(impacts.alpha1, least)
        factor = energy_factor(impacts.spin, impacts.inertia)
        effective = speed * np.where(keeps, factor, 1.0)
        impacts = impacts._replace(alpha1=alpha)
        impacts = _at_speed(impacts, impacts.spin, impacts.inertia, effective, domain)
        met.append(impacts)
    return joined_impacts(met), after_first


def _at_speed(
    impacts: Impacts, spin: FloatArray, inertia: FloatArray, effective: FloatArray, domain: Range
) -> Impacts:
    """Give impacts some spins and effective speeds, as far as the law has them."""
    size = np.linalg.norm(spin, axis=1)
    spin = spin * np.minimum(1.0, SPIN_RANGE[1] / np.maximum(size, 1e-300))[:, None]
    factor = energy_factor(spin, inertia)
    speed = np.minimum(np.minimum(effective, domain.effective[1]) / factor, domain.speed[1])
    return possible(impacts._replace(spin=spin, inertia=inertia, speed=speed))


def neighbours(
    impacts: Impacts, domain: Range, moments: Moments, rng: np.random.Generator
) -> Impacts:
    """Change impacts a little, and the sizes of their spins by more, as a gas does."""
    n, (least, most) = len(impacts.index), domain.alpha
    size = np.linalg.norm(impacts.spin, axis=1)[:, None]
    slower = np.where(rng.random(n) < 1.0 / 3.0, _log_uniform((_SLOWED, 1.0), n, rng), 1.0)
    spin = impacts.spin + _TURN * size * rng.standard_normal((n, 3))
    spin *= (slower * np.exp(_SPIN * rng.standard_normal(n)))[:, None]
    alpha = np.clip(impacts.alpha1 * np.exp(_ANGLE * rng.standard_normal(n)), least, most)
    kappa = kappa_of(impacts.inertia, moments) + _KAPPA * rng.standard_normal(n)
    inertia = inertia_at(np.clip(kappa, 0.0, 1.0), moments)
    effective = _speeds(*domain.effective, n, rng)
    return _at_speed(impacts._replace(alpha1=alpha), spin, inertia, effective, domain)


def spread_impacts(
    domain: Range, grains: FloatArray, moments: Moments, rng: np.random.Generator
) -> Impacts:
    """Spread impacts of grains (n, 3) over the whole domain.

    Half of the spins have any direction; half lie about that of rolling. Half of the inertias are
    uniform in kappa, and half are those of any direction of the spin in the grain.
    """
    n = len(grains)
    slow, fast = (_log_uniform(ends, n, rng) for ends in (_SLOW, _FAST))
    which = rng.random(n)
    size = np.where(which < _SHARES[0], slow, rng.uniform(*_MOST, n))
    size = np.where(which < sum(_SHARES), size, fast)
    direction = _unit(rng.standard_normal((n, 3)))
    rolling = _unit(0.5 * direction * [1.0, 1.0, 2.0] - [0.0, 0.0, 1.2])
    direction = np.where((rng.random(n) < 0.5)[:, None], rolling, direction)
    cosine = rng.random(n)  # of the angle between the spin and the grain's shortest axis
    kappa = np.where(rng.random(n) < 0.5, rng.random(n), kappa_at(cosine**2))
    impacts = first_impacts(_angles(domain, n, rng), np.ones(n), grains, np.arange(n, dtype="u8"))
    inertia = inertia_at(kappa, moments)
    effective = _speeds(*domain.effective, n, rng)
    return _at_speed(impacts, size[:, None] * direction, inertia, effective, domain)


def _unit(vectors: FloatArray) -> FloatArray:
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def spinning_impacts(
    model: DirectModel,
    domain: Range,
    population: Population,
    shape_code: int,
    count: int,
    seed: Callable[[int], int],
    rng: np.random.Generator,
) -> tuple[Impacts, FloatArray]:
    """Draw at least ``count`` impacts with spin, and kappas after first hits."""
    wanted = (_OCCUR + _NEIGHBOURS) * count
    kept, changed, kappa = _occurring(model, domain, population, shape_code, wanted, seed, rng)
    moments = moments_of(population, shape_code, changed.grain[:, 1:])
    changed = neighbours(changed, domain, moments, rng)
    grains = grains_of(population, shape_code, count - math.floor(wanted), rng)
    moments = moments_of(population, shape_code, grains[:, 1:])
    impacts = joined_impacts([kept, changed, spread_impacts(domain, grains, moments, rng)])
    index = np.arange(len(impacts.index), dtype=np.uint64)
    return impacts._replace(index=index, hit=np.ones(len(index), dtype=np.uint32)), kappa


def _occurring(
    model: DirectModel,
    domain: Range,
    population: Population,
    shape_code: int,
    count: float,
    seed: Callable[[int], int],
    rng: np.random.Generator,
) -> tuple[Impacts, Impacts, FloatArray]:
    """Simulate chains with ``count`` impacts or more, and take those with spin.

    Returns impacts that stay, others that become neighbours, and kappas after first hits.
    """

    def chains(wanted: float, hits: int, first: int) -> tuple[Impacts, FloatArray]:
        grains = grains_of(population, shape_code, math.ceil(wanted / (hits - 1)), rng)
        met, inertia = chain_impacts(
            model, domain, grains, hits, lambda hit: seed(first + hit), rng
        )
        moments = moments_of(population, shape_code, grains[:, 1:])
        known = inertia > 0.0
        return met, kappa_of(np.where(known, inertia, moments.largest), moments)[known]

    early, kappa = chains(0.5 * count, _EARLY, 0)
    late, _ = chains(0.5 * count, _LONG, _EARLY)
    both = joined_impacts([early, late])
    spins = (both.inertia > 0.0) & (np.square(both.spin).sum(axis=1) > 0.0)
    rows = rng.permutation(np.flatnonzero(spins))
    near = math.floor(len(rows) * _NEIGHBOURS / (_OCCUR + _NEIGHBOURS))
    return both.of(rows[near:]), both.of(rows[:near]), kappa
