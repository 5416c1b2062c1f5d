"""Particles of any convex shape, from the file of a triangle mesh.

The particle is the convex hull of the mesh, of uniform density. Its frame is that of the other
shapes: centre of mass at the origin, principal axes with j1 <= j2 <= j3, and the half-size a, half
of the extent along the first axis, as the unit of length. So neither the units of the file nor the
pose of the mesh in it matter; a mirror image is another particle.
"""

import io
import os
import re
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull

from sampler.errors import InputError
from sampler.files import parse_number, read_file
from tablegen.config.solids import FlatError, mass_of, principal_axes, true_vertices
from tablegen.config.support_map_builder import make_map
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import MESH_SIZE
from tablegen.model.shapes import Body, SupportMap, longest_list

#: Kinds of files that can be read, by suffix.
SUFFIXES = (".stl", ".obj", ".ply")

#: Most vertices of a hull, which a configuration carries all; a hull of more is thinned.
MOST_VERTICES = 10_000

#: Distance of a left-out corner from the faces of a thinned hull, over the largest extent, that
#: qhull allows, and the tolerance that is stated: merging faces, qhull overshoots by a tenth.
_THINNING = 4e-4
THINNED_WITHIN = 5e-4

#: Least size of an STL body over the steps of single precision in which its corners are rounded.
_LEAST_STEPS = 1e4

#: Least volume of a mesh over that of its convex hull that still counts as convex.
CONVEX = 0.999

Vertices = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, eq=False)
class MeshParticle:
    """A convex particle, in its principal axes and in units of its half-size a."""

    #: (m, 3): corners of the convex hull, about the centre of mass.
    vertices: FloatArray
    #: (3,): principal moments of inertia per unit mass in units of a^2, increasing.
    moments: FloatArray
    #: (3,): half of the extents along the principal axes; the first is 1. The moments decide the
    #: order, so they need not decrease.
    half_sizes: FloatArray
    #: Largest distance of a vertex from the centre of mass.
    bounding_radius: float
    #: Look-up from a direction to the vertices that may be the farthest along it.
    support_map: SupportMap
    #: (3, 3): principal axes (rows, right-handed) in axes of the file.
    axes: FloatArray

    @property
    def reach(self) -> FloatArray:
        """Largest distances of vertices from the centre of mass along the axes, (3,)."""
        return np.abs(self.vertices).max(axis=0)

    def body(self) -> Body:
        """Return the particle as the mechanics takes it."""
        j1, j2, j3 = self.moments.tolist()
        a, b, c = self.reach.tolist()
        candidates = np.zeros((longest_list(self.support_map), 3))
        counts = np.zeros(1, dtype=np.int64)
        return Body(
            (j1, j2, j3), candidates, counts, (a, b, c), self.bounding_radius, self.support_map
        )


@dataclass(frozen=True)
class MeshFile:
    """Name and content of a mesh file."""

    name: str
    #: Corners of the convex hull, thinned if it had many, in units and axes of the file.
    vertices: Vertices
    #: Number of corners before.
    corners: int
    #: Volume of the mesh over that of its convex hull, 1 for a convex mesh; None if the surface
    #: encloses no volume.
    solidity: float | None
    #: Whether the surface has an edge that belongs to one face only.
    is_open: bool

    @property
    def is_convex(self) -> bool:
        """Whether the hull adds less than a thousandth of its volume to the mesh."""
        return self.solidity is not None and self.solidity > CONVEX

    def doubts(self) -> list[str]:
        """Say what the simulated particle adds to the mesh, or leaves out, one on each line."""
        lines = []
        if self.solidity and not self.is_convex:
            size = f"of {1.0 / self.solidity:.4g} times its volume"
            lines.append(f"{self.name} is not convex; its convex hull, {size}, is simulated")
        elif not self.is_convex:
            reason = "is open" if self.is_open else "has faces that do not agree on the outside"
            lines.append(
                f"{self.name} {reason}; its convex hull is simulated, and may have another volume"
            )
        if len(self.vertices) < self.corners:
            lines.append(
                f"{self.name}: its hull of {self.corners} corners is thinned to "
                f"{len(self.vertices)}, within {THINNED_WITHIN:g} of its largest extent"
            )
        return lines


