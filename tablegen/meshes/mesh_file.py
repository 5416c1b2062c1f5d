"""Files of triangle meshes; their convex hull is the particle (`tablegen.meshes.particle`)."""

import io
import os
import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from sampler.errors import InputError
from sampler.files import parse_number, read_file
from tablegen.meshes.particle import SIZES, THINNED_WITHIN, Vertices, size_problem, thinned
from tablegen.meshes.solids import FlatError, mass_of, true_vertices
from tablegen.model.float_array import FloatArray

#: Kinds of files that can be read, by suffix.
SUFFIXES = (".stl", ".obj", ".ply")

#: Least size of an STL body over the steps of single precision in which its corners are rounded.
_LEAST_STEPS = 1e4

#: Least volume of a mesh over that of its convex hull that still counts as convex.
CONVEX = 0.999


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


def _lost_digits(points: FloatArray) -> str | None:
    """Say that a body is so far from the origin that single precision has changed its form."""
    step = float(np.spacing(np.float32(np.abs(points).max())))
    size = float(np.ptp(points, axis=0).max())
    single = np.array_equal(points, points.astype(np.float32))
    if not single or size >= _LEAST_STEPS * step:
        return None
    return f"far from the origin: a size of {size:.3g} in steps of {step:.3g}, which STL rounds to"


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
    if problem := size_problem(corners.reshape(-1, 3)):
        raise _refused(path, f"with {problem}", SIZES)
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
