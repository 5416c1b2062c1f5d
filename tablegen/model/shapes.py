"""Particle shapes: vertices, moments of inertia, support.

Half-sizes are a >= b >= c along the principal axes and a = 1 is the unit of length. A shape is
either an ellipsoid (the sphere included) or a convex polyhedron given by its vertices. A mesh
(`tablegen.particles.mesh`) is a polyhedron too; it brings its moments with it, and a look-up that
spares most of its vertices.

A body of lanes stands for several particles of one shape, whose numbers and vertices are lanes
(see `tablegen.model.simd`).
"""

from typing import NamedTuple

import numpy as np

from sampler.compilation.jit import borrowing_inline_kernel, borrowing_kernel, inline_kernel, kernel
from tablegen.model.shape_codes import SHAPE_CODES
from tablegen.model.simd import at, fma, lane, largest, put, put_lane, root, width
from tablegen.model.support_map import NO_MAP, SupportMap, empty_map, support_range

ELLIPSOID, PRISM = SHAPE_CODES["ellipsoid"], SHAPE_CODES["prism"]
TRUNCATED_PRISM, TETRAHEDRON = SHAPE_CODES["truncated-prism"], SHAPE_CODES["tetrahedron"]
SPHERE, MESH = SHAPE_CODES["sphere"], SHAPE_CODES["mesh"]

#: Inside the kernels, mesh number k of a population is FIRST_MESH + k, above all other codes;
#: outside, all are MESH.
FIRST_MESH = 1 + max(SHAPE_CODES.values())

#: Most vertices that a shape other than a mesh has.
MAX_VERTICES = 24


class Body(NamedTuple):
    """What the mechanics knows of a particle.

    ``moments`` are the principal moments of inertia per unit mass (j1 <= j2 <= j3), ``b`` and
    ``c`` the half-sizes, ``reach`` the largest distance of a surface point from the centre.

    ``held`` (m, 3) are the vertices that may be the lowest, the first ``counts[0]`` of them, and
    then centres; none (m = 0) for an ellipsoid of semi-axes (1, b, c). Of most shapes they are
    all vertices; of a mesh those that ``near`` finds (resolution 0 for all other shapes), and
    `hold_lowest` renews them as it turns.
    """

    moments: tuple[float, float, float]
    held: np.ndarray
    counts: np.ndarray
    b: float
    c: float
    reach: float
    near: SupportMap = NO_MAP


class MeshArguments(NamedTuple):
    """The k meshes of a population one after another, for kernels.

    ``moments`` (k, 3) per unit mass in units of a^2, ``sizes`` (k, 3): half-sizes b and c, and
    the reach; the `SupportMap` of mesh i has ``resolutions[i]``, ``slack``, the entries
    ``firsts[i, 0] : firsts[i + 1, 0]`` of ``starts`` and the rows ``firsts[i, 1] :
    firsts[i + 1, 1]`` of ``points`` (., 3); its longest list has at most ``longest`` vertices.
    ``firsts`` is (k + 1, 2) int64; all lengths are in units of a.
    """

    moments: np.ndarray
    sizes: np.ndarray
    firsts: np.ndarray
    resolutions: np.ndarray
    slack: float
    longest: int
    starts: np.ndarray
    points: np.ndarray


@inline_kernel
def _truncated_moment(truncation):
    """<x^2> / a^2 of a prism whose corners are cut at a fraction f of each half-edge."""
    f = truncation
    m2 = (3.0 + (1.0 - f) ** 2 + (4.0 - f) ** 2) / 20.0
    return (1.0 / 3.0 - f**3 * m2 / 6.0) / (1.0 - f**3 / 6.0)


@inline_kernel
def has_vertices(shape):
    """Whether a shape is a polyhedron, and no ellipsoid."""
    return shape not in (ELLIPSOID, SPHERE)


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


@borrowing_inline_kernel
def _put_vertex(vertices, i, x, y, z):
    put(vertices, (i, 0), x)
    put(vertices, (i, 1), y)
    put(vertices, (i, 2), z)


@borrowing_kernel
def place_vertices(shape, b, c, truncation, vertices):
    """Write the vertices of a shape; return their number and the reach.

    An ellipsoid or sphere has none.

    Parameters
    ----------
    shape : int
        Not a mesh.
    b, c : float
        Half-sizes.
    truncation : float
        Fraction of each half-edge at which a truncated prism is cut.
    vertices : (>= 24, 3) float64
        Output.

    Returns
    -------
    tuple (int, float)
    """
    if not has_vertices(shape):
        return 0, 1.0 + 0.0 * b
    n = 0
    cut = 1.0 - truncation
    for corner in range(8):
        x = 1.0 - 2.0 * (corner & 1)
        y = b * (1.0 - (corner & 2))
        z = c * (1.0 - 0.5 * (corner & 4))
        if shape == TRUNCATED_PRISM:
            _put_vertex(vertices, n, x * cut, y, z)
            _put_vertex(vertices, n + 1, x, y * cut, z)
            _put_vertex(vertices, n + 2, x, y, z * cut)
            n += 3
        # a tetrahedron has every second corner of the box; this choice fixes its handedness
        elif shape == PRISM or corner in (0, 3, 5, 6):
            _put_vertex(vertices, n, x, y, z)
            n += 1
    longest = 0.0
    for i in range(n):
        x, y, z = at(vertices, (i, 0)), at(vertices, (i, 1)), at(vertices, (i, 2))
        longest = largest(longest, x * x + y * y + z * z)
    return n, root(longest)