def read_mesh(path: str | os.PathLike[str]) -> MeshFile:
    """Read an STL, OBJ or PLY file, and take the convex hull of its surface.

    Raises `InputError` if the file is missing or cannot be read, or the mesh is empty or flat, or
    has a size outside of `MESH_SIZE`. See `thinned` for a hull of many corners.
    """
    path = Path(path)
    points, faces = _surface(path)
    if path.suffix.lower() == ".stl" and (problem := _lost_digits(points)):
        remedy = "move it to the origin before you write it as STL"
        raise InputError("particle", str(path), problem=problem, remedy=remedy)
    try:
        corners = points[true_vertices(points)]
    except FlatError as error:
        raise _refused(path, "which is flat", "a mesh that encloses a volume") from error
    size = np.ptp(points, axis=0).max()
    is_open, volume = _enclosed_volume(points / size, faces)
    hull = ConvexHull((corners - corners.mean(axis=0)) / size)
    vertices: Vertices = tuple(map(tuple, thinned(corners).tolist()))
    solidity = None if volume is None else volume / mass_of(hull).volume
    return MeshFile(path.name, vertices, len(corners), solidity, is_open)


def thinned(corners: FloatArray) -> FloatArray:
    """Leave out corners of a convex hull of more than `MOST_VERTICES`, and return the others.

    Those that are left out lie within `THINNED_WITHIN` of the new hull, over the largest extent.
    """
    if len(corners) <= MOST_VERTICES:
        return corners
    scaled = (corners - corners.mean(axis=0)) / np.ptp(corners, axis=0).max()
    kept = corners[np.sort(ConvexHull(scaled, qhull_options=f"W{_THINNING}").vertices)]
    return kept[true_vertices(kept)]


def _lost_digits(points: FloatArray) -> str | None:
    """Say that a body is so far from the origin that single precision has changed its form."""
    step = float(np.spacing(np.float32(np.abs(points).max())))
    size = float(np.ptp(points, axis=0).max())
    single = np.array_equal(points, points.astype(np.float32))
    if not single or size >= _LEAST_STEPS * step:
        return None
    return f"far from the origin: a size of {size:.3g} in steps of {step:.3g}, which STL rounds to"


def mesh_particle(vertices: ArrayLike) -> MeshParticle:
    """Make a particle of the convex hull of points (n, 3), in any units and axes.

    Raises `InputError` if there are fewer than four points, one that is not finite, a size outside
    of `MESH_SIZE`, or they lie in a plane. See `thinned` for a hull of many corners.
    """
    points = np.asarray(vertices, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 4:
        allowed = "4 or more rows of three numbers"
        raise InputError("vertices", f"shape {points.shape}", allowed)
    if problem := _size_problem(points):
        raise InputError("vertices", problem, _SIZES)
    try:
        points = thinned(points[true_vertices(points)])
    except FlatError as error:
        allowed = "points that span a volume"
        raise InputError("vertices", "points that lie in a plane", allowed) from error
    # at the origin and of unit size, so that no digits are lost
    return _in_principal_axes((points - points.mean(axis=0)) / np.ptp(points, axis=0).max())


@lru_cache(maxsize=32)
def cached_particle(vertices: Vertices) -> MeshParticle:
    """Return `mesh_particle` of the points, made once: a table asks for it at every node."""
    return mesh_particle(vertices)


def _in_principal_axes(points: FloatArray) -> MeshParticle:
    """Make the particle with these corners, in the file's axes."""
    hull = ConvexHull(points)
    mass = mass_of(hull)
    axes = principal_axes(hull, mass)
    centred = (points - mass.centre) @ axes.T
    extents = np.ptp(centred, axis=0)
    a = 0.5 * extents[0]
    second = np.einsum("ki,ij,kj->k", axes, mass.second, axes) / a**2
    corners = np.ascontiguousarray(centred / a)
    return MeshParticle(
        vertices=corners,
        moments=np.sort(second.sum() - second),
        half_sizes=extents / extents[0],
        bounding_radius=float(np.linalg.norm(corners, axis=1).max()),
        support_map=make_map(ConvexHull(corners)),
        axes=axes,
    )


_SIZES = f"coordinates up to {MESH_SIZE.high:g}, a largest extent of {MESH_SIZE.low:g} or more"


def _size_problem(points: FloatArray) -> str | None:
    """Say why points are too large or too small; None if they are not, or all in one place."""
    largest = np.abs(points).max()
    if not largest <= MESH_SIZE.high:  # NaN is not either
        return f"a coordinate of {largest:g}"
    extent = np.ptp(points, axis=0).max()
    return f"an extent of {extent:g}" if 0.0 < extent < MESH_SIZE.low else None


def _surface(path: Path) -> tuple[FloatArray, NDArray[np.int64]]:
    """Read the surface of a file: triangles that have an area, and the vertices that they use."""
    points, faces = _triangles(path)
    if not len(faces):
        raise _refused(path, "which has no faces", "the mesh of a surface")
    if not 0 <= faces.min() <= faces.max() < len(points):
        index = faces.min() if faces.min() < 0 else faces.max()
        allowed = f"vertices 0 to {len(points) - 1}"
        raise _refused(path, f"with a face of vertex {index}, counted from 0", allowed)
    corners = points[faces]
    if problem := _size_problem(corners.reshape(-1, 3)):
        raise _refused(path, f"with {problem}", _SIZES)
    sides = corners[:, 1:] - corners[:, :1]
    faces = faces[np.cross(sides[:, 0], sides[:, 1]).any(axis=1)]
    if not len(faces):
        raise _refused(path, "whose faces have no area", "the mesh of a surface")
    used, faces = np.unique(faces, return_inverse=True)
    return points[used], faces.reshape(-1, 3)


def _triangles(path: Path) -> tuple[FloatArray, NDArray[np.int64]]:
    """Read the vertices and triangles of a file."""
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise _refused(path, "", f"a file ending in {', '.join(SUFFIXES)}")
    content = read_file("particle", path)
    try:
        return _triangles_of_obj(content) if kind == ".obj" else _by_trimesh(content, kind[1:])
    except Exception as error:
        # trimesh raises anything on a file of another kind than its suffix says
        given = f"which cannot be read as {kind[1:].upper()}"
        raise _refused(path, given, "a mesh file") from error


def _by_trimesh(content: bytes, kind: str) -> tuple[FloatArray, NDArray[np.int64]]:
    """Read the vertices and triangles of an STL or PLY file."""
    # importing it takes a second, which only meshes need
    import trimesh

    # bytes have no folder from which trimesh could read images that they name
    mesh = trimesh.load_mesh(io.BytesIO(content), kind, process=False)
    return np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)


