"""A billiard of grains: they fly straight from wall to wall, and a law throws them back.

There is no gas. After each hit the speed of a grain is set back to the speed V of its chain, and
its spin is scaled in the same proportion. So the sixtieth hit is as fast as the first. Grains
bounce in one of two geometries (`GEOMETRIES`):

- "cylinder": inside a circular cylinder. Grains that roll along its wall meet it at ever flatter
  angles.
- "any": between walls of any direction, as between blades or in a bundle of pipes. Each wall is
  met at an angle from 5 to 85 degrees, in a random plane.

The law may be any that draws grains from keys and gives their velocities and spins in the lab
frame: a table, a `DirectModel`, or a test's own. The impacts to which a spin law is fitted come
from `tablegen.simulation.impact_chains` instead. There the grains are prescribed, the states are in
the axes of the walls, and a gas returns a grain to the wall that it left, whereas the wall of a
cylinder has turned about the spin.

Units are SI, and vectors are in the lab frame.
"""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.model.float_array import FloatArray
from tablegen.model.shapes import FIRST_MESH
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import normals_of_any_walls

#: Geometries, and their names in texts.
GEOMETRY_WORDS = {"cylinder": "in a cylinder", "any": "between walls of any direction"}
GEOMETRIES = tuple(GEOMETRY_WORDS)

#: Grains of each kind are chosen from this many particles.
_SEARCHED_PARTICLES = 500_000

#: Smallest sine of an impact angle, and largest spin times a/V. A flatter or faster spinning grain
#: is set to this limit on both sides. Direct simulation needs the limits: beyond them a grain turns
#: too many times before it touches the wall.
_SMALLEST_SINE, _LARGEST_SPIN = 1e-4, 10.0

#: Largest half-size a of a grain [m]. Results do not depend on it, because spins are compared times
#: a/V.
HALF_SIZE = 2e-5

#: A disc is an ellipsoid with b/a above the first of these ratios and c/b below the second. Discs
#: are compared separately, because they roll best.
_DISC = (0.9, 0.7)

#: Rows of an array of recorded variables: speed over V, sine of the angle from the wall, and size
#: of the spin times a/V.
SPEED_ROW, SINE_ROW, SPIN_ROW = range(3)


