"""Particle shapes: vertices, moments of inertia, and the lowest point of a body.

Half-sizes are a >= b >= c along the principal axes, and a = 1 is the unit of length. A shape is
either an ellipsoid (spheres included) or a convex polyhedron given by its vertices. With the second
moments q = <x^2> / a^2 = <y^2> / b^2 = <z^2> / c^2, which are 1/5 for ellipsoids and tetrahedra and
1/3 for prisms, the principal moments of inertia per unit mass are

    j1 = q (b^2 + c^2),   j2 = q (1 + c^2),   j3 = q (1 + b^2).

A mesh (`tablegen.meshes`) is a polyhedron too, with its own moments and a support map, which
lists for each direction the few vertices that can lie farthest along it. Directions are sorted into
the cells of a cube map: a cube around the origin, whose sides are divided into squares. A cell
lists every vertex that supports the body in some direction up to ``slack`` away from the cell. So
the list of a direction stays complete while the body turns by ``slack``, and a contact search over
a grain of a thousand vertices looks at about ten of them. `tablegen.meshes.support_map_builder`
makes the lists.

Units: lengths in a, mass one. Source of the shapes: Panfilov & Tsirkunov 2022; the paper does not
say where the corners of a truncated prism ("flat-topped") are cut.
"""

import math
from typing import NamedTuple

import numpy as np

from sampler.formats.shape_codes import FIRST_MESH as FIRST_MESH
from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.model.jit import (
    inline_kernel,
    kernel,
    no_refcount_inline_kernel,
    no_refcount_kernel,
)
from tablegen.model.simd import extract, fma, load, maximum, sqrt, store, store_lane, width

ELLIPSOID, PRISM = SHAPE_CODES["ellipsoid"], SHAPE_CODES["prism"]
TRUNCATED_PRISM, TETRAHEDRON = SHAPE_CODES["truncated-prism"], SHAPE_CODES["tetrahedron"]
SPHERE = SHAPE_CODES["sphere"]

#: Most vertices that a shape other than a mesh has.
MAX_VERTICES = 24


class SupportMap(NamedTuple):
    """Vertices near the lowest point, by direction.

    ``resolution`` is the number of cells along a side of the cube, 0 for a body that needs no
    map; ``slack`` [rad] is how far a direction may turn from its cell; ``points[starts[i] :
    starts[i + 1]]`` are the vertices of cell i: ``starts`` (6 resolution^2 + 1,) int64,
    ``points`` (k, 3) float64.
    """

    resolution: int
    slack: float
    starts: np.ndarray
    points: np.ndarray


def longest_list(support_map: SupportMap) -> int:
    """Count the vertices in the longest list of a map."""
    return int(np.diff(support_map.starts).max())


@no_refcount_inline_kernel
def _interval_of(along, resolution):
    """Find which of ``resolution`` equal intervals of [-1, 1] contains ``along``."""
    return min(int((along + 1.0) * 0.5 * resolution), resolution - 1)


@no_refcount_inline_kernel
def direction_cell(resolution, d1, d2, d3):
    """Find the cell of a direction (d1, d2, d3), finite and not zero, in a map.

    Cells are numbered by side (+x, -x, +y, -y, +z, -z), then along the next axis in cyclic order,
    then along the axis after that.
    """
    a1, a2, a3 = abs(d1), abs(d2), abs(d3)
    if a1 >= a2 and a1 >= a3:
        side, main, s, t = 0, d1, d2, d3
    elif a2 >= a3:
        side, main, s, t = 2, d2, d3, d1
    else:
        side, main, s, t = 4, d3, d1, d2
    if main < 0.0:
        side += 1
    scale = 1.0 / abs(main)
    row = _interval_of(s * scale, resolution)
    return (side * resolution + row) * resolution + _interval_of(t * scale, resolution)


