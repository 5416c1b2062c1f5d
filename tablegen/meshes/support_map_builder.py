"""Make the look-up from directions to supporting vertices that `tablegen.model.shapes` reads.

The directions in which a vertex supports a convex body form its normal cone. On the unit sphere it
is a convex polygon: its corners are the normals of the faces around the vertex, its sides the arcs
between normals of faces that share an edge. Within an angle R of a cell's centre a vertex supports
the body only if it does so at the centre, or a side of its polygon passes within R of the centre.
Both are tested here, so the lists are complete by construction.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, cKDTree

from tablegen.model.float_array import FloatArray
from tablegen.model.shapes import SupportMap

#: Angle [rad] by which a direction may turn before its list is renewed. Measured on grains of 100
#: to 4,000 vertices: less shortens the steps of the contact search, more lengthens the lists.
SLACK = 0.15

#: Angle [rad] added to every list for rounding, in the face normals and in the kernels' wall
#: normal; both are known to better than 1e-7.
ROUNDING = 1e-6

#: Cells along a side of the cube map, least and most; between them it grows with the vertices.
_LEAST, _MOST = 4, 24

#: Half-length [rad] up to which a side of a normal cone is looked for near its middle only.
_SHORT = 0.1

#: Pairs of a cell and a vertex compared at a time (bounds the memory).
_AT_A_TIME = 4_000_000


def cell_frames(resolution: int) -> tuple[FloatArray, FloatArray]:
    """Compute centres and radii of the cells of a cube map with `resolution` cells along a side.

    Centres are unit vectors (6 resolution^2, 3) in the order of `direction_cell`; radii are the
    angles [rad] from a centre to its farthest corner.
    """
    edges = np.linspace(-1.0, 1.0, resolution + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    centres = _cube_directions(middle, middle)
    radii = np.zeros(len(centres))
    for s in (edges[:-1], edges[1:]):
        for t in (edges[:-1], edges[1:]):
            corners = _cube_directions(s, t)
            radii = np.maximum(radii, _angle(centres, corners))
    return centres, radii


def make_map(hull: ConvexHull, slack: float = SLACK) -> SupportMap:
    """Make the look-up of a convex polyhedron: all ``hull.points`` are vertices.

    A direction may turn away from its cell by `slack` [rad].
    """
    points = np.ascontiguousarray(hull.points)
    # one and a half cells a vertex: smaller cells would hardly shorten the lists
    resolution = int(np.clip(round(math.sqrt(0.25 * len(points))), _LEAST, _MOST))
    centres, radii = cell_frames(resolution)
    start, end, owners = _cone_sides(hull)
    cells, sides = _near_pairs(centres, radii + slack + ROUNDING, start, end)
    listed = [cells * len(points) + owners[sides, k] for k in range(2)]
    listed.append(np.arange(len(centres)) * len(points) + _supporting(points, centres))
    cells, vertices = np.divmod(np.unique(np.concatenate(listed)), len(points))
    starts = np.searchsorted(cells, np.arange(len(centres) + 1)).astype(np.int64)
    return SupportMap(resolution, slack, starts, points[vertices])


def _supporting(points: FloatArray, directions: FloatArray) -> NDArray[np.intp]:
    """Find the point that lies farthest along each direction."""
    size = max(1, _AT_A_TIME // len(points))
    parts = range(0, len(directions), size)
    return np.concatenate([np.argmax(directions[i : i + size] @ points.T, axis=1) for i in parts])


def _near_pairs(
    centres: FloatArray, reach: FloatArray, start: FloatArray, end: FloatArray
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Find the pairs (cell, arc) of arcs that pass within ``reach`` [rad] of a cell's centre."""
    half = 0.5 * _angle(start, end)
    short, long = np.flatnonzero(half <= _SHORT), np.flatnonzero(half > _SHORT)
    cells = np.repeat(np.arange(len(centres)), len(long))
    arcs = np.tile(long, len(centres))
    if len(short):
        middle = start[short] + end[short]
        tree = cKDTree(middle / np.linalg.norm(middle, axis=1, keepdims=True))
        chords = 2.0 * np.sin(0.5 * np.minimum(reach + _SHORT, np.pi))
        near = tree.query_ball_point(centres, chords)
        cells = np.append(cells, np.repeat(np.arange(len(centres)), [len(i) for i in near]))
        arcs = np.append(arcs, short[np.concatenate(near).astype(np.intp)])
    near = _distance_to_arcs(centres[cells], start[arcs], end[arcs]) <= reach[cells]
    return cells[near], arcs[near]


def _cube_directions(s: FloatArray, t: FloatArray) -> FloatArray:
    """Return unit vectors through the points (s, t) of all six sides, in the order of the cells."""
    s_grid, t_grid = (grid.ravel() for grid in np.meshgrid(s, t, indexing="ij"))
    sides = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            side = np.empty((s_grid.size, 3))
            side[:, axis] = sign
            side[:, (axis + 1) % 3] = s_grid
            side[:, (axis + 2) % 3] = t_grid
            sides.append(side)
    directions = np.concatenate(sides)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _cone_sides(hull: ConvexHull) -> tuple[FloatArray, FloatArray, NDArray[np.intp]]:
    """Return the sides of the normal cones: unit normals at both ends of an arc between faces.

    The two owners of each are the vertices whose cones meet in the arc.
    """
    normals = hull.equations[:, :3]
    start, end, owners = [], [], []
    for k in range(3):
        # neighbour k of a triangle lies across the edge opposite to its corner k
        start.append(normals)
        end.append(normals[hull.neighbors[:, k]])
        owners.append(np.delete(hull.simplices, k, axis=1))
    keep = np.concatenate([hull.neighbors[:, k] > np.arange(len(normals)) for k in range(3)])
    return np.concatenate(start)[keep], np.concatenate(end)[keep], np.concatenate(owners)[keep]


def _distance_to_arcs(centres: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Compute the angle [rad] from each of n centres to the arc in the same row: (n,).

    The nearest point of an arc is that of its great circle if the centre lies between the planes
    through the ends and perpendicular to the circle, and otherwise one of the ends.
    """
    pole = np.cross(start, end)
    length = np.linalg.norm(pole, axis=1)
    between = np.einsum("ij,ij->i", centres, np.cross(pole, start)) >= 0.0
    between &= np.einsum("ij,ij->i", centres, np.cross(end, pole)) >= 0.0
    between &= length > 0.0
    off = np.abs(np.einsum("ij,ij->i", centres, pole))
    sine = np.divide(off, length, out=np.zeros_like(off), where=between)
    to_ends = np.minimum(_angle(centres, start), _angle(centres, end))
    return np.where(between, np.arcsin(np.clip(sine, 0.0, 1.0)), to_ends)


def _angle(first: FloatArray, second: FloatArray) -> FloatArray:
    """Compute the angle [rad] between rows of unit vectors."""
    half = 0.5 * np.linalg.norm(first - second, axis=1)
    return 2.0 * np.arcsin(np.clip(half, 0.0, 1.0))