def _triangles_of_obj(content: bytes) -> tuple[FloatArray, NDArray[np.int64]]:
    """Read the vertices and faces of an OBJ file; cut faces of many sides into triangles.

    Not by trimesh, which counts negative indices from the last vertex of the whole file, and 0 as
    the last vertex. By the format they count from the vertex above the face, and there is no 0.
    """
    points = list[tuple[float, float, float]]()
    faces = list[tuple[int, int, int]]()
    content = re.sub(rb"\\\r?\n", b" ", content)  # a line that goes on on the next
    for line in io.TextIOWrapper(io.BytesIO(content), encoding="utf-8", errors="replace"):
        words = line.partition("#")[0].split()
        if words[:1] == ["v"]:
            x, y, z = map(parse_number, words[1:4])
            points.append((x, y, z))
        elif words[:1] == ["f"]:
            first, *others = [_index_in_obj(word, len(points)) for word in words[1:]]
            faces += [(first, second, third) for second, third in pairwise(others)]
    return np.array(points), np.array(faces, dtype=np.int64)


def _index_in_obj(word: str, above: int) -> int:
    """Read the vertex of a corner such as 7, 7/1 or -3//2, counted from 0.

    It is below 0 if there is no such vertex among those above the face.
    """
    number = word.partition("/")[0]
    if not re.fullmatch(r"-?\d+", number, re.ASCII):
        raise ValueError(word)
    index = int(number)
    return index - 1 if index > 0 else above + index if index else -1


def _enclosed_volume(points: FloatArray, faces: NDArray[np.int64]) -> tuple[bool, float | None]:
    """Tell whether a surface of unit size is open, and compute the volume within, if any."""
    import trimesh

    # trimesh merges vertices by an absolute distance, so the size matters
    surface = trimesh.Trimesh(points - points.mean(axis=0), faces, process=True)
    surface.update_faces(surface.nondegenerate_faces())
    if not (surface.is_watertight and surface.is_winding_consistent):
        return not surface.is_watertight, None
    return False, float(abs(np.linalg.det(surface.triangles).sum()) / 6.0)


def _refused(path: Path, problem: str, allowed: str) -> InputError:
    """Make the error for a file that cannot be used."""
    return InputError("particle", str(path), allowed, problem=problem)
