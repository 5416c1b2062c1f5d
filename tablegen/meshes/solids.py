"""Convex solids of uniform density: true vertices, volume, centre of mass, principal axes.

A solid is the convex hull of points, cut into tetrahedra with one corner at an inner point and the
triangles of the hull as opposite faces. See B. Mirtich, "Fast and accurate computation of
polyhedral mass properties", J. Graphics Tools 1 (1996).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from tablegen.model.float_array import FloatArray

#: Least thickness of a solid over its largest extent; below it a solid counts as flat.
THINNEST = 1e-6

#: Vertices closer than this, over the largest extent, are one. Well above the contact heights
#: (`tablegen.model.contact`), so that vertices that touch together always share a face.
SHORTEST = 1e-6

#: Least narrow width of a vertex's normal cone [rad]. Less is a point on an edge or in a face that
#: rounding lifted off it.
_BLUNTEST = 1e-6

#: Difference of equal moments of <x x^T>, over its trace: files often hold single precision.
EQUAL = 1e-6

#: Directions whose widths are computed at a time (bounds the memory).
_AT_A_TIME = 1_000


class FlatError(ValueError):
    """Points that span no volume."""


@dataclass(frozen=True, eq=False)
class Mass:
    """Integrals over a solid of unit density."""

    volume: float
    #: Centre of mass (3,).
    centre: FloatArray
    #: <x x^T> (3, 3), about the centre of mass and per unit volume.
    second: FloatArray


def true_vertices(points: FloatArray) -> NDArray[np.intp]:
    """Find the points (n, 3) that are corners of the convex hull of all: increasing indices.

    Points on its edges and in its faces are not corners, and of points closer than `SHORTEST` one
    stays. Raises `FlatError` if the points lie closer to a plane than `THINNEST`.
    """
    size = np.ptp(points, axis=0).max() if len(points) else 0.0
    if not size > 0.0:
        raise FlatError
    scaled = (points - points.mean(axis=0)) / size
    twins = cKDTree(scaled).query_pairs(SHORTEST, output_type="ndarray")
    kept = np.setdiff1d(np.arange(len(points)), twins[:, 1])
    while True:
        if len(kept) < 4 or _thickness(scaled[kept]) < THINNEST:
            raise FlatError
        try:
            hull = ConvexHull(scaled[kept])
        except QhullError as error:
            raise FlatError from error
        corners = np.sort(hull.vertices[_cone_width(hull) > _BLUNTEST])
        if len(corners) == len(kept):
            return kept
        kept = kept[corners]


def mass_of(hull: ConvexHull) -> Mass:
    """Compute volume, centre of mass and second moments of a convex solid.

    With s the sum of the corners T (rows) of a tetrahedron whose fourth corner is the origin, its
    means are <x> = s / 4 and <x x^T> = (T^T T + s s^T) / 20.
    """
    inside = hull.points[hull.vertices].mean(axis=0)
    corners = (hull.points - inside)[hull.simplices]
    volumes = np.abs(np.linalg.det(corners)) / 6.0
    volume = volumes.sum()
    sums = corners.sum(axis=1)
    centre = volumes @ sums / (4.0 * volume)
    second = np.einsum("t,tki,tkj->ij", volumes, corners, corners)
    second += np.einsum("t,ti,tj->ij", volumes, sums, sums)
    second = second / (20.0 * volume) - np.outer(centre, centre)
    return Mass(float(volume), centre + inside, second)


def principal_axes(hull: ConvexHull, mass: Mass) -> FloatArray:
    """Find the principal axes: (3, 3), unit vectors in rows, least moment first, right-handed.

    Where moments are equal, as for a cube, the narrowest of the directions to the solid's vertices,
    edge centres and face normals is an axis, and the wider of the axes goes first. So the axes of a
    box, and of a tetrahedron in it, are those of the box.
    """
    moments, vectors = np.linalg.eigh(mass.second)
    moments, basis = moments[::-1], vectors.T[::-1].copy()
    points = hull.points - mass.centre
    apart = -np.diff(moments) > EQUAL * moments.sum()
    for group in np.split(np.arange(3), np.flatnonzero(apart) + 1):
        if len(group) > 1:
            axes = _narrowest_axes(basis[group], points, _features(hull, points))
            widths = np.ptp(points @ axes.T, axis=0)
            basis[group] = axes[np.argsort(-widths, kind="stable")]
    basis[2] = np.cross(basis[0], basis[1])
    return basis


def _thickness(points: FloatArray) -> float:
    """Compute the extent of the points along the direction in which they spread least."""
    centred = points - points.mean(axis=0)
    thinnest = np.linalg.svd(centred, full_matrices=False)[2][2]
    return float(np.ptp(centred @ thinnest))


def _cone_width(hull: ConvexHull) -> FloatArray:
    """Estimate the narrow width [rad] of the normal cone of each vertex.

    It is the least singular value of the matrix of the normals around the vertex, and zero for a
    point in the middle of a face or an edge.
    """
    normals = hull.equations[:, :3]
    products = normals[:, :, np.newaxis] * normals[:, np.newaxis, :]
    gram = np.zeros((len(hull.points), 3, 3))
    for corners in hull.simplices.T:
        np.add.at(gram, corners, products)
    least = np.linalg.eigvalsh(gram[hull.vertices])[:, 0]
    return np.sqrt(np.maximum(least, 0.0))


def _features(hull: ConvexHull, points: FloatArray) -> FloatArray:
    """Return directions from the centre to vertices and edge centres, and face normals: (k, 3)."""
    edges = np.concatenate([np.delete(hull.simplices, k, axis=1) for k in range(3)])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    return np.concatenate([hull.equations[:, :3], points[edges].mean(axis=1), points])


def _narrowest_axes(basis: FloatArray, points: FloatArray, features: FloatArray) -> FloatArray:
    """Choose perpendicular axes (g, 3) in the space of a basis (g, 3), each the narrowest left.

    `features` (k, 3) are the directions to choose from.
    """
    axes: list[FloatArray] = []
    while len(basis) > 1:
        inside = features @ basis.T
        length = np.linalg.norm(inside, axis=1)
        # a feature nearly perpendicular to the space has a direction in it by rounding only
        keep = length > 0.01 * np.linalg.norm(features, axis=1)
        choice = inside[keep] / length[keep, np.newaxis]
        widths = [
            np.ptp((points @ basis.T) @ choice[i : i + _AT_A_TIME].T, axis=0)
            for i in range(0, len(choice), _AT_A_TIME)
        ]
        best = choice[np.argmin(np.concatenate(widths))]
        axes.append(best @ basis)
        # the rest of the space: the right singular vectors perpendicular to the choice
        basis = np.linalg.svd(best[np.newaxis])[2][1:] @ basis
    return np.array([*axes, basis[0]])
