"""Convex solids: true corners, integrals and principal axes, against closed forms."""

import numpy as np
import pytest
from mesh_fixtures import box, cylinder, grain, posed, tetrahedron
from scipy.spatial import ConvexHull

from tablegen.meshes.solids import FlatError, mass_of, principal_axes, true_vertices


def subdivided(points):
    """Return the corners and the middles of all pairs of them, most of which are no corners."""
    first, second = np.triu_indices(len(points), 1)
    return np.concatenate([points, 0.5 * (points[first] + points[second])])


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("corners", [box(0.8, 0.6), box(1.0, 0.01), tetrahedron(1.0, 1.0)])
def test_points_on_edges_and_faces_are_left_out(corners, single):
    points = posed(subdivided(corners), seed=3)
    if single:
        # single precision puts a few of them a hair outside
        points = points.astype(np.float32).astype(np.float64)
    vertices = true_vertices(points)
    assert set(range(len(corners))) <= set(vertices)
    # a point that rounding lifts off an edge by 6e-8 may stay; it changes nothing visible
    assert len(vertices) <= len(corners) + (2 if single else 0)


def test_twins_and_inner_points_are_left_out():
    points = np.concatenate([box(0.8, 0.6), box(0.8, 0.6), box(0.8, 0.6) + 1e-8])
    assert len(true_vertices(points)) == 8
    points = grain(1000)
    inner = 0.5 * (points + points.mean(axis=0))
    with_inner = np.concatenate([inner, points])
    np.testing.assert_array_equal(true_vertices(with_inner), np.arange(1000, 2000))


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((10, 3)),
        grain(3),
        posed(cylinder(20, 0.0)),
        posed(box(0.8, 1e-8)),
        np.outer(np.arange(9.0), [1.0, 2.0, 3.0]),
    ],
)
def test_flat_points(points):
    with pytest.raises(FlatError):
        true_vertices(points)


@pytest.mark.parametrize("shift", [0.0, 300.0])
def test_integrals_of_a_box_and_a_tetrahedron(shift):
    mass = mass_of(ConvexHull(box(0.8, 0.6) + shift))
    assert mass.volume == pytest.approx(8.0 * 0.48, rel=1e-12)
    np.testing.assert_allclose(mass.centre, shift, atol=1e-12)
    np.testing.assert_allclose(mass.second, np.diag([1.0, 0.64, 0.36]) / 3.0, atol=1e-9)
    mass = mass_of(ConvexHull(tetrahedron(0.8, 0.6) + shift))
    assert mass.volume == pytest.approx(8.0 * 0.48 / 3.0, rel=1e-12)
    np.testing.assert_allclose(mass.second, np.diag([1.0, 0.64, 0.36]) / 5.0, atol=1e-9)


def axes_of(points):
    hull = ConvexHull(points)
    axes = principal_axes(hull, mass_of(hull))
    return axes, np.ptp(points @ axes.T, axis=0)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize(
    ("points", "extents"),
    [
        (box(0.8, 0.6), [2.0, 1.6, 1.2]),
        (box(1.0, 0.3), [2.0, 2.0, 0.6]),
        (box(1.0, 1.0), [2.0, 2.0, 2.0]),
        (tetrahedron(1.0, 1.0), [2.0, 2.0, 2.0]),
        # a hexagonal plate: corner to corner, flat to flat, thickness
        (cylinder(6, 0.1), [2.0, np.sqrt(3.0), 0.2]),
    ],
)
def test_axes_of_symmetric_solids_are_those_of_their_box(points, extents, single, seed):
    turned = posed(points, seed)
    if single:
        turned = turned.astype(np.float32).astype(np.float64)
    axes, box_axes = axes_of(turned)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-13)
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-13)
    np.testing.assert_allclose(box_axes, extents, atol=2e-6 if single else 1e-12)


def test_axes_diagonalise_the_second_moments():
    hull = ConvexHull(posed(grain(200)))
    mass = mass_of(hull)
    axes = principal_axes(hull, mass)
    second = axes @ mass.second @ axes.T
    np.testing.assert_allclose(second, np.diag(np.diag(second)), atol=1e-14)
    assert np.all(np.diff(np.diag(second)) < 0.0)
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-13)
