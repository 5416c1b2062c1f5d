"""Particles of any convex shape, from the file of a triangle mesh.

The particle is the convex hull of the mesh, of uniform density. Its frame is that of the other
shapes: centre of mass at the origin, principal axes with j1 <= j2 <= j3, and the half-size a, half
of the extent along the first axis, as the unit of length. So the reference length is again
L_xi = 2a, and neither the units of the file nor the pose of the mesh in it matter; a mirror image
is another particle.

Where several vertices of a mesh touch the wall together, the contact is at their mean. For an edge,
a triangle and a regular face that is the centre; a random orientation never lands so.
"""

import io
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull

from sampler.errors import InputError
from sampler.files import read_file
from tablegen.config.solids import FlatError, mass_of, principal_axes, true_vertices
from tablegen.config.support_map_builder import make_map
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import MESH_SIZE
from tablegen.model.shapes import Body
from tablegen.model.support_map import SupportMap, longest_list

#: Kinds of files that can be read, by suffix.
SUFFIXES = (".stl", ".obj", ".ply")

#: Most vertices of a hull; a configuration carries them all.
MOST_VERTICES = 10_000

#: Largest mesh file, in bytes.
MOST_BYTES = 2**28

#: Least volume of a mesh over that of its convex hull that still counts as convex.
CONVEX = 0.999

Vertices = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, eq=False)
class MeshParticle:
    """A convex particle, in its principal axes and in units of its half-size a.

    Attributes
    ----------
    vertices : (m, 3) float64
        Corners of the convex hull, about the centre of mass.
    moments : (3,) float64
        Principal moments of inertia per unit mass in units of a^2, increasing.
    half_sizes : (3,) float64
        Half of the extents along the principal axes; the first is 1. They need not decrease:
        the moments decide the order.
    bounding_radius : float
        Largest distance of a vertex from the centre of mass.
    support_map : SupportMap
        Look-up from a direction to the vertices that may support the particle there.
    unit : float
        The half-size a in units of the file.
    centre : (3,) float64
        Centre of mass in units and axes of the file.
    axes : (3, 3) float64
        Principal axes (rows, right-handed) in axes of the file.
    volume : float
        Volume of the convex hull in units of a^3.
    """

    vertices: FloatArray
    moments: FloatArray
    half_sizes: FloatArray
    bounding_radius: float
    support_map: SupportMap
    unit: float
    centre: FloatArray
    axes: FloatArray
    volume: float

    def body(self) -> Body:
        """Give the particle as the mechanics takes it."""
        j1, j2, j3 = self.moments.tolist()
        _, b, c = self.half_sizes.tolist()
        candidates = np.zeros((longest_list(self.support_map), 3))
        counts = np.zeros(1, dtype=np.int64)
        return Body((j1, j2, j3), candidates, counts, b, c, self.bounding_radius, self.support_map)


@dataclass(frozen=True)
class MeshFile:
    """What is taken from a mesh file.

    Attributes
    ----------
    name : str
        Name of the file, without folders.
    vertices : tuple of (x, y, z)
        Corners of the convex hull, in units and axes of the file.
    solidity : float
        Volume of the mesh over that of its convex hull: 1 for a convex mesh.
    """

    name: str
    vertices: Vertices
    solidity: float

    @property
    def is_convex(self) -> bool:
        """Whether the hull adds less than a thousandth of its volume to the mesh."""
        return self.solidity > CONVEX


def load_mesh(path: str | os.PathLike[str]) -> MeshParticle:
    """Read a particle from an STL, OBJ or PLY file.

    Parameters
    ----------
    path : str or path-like

    Returns
    -------
    MeshParticle

    Raises
    ------
    InputError
        As `read_mesh`.
    """
    return mesh_particle(read_mesh(path).vertices)


def read_mesh(path: str | os.PathLike[str]) -> MeshFile:
    """Read a mesh file and take its convex hull.

    Parameters
    ----------
    path : str or path-like
        An STL, OBJ or PLY file with a closed surface.

    Returns
    -------
    MeshFile

    Raises
    ------
    InputError
        If the file is missing, is no regular file, is too long or cannot be read, or the mesh is
        empty, has fewer than four vertices, an extent outside of `MESH_SIZE`, is open, has faces
        that are turned inside out, is flat, or has too many corners.
    """
    path = Path(path)
    points, faces = _triangles(path)
    if len(faces) == 0:
        raise _refused(path, "which has no faces", "a closed surface")
    if len(points) < 4:
        raise _refused(path, f"which has {len(points)} vertices", "4 or more")
    if problem := _size_problem(points):
        raise _refused(path, f"with {problem}", _SIZES)
    try:
        corners = points[true_vertices(points)]
    except FlatError as error:
        raise _refused(path, "which is flat", "a mesh that encloses a volume") from error
    if len(corners) > MOST_VERTICES:
        given = f"whose convex hull has {len(corners)} vertices"
        raise _refused(path, given, f"up to {MOST_VERTICES}")
    size = np.ptp(points, axis=0).max()
    volume = _enclosed_volume(path, points / size, faces)
    hull = ConvexHull((corners - corners.mean(axis=0)) / size)
    vertices: Vertices = tuple((float(x), float(y), float(z)) for x, y, z in corners)
    return MeshFile(path.name, vertices, volume / mass_of(hull).volume)


