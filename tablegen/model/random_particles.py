"""Random particles: shape, aspect ratios and orientation from counter-based random numbers.

A particle is a pure function of (seed, index, hit). Block 0 of its random words gives b/a, c/b and
two numbers of the orientation; block 1 gives the third number of the orientation and the shape. If
the grain tumbles, the three numbers are its phases (`tablegen.model.tumbling`), otherwise they give
a uniform orientation (`tablegen.model.rotation.set_orientation`). Shape and ratios may come from
another hit: a particle that keeps its grain has those of hit 0 at every wall.

The ratios are dimensionless; moments of inertia are over m a^2. One particle and several in lanes
have the same bits. Source of the truncated normal ratios: Panfilov & Tsirkunov 2022.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tablegen.model.frames import item
from tablegen.model.impacts import INERTIA
from tablegen.model.jit import kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.model_bounds import ASPECT
from tablegen.model.random_numbers import (
    MIDDLE,
    central_ratio,
    normal_quantile,
    philox_block,
    uniform,
)
from tablegen.model.rotation import set_orientation
from tablegen.model.shapes import FIRST_MESH, N_SHAPES, SPHERE, inertia
from tablegen.model.simd import (
    WIDTH,
    any_lane,
    extract,
    insert,
    lane_array,
    load,
    maximum,
    minimum,
    store,
    width,
)
from tablegen.model.tumbling import axes_of_tumbling, is_round

#: Combined with the seed, so that direct simulation uses other random numbers than a table's draw.
SIMULATION_KEY = np.uint64(0x5349_4D55_4C41_5445)

#: Share by which an inertia may exceed the moments of a grain, by rounding to single precision.
ROUNDING = 1e-6

#: The hit whose random numbers make the grain that a particle keeps.
OWN_GRAIN = np.uint32(0)

#: Bounds of the ratios as plain numbers, which kernels take.
_LEAST, _MOST = ASPECT.low, ASPECT.high


@kernel
def quantile_of_lanes(p):
    """Compute the standard normal quantile of p in (0, 1), the tails lane by lane."""
    q = p - 0.5
    value = q * central_ratio(0.180625 - q * q)
    outer = abs(q) > MIDDLE
    if any_lane(outer):
        for i in range(width(p)):
            if extract(outer, i):
                value = insert(value, i, normal_quantile(extract(p, i)))
    return value


@no_refcount_inline_kernel
def aspect_ratio(law, row, u):
    """Compute a truncated normal ratio from u in (0, 1) and a row of ``aspect``."""
    mean, deviation, low, high = law[row, 0], law[row, 1], law[row, 2], law[row, 3]
    if deviation == 0.0:
        ratios = mean + 0.0 * u
    else:
        ratios = mean + deviation * quantile_of_lanes(low + u * (high - low))
    return minimum(_MOST, maximum(_LEAST, ratios))


@no_refcount_inline_kernel
def _pick_row(population, u):
    """Choose a row of the shapes of a population by a uniform number u in (0, 1)."""
    row = 0
    for k in range(population.shape_codes.size - 1):
        row += int(u >= population.cumulative_weights[np.uint64(k)])
    return row


@no_refcount_inline_kernel
def _uniforms(seed, index, hit, grain):
    """Draw six uniform numbers: two of the ratios, three of the orientation, one of the shape.

    The orientation belongs to ``hit``, ratios and shape to the hit ``grain``.
    """
    key, index = np.uint64(seed) ^ SIMULATION_KEY, np.uint64(index)
    b_over_a, c_over_b, u, v = philox_block(key, index, np.uint32(hit), np.uint32(0))
    w, shape, _, _ = philox_block(key, index, np.uint32(hit), np.uint32(1))
    if grain != hit:
        b_over_a, c_over_b, _, _ = philox_block(key, index, np.uint32(grain), np.uint32(0))
        _, shape, _, _ = philox_block(key, index, np.uint32(grain), np.uint32(1))
    sizes = uniform(b_over_a), uniform(c_over_b)
    return *sizes, uniform(u), uniform(v), uniform(w), uniform(shape)


@no_refcount_inline_kernel
def _own_sizes(population, shape, b_over_a, c_over_b):
    """Return the ratios of a particle: its own for a sphere or mesh, otherwise the drawn ones."""
    if shape == SPHERE:
        return 1.0, 1.0
    if shape >= FIRST_MESH:
        mesh = shape - FIRST_MESH
        b, c = population.meshes.sizes[mesh, 0], population.meshes.sizes[mesh, 1]
        return b, c / b
    return b_over_a, c_over_b


@no_refcount_kernel
def draw_grain(population, seed, index, hit):
    """Draw a grain: shape code, b / a and c / b, as floats.

    A particle that keeps its grain has that of hit 0. Mesh number k of the population has the code
    FIRST_MESH + k, and its own half-sizes.
    """
    first, second, _, _, _, which = _uniforms(seed, index, hit, hit)
    shape = population.shape_codes[_pick_row(population, which)]
    ratios = aspect_ratio(population.aspect, 0, first), aspect_ratio(population.aspect, 1, second)
    b_over_a, c_over_b = _own_sizes(population, shape, *ratios)
    return float(shape), b_over_a, c_over_b


@no_refcount_inline_kernel
def _grain_fits(population, shape, b_over_a, c_over_b):
    """Tell whether a shape code and ratios describe a grain; a mesh has its own half-sizes."""
    if FIRST_MESH <= shape < FIRST_MESH + population.meshes.resolutions.size:
        return shape == math.floor(shape)
    known = 0.0 <= shape < N_SHAPES and shape == math.floor(shape)
    ratios = _LEAST <= b_over_a <= _MOST and _LEAST <= c_over_b <= _MOST
    return known and ratios and (shape != SPHERE or (b_over_a == 1.0 and c_over_b == 1.0))


class ParticleKeys(NamedTuple):
    """Keys of the random numbers of n particles; arrays have n elements, or one for all.

    ``seed`` and ``particle`` (uint64) identify the particle. ``hit`` (uint32) identifies its
    rebound and decides the orientation. ``grain`` (uint32) is the hit whose random numbers give
    shape and ratios; it is empty if the grains are given.
    """

    seed: np.uint64
    particle: NDArray[np.uint64]
    hit: NDArray[np.uint32]
    grain: NDArray[np.uint32]


def keys_of_run(seed: int, stream: int, first: int, count: int) -> ParticleKeys:
    """Make the keys of the particles ``first``, ``first + 1``, ... of a stream."""
    index = np.arange(first, first + count, dtype=np.uint64)
    streams = np.array([stream], dtype=np.uint32)
    return ParticleKeys(np.uint64(seed), index, streams, streams)


@no_refcount_inline_kernel
def moments_of(population, shape, b_over_a, c_over_b):
    """Compute the principal moments of inertia of a grain over m a^2, in rising order."""
    if shape >= FIRST_MESH:
        moments, mesh = population.meshes.moments, int(shape) - FIRST_MESH
        return moments[mesh, 0], moments[mesh, 1], moments[mesh, 2]
    return inertia(int(shape), b_over_a, b_over_a * c_over_b, population.truncation)


@kernel
def draw_particles(population, conditions, keys, axes, kind):
    """Draw particles: write wall axes n and x in body axes, (n, 6), and kinds, (n, 3).

    A kind is shape code, b / a, c / b. If ``keys.grain`` is empty, the kinds are given and stay.
    The orientations are those of free tumbling with the spin and the inertia of ``conditions`` (n,
    10) or (1, 10). They are uniform for particles without spin, or with an inertia that is not
    known, and for grains that are round.
    """
    given = keys.grain.size == 0
    words, motion, ratio = lane_array(6), lane_array(9), lane_array(2)
    for start in range(0, axes.shape[0], WIDTH):
        count = min(WIDTH, axes.shape[0] - start)
        for i in range(WIDTH):
            # lanes without a particle repeat the last one
            k = start + min(i, count - 1)
            hit = item(keys.hit, k)
            grain = hit if given else item(keys.grain, k)
            u = _uniforms(keys.seed, item(keys.particle, k), hit, grain)
            for j in range(6):
                words[j, i] = u[j]
        if not given:
            store(ratio, 0, aspect_ratio(population.aspect, 0, load(words, 0)))
            store(ratio, 1, aspect_ratio(population.aspect, 1, load(words, 1)))
            for i in range(count):
                shape = population.shape_codes[_pick_row(population, words[5, i])]
                ba, cb = _own_sizes(population, shape, ratio[0, i], ratio[1, i])
                kind[start + i, 0], kind[start + i, 1], kind[start + i, 2] = shape, ba, cb
        set_orientation(load(words, 2), load(words, 3), load(words, 4), motion)
        for i in range(count):
            k = start + i
            for j in range(6):
                axes[k, j] = motion[3 + j, i]
            row = k if conditions.shape[0] > 1 else 0
            known = conditions[row, INERTIA]
            spin = conditions[row, 3], conditions[row, 4], conditions[row, 5]
            if known == 0.0 or spin == (0.0, 0.0, 0.0):
                continue
            moments = moments_of(population, kind[k, 0], kind[k, 1], kind[k, 2])
            if is_round(moments):
                continue
            phases = words[2, i], words[3, i], words[4, i]
            n, x = axes_of_tumbling(moments, known, spin, phases)
            for j in range(3):
                axes[k, j], axes[k, 3 + j] = n[j], x[j]


@kernel
def first_wrong_inertia(population, kind, conditions):
    """Find the first row of ``conditions`` (n, 10) whose grain cannot have that inertia, or -1.

    ``kind`` (n, 3) are the grains. An inertia that is not known is allowed, and so is any inertia
    without spin.
    """
    for k in range(kind.shape[0]):
        known = conditions[k, INERTIA]
        still = conditions[k, 3] == 0.0 and conditions[k, 4] == 0.0 and conditions[k, 5] == 0.0
        if known == 0.0 or still:
            continue
        moments = moments_of(population, kind[k, 0], kind[k, 1], kind[k, 2])
        least, most = moments[0] * (1.0 - ROUNDING), moments[2] * (1.0 + ROUNDING)
        if not least <= known <= most:
            return k
    return -1


@kernel
def draw_grains(population, seed, index, hit, kind):
    """Draw the grains of particles ``index`` at ``hit``, (n,) or (1,), into ``kind`` (n, 3)."""
    for k in range(kind.shape[0]):
        grain = draw_grain(population, seed, item(index, k), item(hit, k))
        kind[k, 0], kind[k, 1], kind[k, 2] = grain


@no_refcount_kernel
def first_wrong_grain(population, kind):
    """Find the first row of ``kind`` (n, 3) that is no grain of the population, or -1."""
    for k in range(kind.shape[0]):
        if not _grain_fits(population, kind[k, 0], kind[k, 1], kind[k, 2]):
            return k
    return -1
