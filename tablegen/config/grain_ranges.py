"""Ranges of the ratios and of the moments of inertia of the grains of a population."""

import numpy as np

from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from tablegen.config.population import FixedAspect, Population
from tablegen.model.float_array import FloatArray
from tablegen.model.shapes import inertia


def ratio_range(population: Population, shape_code: int) -> FloatArray:
    """Find the least and the largest b/a and c/b of the grains of a shape or mesh, (2, 2)."""
    if shape_code >= FIRST_MESH:
        b, c = population.mesh_particle(shape_code).ordered_sizes()
        return np.array([[b, b], [c / b, c / b]])
    aspect = population.aspect
    if shape_code == SHAPE_CODES["sphere"] or aspect is None:
        return np.ones((2, 2))
    if isinstance(aspect, FixedAspect):
        return np.array([[value, value] for value in aspect.values])
    return np.array([aspect.range, aspect.range])


def inertia_coefficients(population: Population, shape_code: int) -> tuple[float, float]:
    """Find the coefficients g_1 and g_3 of the moments of inertia of a shape or mesh.

    A grain with the ratios beta = b/a and gamma = c/b has the largest moment of inertia
    g_1 (1 + beta^2) m a^2, and the smallest one g_3 beta^2 (1 + gamma^2) m a^2.
    """
    if shape_code < FIRST_MESH:
        largest = float(inertia(shape_code, 1.0, 1.0, population.truncation)[2])
        return 0.5 * largest, 0.5 * largest
    particle = population.mesh_particle(shape_code)
    b, c = particle.ordered_sizes()
    least, _, largest = particle.moments.tolist()
    return largest / (1.0 + b * b), least / (b * b + c * c)


def least_inertia(population: Population) -> float:
    """Find the smallest moment of inertia that a grain of a population may have, over m a^2."""
    moments = []
    for code in population.shape_codes:
        (b, _), (c, _) = ratio_range(population, code)
        moments.append(inertia_coefficients(population, code)[1] * b * b * (1.0 + c * c))
    return float(min(moments))
