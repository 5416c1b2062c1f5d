"""Random particles: shape, aspect ratios and orientation from counter-based random numbers.

A particle is a pure function of (seed, stream, index): block 0 of its counter gives b/a, c/b and
two orientation numbers, block 1 the third orientation number and the shape. `draw_particle` draws
one, `draw_particles` a run of them, some at a time in lanes (see `tablegen.model.simd`), with the
same bits.
"""

import numpy as np

from sampler.compilation.jit import kernel, no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.normal import central_ratio, normal_quantile
from sampler.drawing.philox import philox_block, uniform
from tablegen.model.rotation import set_orientation
from tablegen.model.shapes import FIRST_MESH, SPHERE
from tablegen.model.simd import (
    WIDTH,
    any_lane,
    extract,
    insert,
    lane_array,
    load,
    store,
    width,
)

#: Keeps the direct simulation and the table draws of one seed on different random numbers.
SIMULATION_KEY = np.uint64(0x5349_4D55_4C41_5445)


@no_refcount_inline_kernel
def pick_shape(population, u):
    """Shape code for a uniform number u in (0, 1); meshes have FIRST_MESH and what follows."""
    last = population.shape_codes.size - 1
    for i in range(last):
        if u < population.cumulative_weights[i]:
            return population.shape_codes[i]
    return population.shape_codes[last]


@kernel
def quantile(p):
    """Evaluate the standard normal quantile of p in (0, 1), its tails lane by lane."""
    q = p - 0.5
    value = q * central_ratio(0.180625 - q * q)
    outer = abs(q) > 0.425
    if any_lane(outer):
        for i in range(width(p)):
            if extract(outer, i):
                value = insert(value, i, normal_quantile(extract(p, i)))
    return value


@no_refcount_inline_kernel
def aspect_ratio(law, u):
    """Truncated-normal aspect ratio for u in (0, 1).

    ``law`` holds mean, standard deviation and the normal probabilities of the two cuts; a
    fixed ratio has standard deviation zero.
    """
    mean, deviation, low, high = law[0], law[1], law[2], law[3]
    if deviation == 0.0:
        return mean + 0.0 * u
    return mean + deviation * quantile(low + u * (high - low))


@no_refcount_inline_kernel
def _words(seed, stream, index):
    """Uniform numbers of a particle: two aspect ratios, three of the orientation, the shape."""
    key = np.uint64(seed) ^ SIMULATION_KEY
    w0, w1, w2, w3 = philox_block(key, np.uint64(index), np.uint32(stream), np.uint32(0))
    v0, v1, _, _ = philox_block(key, np.uint64(index), np.uint32(stream), np.uint32(1))
    return uniform(w0), uniform(w1), uniform(w2), uniform(w3), uniform(v0), uniform(v1)


@no_refcount_inline_kernel
def _own_sizes(population, shape, b_over_a, c_over_b):
    """Aspect ratios of a particle, which a sphere and a mesh do not draw."""
    if shape == SPHERE:
        return 1.0, 1.0
    if shape >= FIRST_MESH:
        mesh = shape - FIRST_MESH
        b, c = population.meshes.sizes[mesh, 0], population.meshes.sizes[mesh, 1]
        return b, c / b
    return b_over_a, c_over_b


@no_refcount_kernel
def draw_particle(population, seed, stream, index, motion):
    """Draw a particle and put its orientation into ``motion``.

    Parameters
    ----------
    population : PopulationArguments
    seed : uint64
    stream : uint32
    index : uint64
    motion : (13,) float64
        Rows 3:9 are written.

    Returns
    -------
    tuple (shape code, b / a, c / b)
        Mesh number k of the population has the code FIRST_MESH + k, and half-sizes of its own.
    """
    u = _words(seed, stream, index)
    set_orientation(u[2], u[3], u[4], motion)
    shape = pick_shape(population, u[5])
    b_over_a = aspect_ratio(population.aspect[0], u[0])
    c_over_b = aspect_ratio(population.aspect[1], u[1])
    b_over_a, c_over_b = _own_sizes(population, shape, b_over_a, c_over_b)
    return shape, b_over_a, c_over_b


@kernel
def draw_particles(population, keys, first, axes, kind):
    """Draw the particles ``first``, ``first + 1``, ...

    Parameters
    ----------
    population : PopulationArguments
    keys : tuple (uint64, uint32)
        Seed and stream.
    first : int
    axes : (n, 6) float64
        Output: wall axes n and x in body axes.
    kind : (n, 3) float64
        Output: shape code, b / a, c / b.
    """
    seed, stream = keys
    words, motion, ratio = lane_array(6), lane_array(9), lane_array(2)
    for start in range(0, axes.shape[0], WIDTH):
        for i in range(WIDTH):
            u = _words(seed, stream, first + start + i)
            for k in range(6):
                words[k, i] = u[k]
        set_orientation(load(words, 2), load(words, 3), load(words, 4), motion)
        store(ratio, 0, aspect_ratio(population.aspect[0], load(words, 0)))
        store(ratio, 1, aspect_ratio(population.aspect[1], load(words, 1)))
        for i in range(min(WIDTH, axes.shape[0] - start)):
            shape = pick_shape(population, words[5, i])
            b_over_a, c_over_b = _own_sizes(population, shape, ratio[0, i], ratio[1, i])
            kind[start + i, 0], kind[start + i, 1], kind[start + i, 2] = shape, b_over_a, c_over_b
            for k in range(6):
                axes[start + i, k] = motion[3 + k, i]
