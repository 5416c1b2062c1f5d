"""Particle shapes: vertices, moments of inertia, support.

Half-sizes are a >= b >= c along the principal axes and a = 1 is the unit of length. A shape is
either an ellipsoid (the sphere included) or a convex polyhedron given by its vertices.
"""

import math
from typing import NamedTuple

import numpy as np

from sampler.jit import inline_kernel, kernel

ELLIPSOID, PRISM, TRUNCATED_PRISM, TETRAHEDRON, SPHERE = 0, 1, 2, 3, 4

#: Most vertices that a shape of this module has.
MAX_VERTICES = 24


class Body(NamedTuple):
    """What the mechanics knows of a particle.

    ``moments`` are the principal moments of inertia per unit mass (j1 <= j2 <= j3), ``vertices``
    the (m, 3) vertices of a polyhedron, none (m = 0) for an ellipsoid of semi-axes (1, b, c), and
    ``reach`` is the largest distance of a surface point from the centre.
    """

    moments: tuple[float, float, float]
    vertices: np.ndarray
    b: float
    c: float
    reach: float


@inline_kernel
def _truncated_moment(truncation):
    """<x^2> / a^2 of a prism whose corners are cut at a fraction f of each half-edge."""
    f = truncation
    m2 = (3.0 + (1.0 - f) ** 2 + (4.0 - f) ** 2) / 20.0
    return (1.0 / 3.0 - f**3 * m2 / 6.0) / (1.0 - f**3 / 6.0)


@kernel
def inertia(shape, b, c, truncation):
    """Principal moments of inertia per unit mass for half-sizes (1, b, c).

    Returns
    -------
    tuple of three floats
    """
    if shape == PRISM:
        q = 1.0 / 3.0
    elif shape == TRUNCATED_PRISM:
        q = _truncated_moment(truncation)
    else:
        q = 0.2
    return q * (b * b + c * c), q * (1.0 + c * c), q * (1.0 + b * b)


@kernel
def fill_vertices(shape, b, c, truncation, vertices):
    """Write the vertices of a polyhedron into ``vertices`` (>= 24, 3); return their number.

    An ellipsoid or sphere has none and returns 0.
    """
    if shape in (ELLIPSOID, SPHERE):
        return 0
    n = 0
    for corner in range(8):
        sx = 1.0 - 2.0 * (corner & 1)
        sy = 1.0 - (corner & 2)
        sz = 1.0 - 0.5 * (corner & 4)
        if shape == TETRAHEDRON:
            # every second corner of the box; this choice fixes the handedness
            if sx * sy * sz > 0.0:
                vertices[n, 0], vertices[n, 1], vertices[n, 2] = sx, sy * b, sz * c
                n += 1
        elif shape == PRISM:
            vertices[n, 0], vertices[n, 1], vertices[n, 2] = sx, sy * b, sz * c
            n += 1
        else:
            for axis in range(3):
                vertices[n, 0], vertices[n, 1], vertices[n, 2] = sx, sy * b, sz * c
                vertices[n, axis] *= 1.0 - truncation
                n += 1
    return n


@kernel
def make_body(shape, b, c, truncation, vertices):
    """Body of a shape with half-sizes (1, b, c).

    Parameters
    ----------
    shape : int
    b, c : float
    truncation : float
        Fraction of each half-edge at which a truncated prism is cut.
    vertices : (MAX_VERTICES, 3) float64
        Storage that the body refers to.

    Returns
    -------
    Body
    """
    count = fill_vertices(shape, b, c, truncation, vertices)
    reach2 = 1.0 if count == 0 else 0.0
    for i in range(count):
        reach2 = max(reach2, vertices[i, 0] ** 2 + vertices[i, 1] ** 2 + vertices[i, 2] ** 2)
    moments = inertia(shape, b, c, truncation)
    return Body(moments, vertices[:count], b, c, math.sqrt(reach2))


@kernel
def lowest_depth(body, n):
    """Support function h(-n): how far the particle reaches below its centre.

    Parameters
    ----------
    body : Body
    n : (3,) float64
        Wall normal in body axes.
    """
    vertices = body.vertices
    if vertices.shape[0] == 0:
        return math.sqrt(n[0] ** 2 + (body.b * n[1]) ** 2 + (body.c * n[2]) ** 2)
    depth = 0.0
    for i in range(vertices.shape[0]):
        depth = max(depth, -(vertices[i, 0] * n[0] + vertices[i, 1] * n[1] + vertices[i, 2] * n[2]))
    return depth
