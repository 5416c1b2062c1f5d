"""Follow grains through sixty hits by a table and by direct simulation, and compare the two.

There is no gas. A grain flies straight from wall to wall, and after each hit its speed is set back
to the speed V of its chain, and its spin is scaled in the same proportion. So the sixtieth hit is
as fast as the first, and errors of a law that depends on the past can grow for as long as they do
in a cyclone. Grains bounce in one of two geometries (`GEOMETRIES`):

- "cylinder": inside a circular cylinder. Grains that settle into rolling meet its wall at ever
  flatter angles.
- "any": between walls of any direction, as between blades or in a bundle of pipes. Each wall is
  met at an angle from 5 to 85 degrees in a random plane.

Both sides have the same grains, speeds V and first angles. From there each side follows its own
rebounds, so that an error at one hit is carried to the next.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.accuracy.metrics import Estimate
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.model.shapes import FIRST_MESH
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import ANY_ANGLES, normals_at

#: Geometries, and how a text names them.
GEOMETRY_WORDS = {"cylinder": "in a cylinder", "any": "between walls of any direction"}
GEOMETRIES = tuple(GEOMETRY_WORDS)

#: First and last hit of the groups in which hits are compared. Grains do not spin before hit 1.
GROUPS = ((2, 2), (3, 6), (7, 10), (11, 20), (21, 40), (41, 60))

#: Grains of each kind a side, and the share of them that go on after a hit: the groups behind it
#: have more hits and need fewer grains.
SAMPLES, _GO_ON, _LAST_OF_ALL = 20_000, 0.4, 10

#: Number of the first particles among which grains of each kind are looked for.
_SEARCHED = 500_000

#: Range of the speeds V [m/s], as far as the table has them, and most of V over the table's highest
#: speed: a spin adds to the energy of a grain, and so to the speed that counts.
_SPEEDS, _OF_HIGHEST = (20.0, 150.0), 0.8

#: Least sine of an impact angle, which a grain that slides along the wall is given, and largest
#: spin times a/V. Direct simulation has such limits too, because a grain that meets a wall more
#: slowly, or turns faster, turns too often before the contact.
_LEAST_SINE, _MOST_SPIN = 1e-4, 10.0

#: Largest half-size a [m], which does not matter.
HALF_SIZE = 2e-5

#: Discs, which roll best, are ellipsoids with b/a above and c/b below these ratios.
_DISC = (0.9, 0.7)

#: Points of the distribution functions in Kolmogorov-Smirnov distances.
_QUANTILES = np.linspace(0.0, 1.0, 513)[1:-1]

#: Mean Kolmogorov-Smirnov distance of two samples of one law, the largest of three variables, over
#: the largest standard error of a difference of their distribution functions: 1.74 of one variable.
_KS_NOISE = 2.1

#: Variables of a grain that leaves a wall: speed over V, sine of the angle from the wall, |spin|
#: times a/V.
_SPEED, _SINE, _SPIN = range(3)


class Wall(Protocol):
    """Law of the wall: a table, a `DirectModel`, or anything with their `rebound`."""

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
        """Return velocities (n, 3), spins (n, 3) and inertias (n,) after the wall."""


class Arrivals(NamedTuple):
    """Grains that meet their next walls, in the lab frame; SI units, inertia over m a^2."""

    velocity: FloatArray
    normal: FloatArray
    omega: FloatArray
    inertia: FloatArray
    index: NDArray[np.uint64]  # type: ignore[assignment]  # hides tuple.index
    #: Walls met before.
    hit: int

    def first(self, count: int) -> "Arrivals":
        """Select the first grains."""
        return Arrivals(
            self.velocity[:count],
            self.normal[:count],
            self.omega[:count],
            self.inertia[:count],
            self.index[:count],
            self.hit,
        )

    def rebound(self, wall: Wall, seed: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rebound from the walls by a law."""
        velocity, normal, omega, inertia, index, hit = self
        return wall.rebound(
            velocity,
            normal,
            HALF_SIZE,
            omega=omega,
            inertia=inertia,
            seed=seed,
            index=index,
            hit=hit,
            threads=1,
        )


@dataclass(frozen=True)
class LaterHit:
    """Table against direct simulation at a group of hits of a chain."""

    #: Hits, kind of grains and geometry in words.
    place: str
    #: By limit: ``chain_ks``, ``chain_energy``, ``chain_spin``, ``chain_angle``.
    estimates: dict[str, Estimate]
    #: Of the table and of direct simulation: share of its translational energy that a grain keeps
    #: at a hit, mean squared spin after it times (a/V)^2, and median angle at which it leaves.
    energy: tuple[float, float]
    spin: tuple[float, float]
    angle_deg: tuple[float, float]

    def to_dict(self) -> dict[str, Any]:
        """Give every number for JSON."""
        return asdict(self)