@borrowing_inline_kernel
def shaped_body(shape, b, c, truncation, vertices, counts, no_map):
    """Body of a shape other than a mesh; as `make_body`, with an empty map to refer to.

    It counts no references: for borrowing kernels only, whose caller keeps the arrays.
    """
    counts[0], reach = place_vertices(shape, b, c, truncation, vertices)
    moments = inertia(shape, b, c, truncation)
    return Body(moments, vertices[: counts[0]], counts, b, c, reach, no_map)


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
    count, reach = place_vertices(shape, b, c, truncation, vertices)
    moments = inertia(shape, b, c, truncation)
    counts = np.full(1, count)
    return Body(moments, vertices[:count], counts, b, c, reach, empty_map())


@borrowing_inline_kernel
def mesh_map(meshes, i):
    """Look-up of the mesh number ``i`` of a population.

    It counts no references: for borrowing kernels only, whose caller keeps the arrays.

    Parameters
    ----------
    meshes : MeshArguments
    i : int

    Returns
    -------
    SupportMap
    """
    first, end = meshes.firsts[i], meshes.firsts[i + 1]
    return SupportMap(
        meshes.resolutions[i],
        meshes.slack,
        meshes.starts[first[0] : end[0]],
        meshes.points[first[1] : end[1]],
    )


@borrowing_inline_kernel
def mesh_body(meshes, i, held, counts, near):
    """Body of the mesh number ``i`` of a population, which holds no vertices yet.

    It counts no references: for borrowing kernels only, whose caller keeps the arrays.

    Parameters
    ----------
    meshes : MeshArguments
    i : int
    held : (meshes.longest, 3) float64
    counts : (1,) int64
    near : SupportMap
        From `mesh_map`.

    Returns
    -------
    Body
    """
    moments = (meshes.moments[i, 0], meshes.moments[i, 1], meshes.moments[i, 2])
    b, c, reach = meshes.sizes[i, 0], meshes.sizes[i, 1], meshes.sizes[i, 2]
    for k in range(held.shape[0]):
        held[k, 0] = held[k, 1] = held[k, 2] = 0.0
    counts[0] = 0
    return Body(moments, held, counts, b, c, reach, near)


@borrowing_inline_kernel
def most_held(counts):
    """Vertices to look at, in the lane that has the most."""
    most = counts[0]
    for i in range(1, counts.shape[0]):
        most = max(most, counts[i])
    return most


@borrowing_kernel
def hold_lowest(body, n1, n2, n3, where):
    """Hold the vertices of a mesh that may be the lowest, and centres in the rows after them.

    They stay complete while the wall normal turns by ``body.near.slack``. Other shapes hold all
    their vertices always.

    Parameters
    ----------
    body : Body
    n1, n2, n3 : float
        Wall normal in body axes.
    where : bool
        Lanes to do it for.
    """
    if body.near.resolution == 0:
        return
    points = body.near.points
    for seat in range(width(n1)):
        if not lane(where, seat):
            continue
        first, end = support_range(body.near, -lane(n1, seat), -lane(n2, seat), -lane(n3, seat))
        for i in range(first, end):
            for k in range(3):
                put_lane(body.held, (i - first, k), seat, points[i, k])
        for i in range(end - first, body.counts[seat]):
            for k in range(3):
                put_lane(body.held, (i, k), seat, 0.0)
        body.counts[seat] = end - first


@borrowing_kernel
def support_depth(body, n1, n2, n3):
    """Support function h(-n): how far the particle reaches below its centre.

    Parameters
    ----------
    body : Body
    n1, n2, n3 : float
        Wall normal in body axes.
    """
    if body.held.shape[0] == 0:
        m2, m3 = body.b * n2, body.c * n3
        return root(n1 * n1 + m2 * m2 + m3 * m3)
    hold_lowest(body, n1, n2, n3, n1 == n1)
    depth = 0.0
    for i in range(most_held(body.counts)):
        p1, p2, p3 = at(body.held, (i, 0)), at(body.held, (i, 1)), at(body.held, (i, 2))
        low = fma(p3, n3, fma(p2, n2, p1 * n1))
        depth = largest(depth, -low)
    return depth


@borrowing_kernel
def lowest_depth(body, n):
    """Support function h(-n) for the wall normal ``n`` (3,) in body axes."""
    return support_depth(body, n[0], n[1], n[2])