class Wall(Protocol):
    """Law of the wall: a table, a `DirectModel`, or any object with the same `rebound`."""

    def rebound(
        self,
        velocity: FloatArray,
        normal: FloatArray,
        half_size: float,
        *,
        omega: FloatArray,
        inertia: FloatArray,
        seed: int,
        index: NDArray[np.uint64],
        hit: int,
        threads: int | None,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return velocities (n, 3), angular velocities (n, 3) and inertias (n,) after the wall."""


class Arrivals(NamedTuple):
    """Grains just before their next walls; the inertia is over m a^2."""

    velocity: FloatArray
    normal: FloatArray
    omega: FloatArray
    inertia: FloatArray
    index: NDArray[np.uint64]  # type: ignore[assignment]  # hides tuple.index
    #: Number of walls met before.
    hit: int

    def first(self, count: int) -> "Arrivals":
        """Return the first ``count`` grains."""
        return Arrivals(
            self.velocity[:count],
            self.normal[:count],
            self.omega[:count],
            self.inertia[:count],
            self.index[:count],
            self.hit,
        )

    def rebound(self, wall: Wall, seed: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Let the grains rebound by the law of the wall."""
        return wall.rebound(
            self.velocity,
            self.normal,
            HALF_SIZE,
            omega=self.omega,
            inertia=self.inertia,
            seed=seed,
            index=self.index,
            hit=self.hit,
            threads=1,
        )


def kinds_of_grains(model: DirectModel, seed: int, count: int) -> dict[str, NDArray[np.uint64]]:
    """Find the indices of the first ``count`` particles of each kind, by the name of the kind.

    The kinds are the shapes of the population, and discs.
    """
    index = np.arange(_SEARCHED_PARTICLES, dtype=np.uint64)
    code, ratio_ba, ratio_cb = model.grains(seed, index).T
    names = {number: name for name, number in SHAPE_CODES.items()}
    kinds = {
        names.get(number, f"mesh {number - FIRST_MESH + 1}"): index[code == number][:count]
        for number in np.unique(code).astype(int).tolist()
    }
    flat = (code == SHAPE_CODES["ellipsoid"]) & (ratio_ba > _DISC[0]) & (ratio_cb < _DISC[1])
    if flat.any():
        kinds["disc"] = index[flat][:count]
    return kinds


def first_arrivals(
    index: NDArray[np.uint64], alpha1: FloatArray | float, speed: FloatArray | float
) -> Arrivals:
    """Put grains without spin before the wall y = 0, at angles [rad] and speeds [m/s]."""
    n = len(index)
    towards = np.broadcast_arrays(np.cos(alpha1), -np.sin(alpha1), np.zeros(n))
    velocity = np.broadcast_to(speed, n)[:, None] * np.stack(towards, axis=1)
    normal = np.tile([0.0, 1.0, 0.0], (n, 1))
    return Arrivals(velocity, normal, np.zeros((n, 3)), np.zeros(n), index, 0)


def follow_grains(
    wall: Wall, arrivals: Arrivals, geometry: str, seed: int, hits: int
) -> tuple[FloatArray, Arrivals]:
    """Follow n grains through a number of hits.

    Returns
    -------
    left : ndarray, shape (3, hits, n)
        Speed over V, sine of the angle from the wall, and size of the spin times a/V after each
        hit.
    arrivals : Arrivals
        The grains before the next wall.
    """
    speed = np.linalg.norm(arrivals.velocity, axis=1)
    left = np.empty((3, hits, len(speed)))
    for hit in range(hits):
        velocity, omega, inertia = arrivals.rebound(wall, seed)
        size = np.linalg.norm(velocity, axis=1)
        spin = HALF_SIZE * np.linalg.norm(omega, axis=1)
        sine = np.einsum("ni,ni->n", velocity, arrivals.normal) / size
        left[SPEED_ROW, hit] = size / speed
        left[SINE_ROW, hit] = sine
        left[SPIN_ROW, hit] = spin / speed
        scale = np.minimum(speed / size, _LARGEST_SPIN * speed / np.maximum(spin, 1e-300))
        velocity = velocity * (speed / size)[:, None]
        uniform = np.random.default_rng([seed % 2**64, arrivals.hit]).random((2, len(speed)))
        velocity, normal = _next_walls(velocity, arrivals.normal, geometry, uniform)
        arrivals = Arrivals(
            velocity, normal, omega * scale[:, None], inertia, arrivals.index, arrivals.hit + 1
        )
    return left, arrivals


def _next_walls(
    velocity: FloatArray, normal: FloatArray, geometry: str, uniform: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the velocities at the next walls, and the normals of these walls.

    ``uniform`` (2, n) are random numbers from 0 to 1, which give angle and plane in the geometry
    "any".
    """
    speed = np.linalg.norm(velocity, axis=1)
    if geometry == "any":
        return velocity, normals_of_any_walls(velocity / speed[:, None], *uniform)
    from_wall = np.einsum("ni,ni->n", velocity, normal)
    lift = np.maximum(_SMALLEST_SINE * speed - from_wall, 0.0)
    velocity = velocity + lift[:, None] * normal
    velocity *= (speed / np.linalg.norm(velocity, axis=1))[:, None]
    # The axis of the cylinder is z, and its radius 1. The chord of the flight, seen along the axis,
    # begins at -normal and ends where it meets the circle again.
    across = velocity * [1.0, 1.0, 0.0]
    squared = np.einsum("ni,ni->n", across, across)
    chord = 2.0 * np.einsum("ni,ni->n", across, normal) / squared
    normal = normal - chord[:, None] * across
    return velocity, normal / np.linalg.norm(normal, axis=1)[:, None]