def mesh_particle(vertices: ArrayLike) -> MeshParticle:
    """Make a particle of the convex hull of some points.

    Parameters
    ----------
    vertices : array_like of float, shape (n, 3)
        In any units and axes.

    Returns
    -------
    MeshParticle

    Raises
    ------
    InputError
        If there are fewer than four points, too many, one that is not finite, an extent outside of
        `MESH_SIZE`, or they lie in a plane.
    """
    points = np.asarray(vertices, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not 4 <= len(points) <= MOST_VERTICES:
        allowed = f"4 to {MOST_VERTICES} rows of three numbers"
        raise InputError(f"vertices: got shape {points.shape}, allowed: {allowed}")
    if not np.isfinite(points).all():
        raise InputError("vertices: got a number that is not finite, allowed: finite numbers")
    if problem := _size_problem(points):
        raise InputError(f"vertices: got {problem}, allowed: {_SIZES}")
    try:
        points = points[true_vertices(points)]
    except FlatError as error:
        raise InputError(
            "vertices: got points that lie in a plane, allowed: points that span a volume"
        ) from error
    shift = points.mean(axis=0)
    size = np.ptp(points, axis=0).max()
    # at the origin and of unit size, so that neither loses digits
    return _in_principal_axes((points - shift) / size, shift, float(size))


@lru_cache(maxsize=32)
def cached_particle(vertices: Vertices) -> MeshParticle:
    """Give `mesh_particle` of the points, made once: a table asks for it at every node."""
    return mesh_particle(vertices)


def _in_principal_axes(points: FloatArray, shift: FloatArray, size: float) -> MeshParticle:
    """Particle with the corners ``shift + size * points`` in the file's axes."""
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
        unit=float(a * size),
        centre=shift + size * mass.centre,
        axes=axes,
        volume=mass.volume / a**3,
    )


_SIZES = f"coordinates up to {MESH_SIZE.high:g}, a largest extent of {MESH_SIZE.low:g} or more"


def _size_problem(points: FloatArray) -> str | None:
    """Say why points are too large or too small; those in one place are left to others."""
    largest = np.abs(points).max()
    if largest > MESH_SIZE.high:
        return f"a coordinate of {largest:g}"
    extent = np.ptp(points, axis=0).max()
    return f"an extent of {extent:g}" if 0.0 < extent < MESH_SIZE.low else None


def _triangles(path: Path) -> tuple[FloatArray, NDArray[np.int64]]:
    """Vertices and triangles of a file, as they stand in it."""
    # an import of a second that only meshes need
    import trimesh

    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise _refused(path, "", f"a file ending in {', '.join(SUFFIXES)}")
    content = io.BytesIO(read_file("particle", path, MOST_BYTES))
    try:
        # bytes have no place from which materials and images that they name could be read
        mesh = trimesh.load_mesh(content, kind[1:], process=False, skip_materials=True)
    except Exception as error:
        # the library's readers raise anything on a file that is not what its suffix says
        raise _refused(
            path, f"which cannot be read as {kind[1:].upper()}", "a mesh file"
        ) from error
    points = np.asarray(mesh.vertices, dtype=np.float64)
    if not np.isfinite(points).all():
        raise _refused(path, "which has a vertex that is not finite", "finite coordinates")
    return points, np.asarray(mesh.faces, dtype=np.int64)


def _enclosed_volume(path: Path, points: FloatArray, faces: NDArray[np.int64]) -> float:
    """Volume within a closed surface of unit size; any other surface is refused."""
    import trimesh

    # the library merges vertices by an absolute distance, which is why the size matters
    surface = trimesh.Trimesh(points - points.mean(axis=0), faces, process=True)
    surface.update_faces(surface.nondegenerate_faces())
    if not surface.is_watertight:
        raise _refused(path, "which is open", "a closed surface, each edge shared by two faces")
    if not surface.is_winding_consistent:
        raise _refused(path, "with faces turned inside out", "faces that all face outward")
    return float(abs(np.linalg.det(surface.triangles).sum()) / 6.0)


def _refused(path: Path, given: str, allowed: str) -> InputError:
    """Error for a file that cannot be used."""
    return InputError(f"particle: got {path}{', ' if given else ''}{given}, allowed: {allowed}")
