"""Solids and mesh files for tests."""

import itertools

import numpy as np
import trimesh
from one_particle import NO_MAP, shaped_body
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.config.config import load_config
from tablegen.model.shapes import MAX_VERTICES
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")
PAIR, POPULATION = CONFIG.pair, CONFIG.population

BOX_CORNERS = np.array(list(itertools.product((1.0, -1.0), repeat=3)))


def box(b, c):
    """Corners of a box with half-sizes (1, b, c)."""
    return BOX_CORNERS * [1.0, b, c]


def tetrahedron(b, c):
    """Corners of the tetrahedron in that box, with the handedness of the model's."""
    return box(b, c)[[0, 3, 5, 6]]


#: Shapes whose meshes are known, with their corners for half-sizes b and c.
KNOWN = {"prism": box, "tetrahedron": tetrahedron}


def known_body(shape, b, c):
    storage = np.empty((MAX_VERTICES, 3)), np.zeros(1, dtype=np.int64), NO_MAP
    return shaped_body(SHAPE_CODES[shape], b, c, 0.5, *storage)


def two_cubes():
    """Surface of two unit cubes with a gap of one between them: two thirds of their hull."""
    first = surface(0.5 * box(1.0, 1.0))
    second = first.copy()
    second.apply_translation([2.0, 0.0, 0.0])
    return trimesh.util.concatenate([first, second])


def rebounds(population, count, alpha_deg=45.0, speed=200.0, spin=(0.0, 0.0, 0.0), **settings):
    """Direct simulation of a population under the shipped pair's laws."""
    condition = make_condition(np.radians(alpha_deg), speed, spin)
    return simulate_condition(PAIR, population, condition, count, **settings)


def grain(count, seed=1, sizes=(1.0, 0.8, 0.6)):
    """Random points on an ellipsoid: an irregular convex grain with that many corners."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True) * sizes


def icosphere(level, sizes=(1.0, 1.0, 1.0)):
    """Nearly regular points on an ellipsoid: 12, 42, 162, 642, ... of them."""
    return trimesh.creation.icosphere(subdivisions=level).vertices * sizes


def cylinder(sides, height):
    """Corners of a prism on a regular polygon."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(sides)])
    up = np.array([0.0, 0.0, height])
    return np.concatenate([ring + up, ring - up])


def posed(points, seed=2, scale=1.0, shift=(0.0, 0.0, 0.0)):
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    return scale * points @ turn.T + shift


def surface(points):
    """Closed surface of the convex hull of points, its faces outward."""
    hull = ConvexHull(points)
    mesh = trimesh.Trimesh(points, hull.simplices, process=False)
    inward = np.einsum("ij,ij->i", mesh.face_normals, hull.equations[:, :3]) < 0.0
    faces = hull.simplices.copy()
    faces[inward] = faces[inward, ::-1]
    return trimesh.Trimesh(points, faces, process=False)


def directions(rng, count):
    vectors = rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def population_of(*solids, weights=None, shapes=None):
    weights = weights or [1.0] * len(solids)
    meshes = [
        {"vertices": points.tolist(), "weight": weight}
        for points, weight in zip(solids, weights, strict=True)
    ]
    none = dict.fromkeys(POPULATION.shapes.positive(), 0.0)
    changes = {"shapes": none | (shapes or {}), "meshes": meshes}
    return CONFIG.with_changes({"population": changes}).population
