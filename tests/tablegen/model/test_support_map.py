"""Support maps: no vertex that a direction needs is missing from its list."""

import math

import numba
import numpy as np
import pytest
from mesh_fixtures import box, cylinder, directions, grain, icosphere, posed, tetrahedron
from motion_fixtures import PAIR, run_rebound, with_vertices
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from tablegen.config.mesh import mesh_particle
from tablegen.config.support_map_builder import SLACK, cell_frames, make_map
from tablegen.model.jit import kernel
from tablegen.model.rebound import MOTION_SIZE, next_contact
from tablegen.model.rotation import ORDER
from tablegen.model.shapes import lowest_depth
from tablegen.model.support_map import NO_MAP, direction_cell, empty_map, support_range
from tablegen.simulation.simulate import make_condition

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
    """Most by which the best vertex of a list, found for ``at``, falls short of all vertices."""
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
    """Unit vectors turned by an angle towards random sides."""
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


def test_lists_of_a_large_grain_are_short():
    # a fiftieth of the vertices, and most of those lie within the slack of the direction
    body = mesh_particle(SOLIDS["grain"]).body()
    lengths = np.diff(body.support_map.starts)
    assert len(lengths) == 6 * body.support_map.resolution**2
    assert lengths.mean() < 25.0
    assert lengths.max() < 100


@pytest.mark.parametrize("resolution", [1, 2, 7])
def test_cells_are_numbered_like_their_centres(resolution):
    centres, radii = cell_frames(resolution)
    found = [direction_cell(resolution, *centre) for centre in centres]
    assert found == list(range(6 * resolution**2))
    assert np.all(radii < math.acos(1.0 / math.sqrt(3.0)) + 1e-12)


@pytest.mark.parametrize("resolution", [1, 5, 16])
def test_a_direction_is_within_the_radius_of_its_cell(resolution):
    rng = np.random.default_rng(63)
    centres, radii = cell_frames(resolution)
    special = np.array([v for v in np.ndindex(3, 3, 3) if v != (1, 1, 1)]) - 1.0
    n = np.concatenate([directions(rng, 20_000), special])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    cells = [direction_cell(resolution, *row) for row in n * 3.0]
    angle = np.arccos(np.clip(np.einsum("ij,ij->i", n, centres[cells]), -1.0, 1.0))
    assert np.all(angle <= radii[cells] + 1e-9)
    assert set(cells) == set(range(6 * resolution**2))


def test_a_finer_map_lists_no_more_than_its_slack_needs():
    # each listed vertex supports the body somewhere within radius + slack of the centre
    hull = ConvexHull(SOLIDS["small-grain"])
    made = make_map(hull, 0.1, 8)
    centres, radii = cell_frames(8)
    rng = np.random.default_rng(64)
    for cell in range(0, len(centres), 37):
        around = turned(rng, np.repeat(centres[[cell]], 20_000, axis=0), 1.0)
        shares = np.sqrt(rng.random((20_000, 1))) * (radii[cell] + 0.1)
        around = np.cos(shares) * centres[cell] + np.sin(shares) * (
            (around - math.cos(1.0) * centres[cell]) / math.sin(1.0)
        )
        seen = set(np.argmax(around @ hull.points.T, axis=1).tolist())
        rows = made.points[made.starts[cell] : made.starts[cell + 1]]
        listed = {int(np.flatnonzero((hull.points == row).all(axis=1))[0]) for row in rows}
        assert seen <= listed
        # a cone may reach in by less than the samples resolve
        assert len(listed - seen) <= 1


def test_no_map_is_the_empty_map():
    made = empty_map()
    assert (made.resolution, made.slack) == (NO_MAP.resolution, NO_MAP.slack) == (0, math.inf)
    np.testing.assert_array_equal(made.starts, NO_MAP.starts)
    assert made.points.shape == NO_MAP.points.shape == (0, 3)


@pytest.mark.parametrize("name", SOLIDS)
def test_depth_is_that_of_the_lowest_of_all_vertices(name):
    particle = mesh_particle(posed(SOLIDS[name]))
    body = particle.body()
    for n in directions(np.random.default_rng(65), 500):
        assert lowest_depth(body, n) == pytest.approx(-(particle.vertices @ n).min(), abs=1e-15)


def without_map(particle):
    """Body of a mesh, looked at vertex by vertex."""
    return with_vertices(particle.body(), particle.vertices)


@pytest.mark.parametrize("name", ["grain", "needle", "disc", "box"])
def test_contacts_are_those_of_a_search_over_all_vertices(name):
    particle = mesh_particle(SOLIDS[name])
    body, plain = particle.body(), without_map(particle)
    assert plain.support_map.resolution == 0
    rng = np.random.default_rng(66)
    series = np.empty((9, ORDER + 1))
    touched = 0
    for rotation in Rotation.random(200, rng=rng).as_matrix():
        motion = np.empty(MOTION_SIZE)
        motion[0:3] = rng.normal(size=3) * 4.0
        motion[3:6], motion[6:9] = rotation[1], rotation[0]
        motion[9:12] = 0.3, rng.uniform(-0.5, 0.5), 0.0
        motion[12] = lowest_depth(body, motion[3:6]) + 10.0 ** rng.uniform(-6.0, -0.5)
        other = motion.copy()
        touches = next_contact(body, 1e-10, motion, series)
        assert touches == next_contact(plain, 1e-10, other, series)
        np.testing.assert_allclose(motion, other, atol=1e-8)
        touched += touches
    assert 50 < touched < 200


@pytest.mark.parametrize("alpha_deg", [20.0, 90.0])
def test_rebounds_are_those_of_a_search_over_all_vertices(alpha_deg):
    particle = mesh_particle(SOLIDS["grain"])
    body, plain = particle.body(), without_map(particle)
    condition = make_condition(np.radians(alpha_deg), 200.0)
    apart = []
    for rotation in Rotation.random(300, rng=np.random.default_rng(67)).as_matrix():
        one = run_rebound(condition, body, rotation, PAIR.kernel_arguments())
        two = run_rebound(condition, plain, rotation, PAIR.kernel_arguments())
        apart.append(np.abs(one.state - two.state).max() + (one.collisions != two.collisions))
    # rounding grows along chains of collisions, but only in the longest to anything visible
    assert np.quantile(apart, 0.9) < 1e-8
    assert np.mean(np.array(apart) > 1e-6) < 0.02