@no_refcount_inline_kernel
def support_range(support_map, d1, d2, d3):
    """Find the rows of ``support_map.points`` to look at for a direction: the first, and the end.

    They contain the supporting vertex of every direction up to ``support_map.slack`` away. The
    direction is in body axes. For the lowest vertices it is minus the wall normal.
    """
    cell = direction_cell(support_map.resolution, d1, d2, d3)
    return support_map.starts[cell], support_map.starts[cell + 1]


class Body(NamedTuple):
    """Mechanical properties of a particle.

    ``moments`` are the principal moments of inertia per unit mass (j1 <= j2 <= j3),
    ``half`` the half-sizes of a box around the centre that holds the body, (1, b, c) of shapes,
    ``bounding_radius`` the largest distance of the surface from the centre.

    ``candidates`` (m, 3) are the vertices that may be the lowest, in the first ``counts[0]`` rows.
    The rows after them are zero, the centre of the body, which is never the lowest point. An
    ellipsoid with the half-axes (1, b, c) has no candidates (m = 0). The candidates of a mesh are
    those that its ``support_map`` lists, and `update_candidates` renews them as the mesh turns.
    Those of other shapes are all vertices, and the resolution of their ``support_map`` is 0.
    """

    moments: tuple[float, float, float]
    candidates: np.ndarray
    counts: np.ndarray
    half: tuple[float, float, float]
    bounding_radius: float
    support_map: SupportMap


class MeshArguments(NamedTuple):
    """The k meshes of a population, one after another, as kernels take them.

    ``moments`` (k, 3): principal moments of inertia per unit mass in units of a^2; ``sizes`` (k,
    3): half-sizes b and c and bounding radius; ``reach`` (k, 3): largest distances from the centre
    along the axes. All lengths are in units of a.

    The `SupportMap` of mesh i has ``resolutions[i]``, ``slack``, the entries ``firsts[i, 0] :
    firsts[i + 1, 0]`` of ``starts`` and the rows ``firsts[i, 1] : firsts[i + 1, 1]`` of ``points``
    (., 3). ``firsts`` is (k + 1, 2) int64. No list has more than ``longest`` vertices.
    """

    moments: np.ndarray
    sizes: np.ndarray
    reach: np.ndarray
    firsts: np.ndarray
    resolutions: np.ndarray
    slack: float
    longest: int
    starts: np.ndarray
    points: np.ndarray


class ShapeArguments(NamedTuple):
    """The shapes of a population as kernels take them.

    ``shape_codes`` (n,) int64, `FIRST_MESH` + k of mesh k; ``truncation``: fraction of each
    half-edge at which a truncated prism's corners are cut; ``meshes``: `MeshArguments`.
    """

    shape_codes: np.ndarray
    truncation: float
    meshes: MeshArguments


@inline_kernel
def _truncated_moment(truncation):
    """Compute <x^2> / a^2 of a prism whose corners are cut at a fraction f of each half-edge."""
    f = truncation
    m2 = (3.0 + (1.0 - f) ** 2 + (4.0 - f) ** 2) / 20.0
    return (1.0 / 3.0 - f**3 * m2 / 6.0) / (1.0 - f**3 / 6.0)


@inline_kernel
def has_vertices(shape):
    """Tell whether a shape is a polyhedron, and not an ellipsoid."""
    return shape not in (ELLIPSOID, SPHERE)


@kernel
def inertia(shape, b, c, truncation):
    """Compute the principal moments of inertia per unit mass for half-sizes (1, b, c)."""
    if shape == PRISM:
        q = 1.0 / 3.0
    elif shape == TRUNCATED_PRISM:
        q = _truncated_moment(truncation)
    else:
        q = 0.2
    return q * (b * b + c * c), q * (1.0 + c * c), q * (1.0 + b * b)


@no_refcount_inline_kernel
def _store_vertex(vertices, i, x, y, z):
    store(vertices, (i, 0), x)
    store(vertices, (i, 1), y)
    store(vertices, (i, 2), z)


