"""Support maps: the list of each direction has every vertex that it needs."""

import math

import numba
import numpy as np
import pytest
from mesh_fixtures import box, cylinder, directions, grain, icosphere, posed, tetrahedron
from scipy.spatial import ConvexHull

from tablegen.meshes.particle import mesh_particle
from tablegen.meshes.support_map_builder import SLACK, make_map
from tablegen.model.jit import kernel
from tablegen.model.shapes import direction_cell, support_depth, support_range

# called from Python here
direction_cell = kernel(direction_cell)
support_range = kernel(support_range)

SOLIDS = {
    "box": box(0.8, 0.6),
    "tetrahedron": tetrahedron(0.7, 0.5),
    "grain": grain(1000),
    "small-grain": grain(30, seed=3),
    "needle": grain(300, seed=4, sizes=(1.0, 0.03, 0.02)),
    "disc": cylinder(120, 0.02),
    "sphere": icosphere(3),
}


@numba.njit
def worst_miss(support_map, vertices, at, along):
    """Return how far the best vertex of a list falls short of the best of all vertices."""
    worst = 0.0
    for i in range(len(at)):
        first, end = support_range(support_map, at[i, 0], at[i, 1], at[i, 2])
        listed = every = -np.inf
        for k in range(first, end):
            p = support_map.points[k]
            listed = max(listed, p[0] * along[i, 0] + p[1] * along[i, 1] + p[2] * along[i, 2])
        for k in range(len(vertices)):
            p = vertices[k]
            every = max(every, p[0] * along[i, 0] + p[1] * along[i, 1] + p[2] * along[i, 2])
        worst = max(worst, every - listed)
    return worst


def turned(rng, unit, angle):
    side = np.cross(unit, directions(rng, len(unit)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return math.cos(angle) * unit + math.sin(angle) * side


def vicious(rng, points, count):
    """Directions where lists are most likely to be wrong: at face normals and between cells."""
    normals = ConvexHull(points).equations[:, :3]
    normals = normals[rng.integers(len(normals), size=count)]
    lattice = directions(rng, count)
    lattice /= np.abs(lattice).max(axis=1, keepdims=True)
    lattice = np.round(lattice * 8.0) / 8.0
    lattice /= np.linalg.norm(lattice, axis=1, keepdims=True)
    return np.concatenate([normals, lattice])


@pytest.mark.parametrize("name", SOLIDS)
def test_the_supporting_vertex_is_listed_for_every_direction_within_the_slack(name):
    rng = np.random.default_rng(61)
    body = mesh_particle(SOLIDS[name])
    at = np.concatenate([directions(rng, 100_000), vicious(rng, body.vertices, 10_000)])
    for angle in (0.0, 0.5 * SLACK, SLACK):
        assert worst_miss(body.support_map, body.vertices, at, turned(rng, at, angle)) <= 1e-15


@pytest.mark.parametrize("name", ["grain", "disc", "sphere"])
def test_a_list_taken_for_less_slack_is_found_out(name):
    rng = np.random.default_rng(62)
    body = mesh_particle(SOLIDS[name])
    lean = make_map(ConvexHull(body.vertices), 0.5 * SLACK)
    at = directions(rng, 30_000)
    assert worst_miss(lean, body.vertices, at, turned(rng, at, 0.5 * SLACK)) <= 1e-15
    assert worst_miss(lean, body.vertices, at, turned(rng, at, SLACK)) > 1e-6


@pytest.mark.parametrize("name", SOLIDS)
def test_depth_is_that_of_the_lowest_of_all_vertices(name):
    particle = mesh_particle(posed(SOLIDS[name]))
    body = particle.body()
    for n in directions(np.random.default_rng(65), 500):
        assert support_depth(body, *n) == pytest.approx(-(particle.vertices @ n).min(), abs=1e-15)
