"""Particle shapes: vertices, moments of inertia, support.

Half-sizes are a >= b >= c along the principal axes and a = 1 is the unit of length. A shape is
either an ellipsoid (the sphere included) or a convex polyhedron given by its vertices. A mesh
(`tablegen.mesh`) is a polyhedron too; it brings its moments with it, and a look-up that spares
most of its vertices.
"""

import math
from typing import NamedTuple

import numpy as np

from sampler.jit import borrowing_inline_kernel, borrowing_kernel, inline_kernel, kernel
from tablegen.model.directions import NO_MAP, SupportMap, empty_map, support_range

ELLIPSOID, PRISM, TRUNCATED_PRISM, TETRAHEDRON, SPHERE = 0, 1, 2, 3, 4

#: Code of the first mesh of a population; its others have the codes after it.
MESH = 5

#: Most vertices that a shape other than a mesh has.
MAX_VERTICES = 24


class Body(NamedTuple):
    """What the mechanics knows of a particle.

    ``moments`` are the principal moments of inertia per unit mass (j1 <= j2 <= j3), ``vertices``
    the (m, 3) vertices of a polyhedron, none (m = 0) for an ellipsoid of semi-axes (1, b, c),
    ``reach`` is the largest distance of a surface point from the centre, and ``near`` finds the
    vertices near the lowest point of a mesh (resolution 0 for all other shapes).
    """

    moments: tuple[float, float, float]
    vertices: np.ndarray
    b: float
    c: float
    reach: float
    near: SupportMap = NO_MAP


class MeshArguments(NamedTuple):
    """The k meshes of a population one after another, for kernels.

    ``moments`` (k, 3) per unit mass in units of a^2, ``sizes`` (k, 3): half-sizes b and c, and
    the reach; mesh i has the rows ``firsts[i, 0] : firsts[i + 1, 0]`` of ``vertices`` (., 3), and
    its `SupportMap` has ``resolutions[i]``, ``slack``, the entries ``firsts[i, 1] :
    firsts[i + 1, 1]`` of ``starts`` and the rows ``firsts[i, 2] : firsts[i + 1, 2]`` of
    ``points`` (., 3). ``firsts`` is (k + 1, 3) int64; all lengths are in units of a.
    """

    moments: np.ndarray
    sizes: np.ndarray
    firsts: np.ndarray
    resolutions: np.ndarray
    slack: float
    vertices: np.ndarray
    starts: np.ndarray
    points: np.ndarray


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


@borrowing_kernel
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


@borrowing_inline_kernel
def _place_vertices(shape, b, c, truncation, vertices):
    """Write the vertices of a shape; return their number and the reach."""
    count = fill_vertices(shape, b, c, truncation, vertices)
    reach2 = 1.0 if count == 0 else 0.0
    for i in range(count):
        reach2 = max(reach2, vertices[i, 0] ** 2 + vertices[i, 1] ** 2 + vertices[i, 2] ** 2)
    return count, math.sqrt(reach2)


@borrowing_inline_kernel
def shaped_body(shape, b, c, truncation, vertices, no_map):
    """Body of a shape other than a mesh; as `make_body`, with an empty map to refer to.

    It counts no references: for borrowing kernels only, whose caller keeps the arrays.
    """
    count, reach = _place_vertices(shape, b, c, truncation, vertices)
    return Body(inertia(shape, b, c, truncation), vertices[:count], b, c, reach, no_map)


@kernel
def make_body(shape, b, c, truncation, vertices):
    """Body of a shape, other than a mesh, with half-sizes (1, b, c).

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
    count, reach = _place_vertices(shape, b, c, truncation, vertices)
    return Body(inertia(shape, b, c, truncation), vertices[:count], b, c, reach, empty_map())


@borrowing_inline_kernel
def mesh_body(meshes, i):
    """Body of the mesh number ``i`` of a population.

    It counts no references: for borrowing kernels only, whose caller keeps the arrays.

    Parameters
    ----------
    meshes : MeshArguments
    i : int

    Returns
    -------
    Body
    """
    first, end = meshes.firsts[i], meshes.firsts[i + 1]
    near = SupportMap(
        meshes.resolutions[i],
        meshes.slack,
        meshes.starts[first[1] : end[1]],
        meshes.points[first[2] : end[2]],
    )
    moments = (meshes.moments[i, 0], meshes.moments[i, 1], meshes.moments[i, 2])
    b, c, reach = meshes.sizes[i, 0], meshes.sizes[i, 1], meshes.sizes[i, 2]
    return Body(moments, meshes.vertices[first[0] : end[0]], b, c, reach, near)


@borrowing_inline_kernel
def lowest_candidates(body, n1, n2, n3):
    """Vertices of a polyhedron that may be the lowest: an array, its first and its end row.

    All of them, or those that the map of a mesh finds; these stay complete while the wall normal
    turns by ``body.near.slack``. It counts no references: for borrowing kernels only.

    Parameters
    ----------
    body : Body
    n1, n2, n3 : float
        Wall normal in body axes.

    Returns
    -------
    tuple ((m, 3) float64, int, int)
    """
    if body.near.resolution > 0:
        first, end = support_range(body.near, -n1, -n2, -n3)
        return body.near.points, first, end
    return body.vertices, 0, body.vertices.shape[0]


@borrowing_kernel
def lowest_depth(body, n):
    """Support function h(-n): how far the particle reaches below its centre.

    Parameters
    ----------
    body : Body
    n : (3,) float64
        Wall normal in body axes.
    """
    if body.vertices.shape[0] == 0:
        return math.sqrt(n[0] ** 2 + (body.b * n[1]) ** 2 + (body.c * n[2]) ** 2)
    vertices, first, end = lowest_candidates(body, n[0], n[1], n[2])
    depth = 0.0
    for i in range(first, end):
        depth = max(depth, -(vertices[i, 0] * n[0] + vertices[i, 1] * n[1] + vertices[i, 2] * n[2]))
    return depth