def kinds_of_grains(
    model: DirectModel, seed: int, count: int = SAMPLES
) -> dict[str, NDArray[np.uint64]]:
    """Find the indices of the first ``count`` particles of each shape, and of discs, by name."""
    index = np.arange(_SEARCHED, dtype=np.uint64)
    code, *ratios = model.grains(seed, index).T
    names = {number: name for name, number in SHAPE_CODES.items()}
    kinds = {
        names.get(number, f"mesh {number - FIRST_MESH + 1}"): index[code == number][:count]
        for number in np.unique(code).astype(int).tolist()
    }
    flat = (code == SHAPE_CODES["ellipsoid"]) & (ratios[0] > _DISC[0]) & (ratios[1] < _DISC[1])
    if flat.any():
        kinds["disc"] = index[flat][:count]
    return kinds


def first_arrivals(
    index: NDArray[np.uint64], alpha1: FloatArray | float, speed: FloatArray | float
) -> Arrivals:
    """Let grains without spin meet the wall y = 0 at angles [rad] and speeds [m/s]."""
    n = len(index)
    towards = np.broadcast_arrays(np.cos(alpha1), -np.sin(alpha1), np.zeros(n))
    velocity = np.broadcast_to(speed, n)[:, None] * np.stack(towards, axis=1)
    normal = np.tile([0.0, 1.0, 0.0], (n, 1))
    return Arrivals(velocity, normal, np.zeros((n, 3)), np.zeros(n), index, 0)


def follow(
    wall: Wall, arrivals: Arrivals, geometry: str, seed: int, hits: int
) -> tuple[FloatArray, Arrivals]:
    """Follow grains through some hits.

    Returns speed over V, sine of the angle from the wall and |spin| times a/V with which grains
    leave each wall, (3, hits, n), and how they meet the next wall.
    """
    speed = np.linalg.norm(arrivals.velocity, axis=1)
    left = np.empty((3, hits, len(speed)))
    for hit in range(hits):
        velocity, omega, inertia = arrivals.rebound(wall, seed)
        size = np.linalg.norm(velocity, axis=1)
        spin = HALF_SIZE * np.linalg.norm(omega, axis=1)
        sine = np.einsum("ni,ni->n", velocity, arrivals.normal) / size
        left[_SPEED, hit], left[_SINE, hit], left[_SPIN, hit] = size / speed, sine, spin / speed
        scale = np.minimum(speed / size, _MOST_SPIN * speed / np.maximum(spin, 1e-300))
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
    """Fly to the next walls; returns the velocities, and the normals there.

    ``uniform`` (2, n) are random numbers from 0 to 1 for walls of any direction: angle and plane.
    """
    speed = np.linalg.norm(velocity, axis=1)
    if geometry == "any":
        low, high = ANY_ANGLES
        alpha1 = low + (high - low) * uniform[0]
        return velocity, normals_at(velocity / speed[:, None], alpha1, uniform[1])
    from_wall = np.einsum("ni,ni->n", velocity, normal)
    lift = np.maximum(_LEAST_SINE * speed - from_wall, 0.0)
    velocity = velocity + lift[:, None] * normal
    velocity *= (speed / np.linalg.norm(velocity, axis=1))[:, None]
    # the axis is z: the chord ends where the circle of radius 1 around it is met again
    across = velocity * [1.0, 1.0, 0.0]
    squared = np.einsum("ni,ni->n", across, across)
    chord = 2.0 * np.einsum("ni,ni->n", across, normal) / squared
    normal = normal - chord[:, None] * across
    return velocity, normal / np.linalg.norm(normal, axis=1)[:, None]


