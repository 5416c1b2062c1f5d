"""Shapes: vertices, moments of inertia, support function, bounding radius."""

import math

import numpy as np
import pytest
from motion_fixtures import SHAPES, TRUNCATION, body_of
from scipy.spatial import ConvexHull

from tablegen.model.shapes import support_depth

POLYHEDRA = ("prism", "truncated-prism", "tetrahedron")
#: Half-sizes b and c: cube, blunt, flat, needle, paper-thin.
SIZES = [(1.0, 1.0), (0.8, 0.64), (0.9, 0.1), (0.05, 0.04), (0.5, 0.001)]


def faces_of(vertices):
    """Number of faces of the convex hull, coplanar triangles counted once."""
    return len(np.unique(np.round(ConvexHull(vertices).equations, 9), axis=0))


def second_moments(vertices):
    """<x x^T> of a uniform convex polyhedron: exact, by tetrahedra from the centre.

    The mean of x x^T over a tetrahedron with one vertex at the origin and the others as rows of T
    is (T^T T + s s^T) / 20 with s the sum of the rows.
    """
    total, volume = np.zeros((3, 3)), 0.0
    centre = np.zeros(3)
    for triangle in ConvexHull(vertices).simplices:
        corners = vertices[triangle]
        part = abs(np.linalg.det(corners)) / 6.0
        s = corners.sum(axis=0)
        total += part * (corners.T @ corners + np.outer(s, s)) / 20.0
        centre += part * s / 4.0
        volume += part
    return total / volume, centre / volume, volume


@pytest.mark.parametrize(("b", "c"), SIZES)
@pytest.mark.parametrize(
    ("name", "truncation"),
    [
        *((name, TRUNCATION) for name in POLYHEDRA),
        *(("truncated-prism", f) for f in (0.1, 0.5, 2.0 - math.sqrt(2.0), 0.999)),
    ],
)
def test_moments_of_polyhedra_by_decomposition(name, truncation, b, c):
    body = body_of(name, b, c, truncation)
    second, centre, _ = second_moments(body.candidates)
    expected = np.trace(second) - np.diag(second)
    np.testing.assert_allclose(body.moments, expected, rtol=1e-11)
    # the half-sizes lie along the principal axes, and the centre is the centre of mass
    np.testing.assert_allclose(second, np.diag(np.diag(second)), atol=1e-14)
    np.testing.assert_allclose(centre, 0.0, atol=1e-14)


@pytest.mark.parametrize(("b", "c"), SIZES)
def test_moments_of_ellipsoids(b, c):
    # an ellipsoid is the unit ball, of which <z^2> = 1/5, stretched by (1, b, c)
    second = 0.2 * np.array([1.0, b * b, c * c])
    np.testing.assert_allclose(
        body_of("ellipsoid", b, c).moments, second.sum() - second, rtol=1e-12
    )


@pytest.mark.parametrize(("b", "c"), SIZES)
@pytest.mark.parametrize(
    ("name", "vertices", "faces"),
    [("prism", 8, 6), ("truncated-prism", 24, 14), ("tetrahedron", 4, 4)],
)
def test_polyhedra_are_convex_and_fill_their_box(name, vertices, faces, b, c):
    body = body_of(name, b, c)
    assert body.candidates.shape == (vertices, 3)
    scaled = body.candidates / [1.0, b, c]
    assert len(ConvexHull(scaled).vertices) == vertices
    assert faces_of(scaled) == faces
    np.testing.assert_array_equal(np.abs(body.candidates).max(axis=0), [1.0, b, c])
    assert np.all(np.abs(body.candidates) <= [1.0, b, c])


def directions(count, seed):
    n = np.random.default_rng(seed).normal(size=(count, 3))
    n = np.vstack([n, np.eye(3), -np.eye(3)])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


@pytest.mark.parametrize(("b", "c"), SIZES)
@pytest.mark.parametrize("name", POLYHEDRA)
def test_depth_of_polyhedra_is_that_of_the_lowest_vertex(name, b, c):
    body = body_of(name, b, c)
    for n in directions(300, 5):
        assert support_depth(body, *n) == pytest.approx(-(body.candidates @ n).min(), abs=1e-15)


@pytest.mark.parametrize(("b", "c"), SIZES)
def test_depth_of_ellipsoids_bounds_their_surface_and_is_reached(b, c):
    body = body_of("ellipsoid", b, c)
    sphere = directions(40_000, 7)
    for n in directions(60, 8):
        heights = (sphere * [1.0, b, c]) @ n
        h = support_depth(body, *n)
        assert h == pytest.approx(np.linalg.norm([n[0], b * n[1], c * n[2]]), rel=1e-15)
        # 40,000 points leave no gap wider than about 0.03 rad, a shortfall of 5e-4
        assert h * (1.0 - 1e-3) <= -heights.min() <= h * (1.0 + 1e-15)


@pytest.mark.parametrize(("b", "c"), SIZES)
@pytest.mark.parametrize("name", SHAPES)
def test_bounding_radius_is_the_largest_depth(name, b, c):
    body = body_of(name, b, c)
    n = np.vstack([directions(300, 9), -body.candidates / body.bounding_radius])
    depths = [support_depth(body, *(direction / np.linalg.norm(direction))) for direction in n]
    assert max(depths) == pytest.approx(body.bounding_radius, rel=1e-14)
