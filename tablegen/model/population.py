"""Random particles: shape, aspect ratios and orientation from counter-based random numbers.

A particle is a pure function of (seed, stream, index): block 0 of its counter gives b/a, c/b and
two orientation numbers, block 1 the third orientation number and the shape.
"""

import numpy as np

from sampler.jit import borrowing_inline_kernel, borrowing_kernel
from sampler.normal import normal_quantile
from sampler.philox import philox_block, uniform
from tablegen.model.rotation import set_orientation
from tablegen.model.shapes import MESH, SPHERE

#: Keeps the direct simulation and the table draws of one seed on different random numbers.
SIMULATION_KEY = np.uint64(0x5349_4D55_4C41_5445)


@borrowing_inline_kernel
def pick_shape(population, u):
    """Shape code for a uniform number u in (0, 1); the meshes have MESH, MESH + 1, ..."""
    last = population.shape_codes.size - 1
    for i in range(last):
        if u < population.cumulative_weights[i]:
            return population.shape_codes[i]
    return population.shape_codes[last]


@borrowing_inline_kernel
def aspect_ratio(law, u):
    """Truncated-normal aspect ratio for u in (0, 1).

    ``law`` holds mean, standard deviation and the normal probabilities of the two cuts; a
    fixed ratio has standard deviation zero.
    """
    mean, deviation, low, high = law[0], law[1], law[2], law[3]
    if deviation == 0.0:
        return mean
    return mean + deviation * normal_quantile(low + u * (high - low))


@borrowing_kernel
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
        The code of mesh number k of the population is MESH + k, and its half-sizes are its own.
    """
    key = np.uint64(seed) ^ SIMULATION_KEY
    w0, w1, w2, w3 = philox_block(key, np.uint64(index), np.uint32(stream), np.uint32(0))
    v0, v1, _, _ = philox_block(key, np.uint64(index), np.uint32(stream), np.uint32(1))
    set_orientation(uniform(w2), uniform(w3), uniform(v0), motion)
    shape = pick_shape(population, uniform(v1))
    if shape == SPHERE:
        return shape, 1.0, 1.0
    if shape >= MESH:
        b, c = population.meshes.sizes[shape - MESH, 0], population.meshes.sizes[shape - MESH, 1]
        return shape, b, c / b
    b_over_a = aspect_ratio(population.aspect[0], uniform(w0))
    c_over_b = aspect_ratio(population.aspect[1], uniform(w1))
    return shape, b_over_a, c_over_b