def compare_chain(
    wall: Wall,
    config: Config,
    kind: tuple[str, NDArray[np.uint64]],
    geometry: str,
    seed: int,
) -> list[LaterHit]:
    """Follow grains of a kind, a name and indices, on both sides; compare each of the `GROUPS`.

    Speeds V and first angles are spread evenly over their ranges.
    """
    name, index = kind
    low, high = config.domain.speed
    slow, fast = np.clip(_SPEEDS, low, max(low, _OF_HIGHEST * high))
    spread = np.random.default_rng([seed % 2**64, len(index)]).random((2, len(index)))
    # later hits have any angle, whatever the domain is
    flat, steep = np.clip(ANY_ANGLES, *np.radians(config.domain.alpha_deg))
    alpha1 = flat + (steep - flat) * spread[0]
    arrivals = first_arrivals(index, alpha1, slow + (fast - slow) * spread[1])
    sides = []
    for law in (wall, DirectModel(config)):
        early, on = follow(law, arrivals, geometry, seed, _LAST_OF_ALL)
        few = on.first(max(round(_GO_ON * len(index)), 2))
        late, _ = follow(law, few, geometry, seed, GROUPS[-1][1] - _LAST_OF_ALL)
        sides.append((early, late))
    compared = []
    for first, last in GROUPS:
        part = int(first > _LAST_OF_ALL)
        rows = slice(first - 1 - part * _LAST_OF_ALL, last - part * _LAST_OF_ALL)
        hits = f"hit {first}" if first == last else f"hits {first} to {last}"
        place = f"{hits}, {name} {GEOMETRY_WORDS[geometry]}"
        compared.append(later_hit(place, *(side[part][:, rows] for side in sides)))
    return compared


def later_hit(place: str, table: FloatArray, direct: FloatArray) -> LaterHit:
    """Compare what leaves walls at some hits, (3, hits, n) as of `follow`, pair by pair of grains.

    Hits of one grain depend on each other, and so do both sides, which have the same grains. So
    standard errors are those of means over n differences of pairs, each averaged over hits.
    """
    energies, spins = ([side[k] ** 2 for side in (table, direct)] for k in (_SPEED, _SPIN))
    medians = [float(np.median(side[_SINE])) for side in (table, direct)]
    estimates = {
        "chain_ks": _ks(table, direct),
        "chain_energy": _mean_difference(*energies),
        "chain_spin": _mean_ratio(*spins),
        "chain_angle": _median_ratio(table[_SINE], direct[_SINE]),
    }
    angles = np.degrees(np.arcsin(medians))
    return LaterHit(
        place,
        estimates,
        energy=(float(energies[0].mean()), float(energies[1].mean())),
        spin=(float(spins[0].mean()), float(spins[1].mean())),
        angle_deg=(float(angles[0]), float(angles[1])),
    )


def _standard_error(of_hits: FloatArray) -> float:
    """Compute the standard error of the mean of numbers of hits, (hits, n), of n grains."""
    of_grains = of_hits.mean(axis=0)
    return float(of_grains.std() / np.sqrt(of_grains.size))


def _mean_difference(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate how far two means are apart."""
    difference = table - direct
    return Estimate(abs(float(difference.mean())), _standard_error(difference))


def _mean_ratio(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate how far the ratio of two means of positive numbers is from 1."""
    ratio, mean = float(table.mean() / direct.mean()), float(direct.mean())
    return Estimate(abs(ratio - 1.0), _standard_error(table - ratio * direct) / mean)


def _median_ratio(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate how far the ratio of two medians of positive numbers is from 1."""
    low, median, high = np.quantile(direct, (0.45, 0.5, 0.55))
    ratio = float(np.median(table) / median)
    # a share that is off moves a median by as much over the density there
    above = (table > ratio * median).astype(float) - (direct > median)
    slope = (high - low) / 0.1
    return Estimate(abs(ratio - 1.0), float(_standard_error(above) * slope / median))


def _ks(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate the largest Kolmogorov-Smirnov distance of a variable.

    The error is the largest standard error of a difference of distribution functions, and a third
    of the distance that two samples of one law have (`tablegen.accuracy.metrics`).
    """
    values, errors = [], []
    for a, b in zip(table, direct, strict=True):
        points = np.quantile(b, _QUANTILES)
        below = [np.searchsorted(np.sort(x, axis=None), points) / x.size for x in (a, b)]
        values.append(float(np.abs(below[0] - below[1]).max()))
        thirds = np.quantile(b, (0.25, 0.5, 0.75))
        errors.append(max(_standard_error((a < x).astype(float) - (b < x)) for x in thirds))
    return Estimate(max(values), (1.0 + _KS_NOISE / 3.0) * max(errors), tuple(values))


def chains_of(
    wall: Wall, config: Config, seed: int, samples: int | None = None
) -> list[Callable[[], list[LaterHit]]]:
    """List the comparisons of a law of the wall with direct simulation, each to be called.

    There is one for each kind of grains in each geometry. ``samples`` are the grains of a kind a
    side, by default and at most `SAMPLES`.
    """
    count = min(samples or SAMPLES, SAMPLES)
    kinds = kinds_of_grains(DirectModel(config), seed, count)
    return [
        partial(compare_chain, wall, config, kind, geometry, seed)
        for kind, geometry in product(kinds.items(), GEOMETRIES)
    ]
