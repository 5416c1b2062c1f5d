"""A particle of any convex shape: the convex hull of points, of uniform density.

Its frame is that of the other shapes: centre of mass at the origin, principal axes with
j1 <= j2 <= j3, and the half-size a, half of the extent along the first axis, as the unit of length.
So neither the units of the points nor their pose matter; a mirror image is another particle.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from sampler.errors import InputError
from sampler.formats.bounds import LEAST_RATIO
from sampler.formats.shape_geometry import Geometry
from tablegen.meshes.solids import FlatError, mass_of, principal_axes, true_vertices
from tablegen.meshes.support_map_builder import SLACK, make_map
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import MESH_SIZE
from tablegen.model.shapes import Body, MeshArguments, SupportMap, longest_list

#: Most vertices of a hull, which a configuration carries all; a hull of more is thinned.
MOST_VERTICES = 10_000

#: Distance of a left-out corner from the faces of a thinned hull, over the largest extent, that
#: qhull allows, and the tolerance that is stated: merging faces, qhull overshoots by a tenth.
_THINNING = 4e-4
THINNED_WITHIN = 5e-4

#: Sizes of points that are allowed, in words.
SIZES = f"coordinates up to {MESH_SIZE.high:g}, a largest extent of {MESH_SIZE.low:g} or more"

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

    def ordered_sizes(self) -> tuple[float, float]:
        """Find b and c over a, as of other grains: the ratios b/a and c/b are at most 1.

        The moments of inertia decide the order of the axes, so that the extent along the second or
        the third may be the largest.
        """
        _, b, c = self.half_sizes
        b_over_a = min(max(b, LEAST_RATIO), 1.0)
        return b_over_a, b_over_a * min(max(c / b, LEAST_RATIO), 1.0)

    def geometry(self) -> Geometry:
        """Compute volume, moment and surface. The ratios are fixed; the surface is as of a box."""
        b, c = self.ordered_sizes()
        hull, mean_moment = ConvexHull(self.vertices), float(self.moments.mean())
        surface = float(hull.area) / (b + b * c + c)
        volume, moment = float(hull.volume) / (b * c), mean_moment / (1.0 + b * b + c * c)
        return Geometry(volume, moment, surface, 0.0)

    def body(self) -> Body:
        """Return the particle as the mechanics takes it."""
        j1, j2, j3 = self.moments.tolist()
        a, b, c = self.reach.tolist()
        candidates = np.zeros((longest_list(self.support_map), 3))
        counts = np.zeros(1, dtype=np.int64)
        return Body(
            (j1, j2, j3), candidates, counts, (a, b, c), self.bounding_radius, self.support_map
        )


def mesh_particle(vertices: ArrayLike) -> MeshParticle:
    """Make a particle of the convex hull of points (n, 3), in any units and axes.

    Raises `InputError` if there are fewer than four points, one that is not finite, a size outside
    of `MESH_SIZE`, or they lie in a plane. See `thinned` for a hull of many corners.
    """
    points = np.asarray(vertices, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 4:
        allowed = "4 or more rows of three numbers"
        raise InputError("vertices", f"shape {points.shape}", allowed)
    if problem := size_problem(points):
        raise InputError("vertices", problem, SIZES)
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


def thinned(corners: FloatArray) -> FloatArray:
    """Leave out corners of a convex hull of more than `MOST_VERTICES`, and return the others.

    Those that are left out lie within `THINNED_WITHIN` of the new hull, over the largest extent.
    """
    if len(corners) <= MOST_VERTICES:
        return corners
    scaled = (corners - corners.mean(axis=0)) / np.ptp(corners, axis=0).max()
    kept = corners[np.sort(ConvexHull(scaled, qhull_options=f"W{_THINNING}").vertices)]
    return kept[true_vertices(kept)]


def size_problem(points: FloatArray) -> str | None:
    """Say why points are too large or too small; None if they are not, or all in one place."""
    largest = np.abs(points).max()
    if not largest <= MESH_SIZE.high:  # NaN is not either
        return f"a coordinate of {largest:g}"
    extent = np.ptp(points, axis=0).max()
    return f"an extent of {extent:g}" if 0.0 < extent < MESH_SIZE.low else None


def mesh_arguments(particles: Sequence[MeshParticle]) -> MeshArguments:
    """Put meshes one after another in arrays, for kernels."""
    maps = [particle.support_map for particle in particles]
    lengths = [(len(one.starts), len(one.points)) for one in maps]
    firsts = np.zeros((len(particles) + 1, 2), dtype=np.int64)
    np.cumsum(np.array(lengths, dtype=np.int64).reshape(-1, 2), axis=0, out=firsts[1:])
    sizes = [(*p.ordered_sizes(), p.bounding_radius) for p in particles]
    none = np.empty((0, 3))
    return MeshArguments(
        moments=np.array([p.moments for p in particles]).reshape(-1, 3),
        sizes=np.array(sizes, dtype=np.float64).reshape(-1, 3),
        reach=np.array([p.reach for p in particles]).reshape(-1, 3),
        firsts=firsts,
        resolutions=np.array([one.resolution for one in maps], dtype=np.int64),
        slack=SLACK,
        longest=max((longest_list(one) for one in maps), default=0),
        starts=np.concatenate([np.zeros(0, dtype=np.int64), *(one.starts for one in maps)]),
        points=np.concatenate([none, *(one.points for one in maps)]),
    )