@no_refcount_kernel
def place_vertices(shape, b, c, truncation, vertices):
    """Write the vertices of a shape other than a mesh; return their number and the bounding radius.

    An ellipsoid or sphere has none. ``truncation`` is the fraction of each half-edge at which a
    truncated prism is cut; ``vertices`` is (MAX_VERTICES, 3) or longer.
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
            _store_vertex(vertices, n, x * cut, y, z)
            _store_vertex(vertices, n + 1, x, y * cut, z)
            _store_vertex(vertices, n + 2, x, y, z * cut)
            n += 3
        # a tetrahedron has every second corner of the box; this choice fixes its handedness
        elif shape == PRISM or corner in (0, 3, 5, 6):
            _store_vertex(vertices, n, x, y, z)
            n += 1
    longest = 0.0
    for i in range(n):
        x, y, z = load(vertices, (i, 0)), load(vertices, (i, 1)), load(vertices, (i, 2))
        longest = maximum(longest, x * x + y * y + z * z)
    return n, sqrt(longest)


@no_refcount_inline_kernel
def population_map(population, code):
    """Make the support map of a shape of a population; it is empty but for meshes.

    Only kernels that count no references may call it. The caller keeps the arrays alive.
    """
    meshes = population.meshes
    if code < FIRST_MESH:
        return SupportMap(0, math.inf, meshes.starts[:0], meshes.points[:0])
    i = code - FIRST_MESH
    first, end = meshes.firsts[i], meshes.firsts[i + 1]
    return SupportMap(
        meshes.resolutions[i],
        meshes.slack,
        meshes.starts[first[0] : end[0]],
        meshes.points[first[1] : end[1]],
    )


@no_refcount_inline_kernel
def most_candidates(counts):
    """Count the candidate vertices of the lane that has most of them."""
    most = counts[0]
    for i in range(1, counts.shape[0]):
        most = max(most, counts[i])
    return most


@no_refcount_kernel
def update_candidates(body, n1, n2, n3, where):
    """Write the vertices of a mesh that may be the lowest, and zeros in the rows after them.

    They stay complete while the wall normal (n1, n2, n3), in body axes, turns by
    ``body.support_map.slack``. For other shapes nothing is done, because their candidates are all
    vertices. ``where`` are the lanes to update.
    """
    if body.support_map.resolution == 0:
        return
    points = body.support_map.points
    for slot in range(width(n1)):
        if not extract(where, slot):
            continue
        down = -extract(n1, slot), -extract(n2, slot), -extract(n3, slot)
        first, end = support_range(body.support_map, *down)
        for i in range(first, end):
            for k in range(3):
                store_lane(body.candidates, (i - first, k), slot, points[i, k])
        for i in range(end - first, body.counts[slot]):
            for k in range(3):
                store_lane(body.candidates, (i, k), slot, 0.0)
        body.counts[slot] = end - first


@no_refcount_kernel
def support_depth(body, n1, n2, n3):
    """Compute how far a particle reaches below its centre, the support function h(-n).

    The wall normal (n1, n2, n3) is in body axes. The depth is sqrt((a n1)^2 + (b n2)^2 + (c n3)^2)
    for an ellipsoid, and the largest -p . n over all vertices p for a polyhedron.
    """
    if body.candidates.shape[0] == 0:
        m2, m3 = body.half[1] * n2, body.half[2] * n3
        return sqrt(n1 * n1 + m2 * m2 + m3 * m3)
    update_candidates(body, n1, n2, n3, n1 == n1)
    points, depth = body.candidates, 0.0
    for i in range(most_candidates(body.counts)):
        p1, p2, p3 = load(points, (i, 0)), load(points, (i, 1)), load(points, (i, 2))
        low = fma(p3, n3, fma(p2, n2, p1 * n1))
        depth = maximum(depth, -low)
    return depth
