"""Follow grains through sixty hits by a table and by direct simulation, and compare the two.

There is no gas. A grain flies straight from wall to wall. After each hit its speed is set back to
the speed V of its chain, and its spin is scaled in the same proportion. So the sixtieth hit is as
fast as the first, and an error of the spin law can grow from hit to hit as it would in a cyclone.
Grains bounce in one of two geometries (`GEOMETRIES`):

- "cylinder": inside a circular cylinder. Grains that roll along its wall meet it at ever flatter
  angles.
- "any": between walls of any direction, as between blades or in a bundle of pipes. Each wall is
  met at an angle from 5 to 85 degrees, in a random plane.

Both sides begin with the same grains, speeds V and first angles. From then on each side follows its
own rebounds, so that an error at one hit is carried to the next.

After each hit three variables are recorded: the speed q over V, the sine s of the angle between the
velocity and the wall, and the size w of the spin times a/V. Four numbers compare the table (t) with
direct simulation (d) at a group of hits. Means, medians and distribution functions are over all
grains and all hits of the group:

================  =======================================  ======================================
limit             number                                   averaged over the hits of a grain
================  =======================================  ======================================
``chain_ks``      max over q, s, w of max_x |F_t - F_d|    [t < x] - [d < x], at the quartiles x
``chain_energy``  |mean q_t^2 - mean q_d^2|                q_t^2 - q_d^2
``chain_spin``    |R - 1|, R = mean w_t^2 / mean w_d^2     (w_t^2 - R w_d^2) / mean w_d^2
``chain_angle``   |R - 1|, R = median s_t / median s_d     ([s_t > R m] - [s_d > m]) / (f m)
``chain_slow``    |P_t - P_d| / max(P_d, .001) of qs < .03 ([q_t s_t < .03] - [...]) / max(...)
``chain_flat``    |P_t - P_d| / max(P_d, .01), s < sin 10  ([s_t < sin 10] - [...]) / max(...)
================  =======================================  ======================================

The gap of distribution functions is that of Kolmogorov and Smirnov, but differences of
`tablegen.accuracy.metrics.TOLERANCE` in a variable do not count. Slow departures decide where
grains come to rest, and flat ones how often they meet the next wall; medians and means see neither.

Here m is the median of s_d, f the density of s_d there, and [...] is 1 if the condition is true,
else 0. The hits of a grain depend on each other, and the two sides depend on each other because
they have the same grains. Therefore the quantity of the last column is averaged over the hits of
each grain. The standard error is the standard deviation of these averages over the square root of
their number.

Units are SI, and vectors are in the lab frame.
"""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from sampler.formats.shape_codes import SHAPE_CODES
from tablegen.accuracy.metrics import TOLERANCE, Estimate
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.model.shapes import FIRST_MESH
from tablegen.simulation.direct import DirectModel, silent_model
from tablegen.simulation.impact_chains import ANY_ANGLES, normals_at

#: Geometries, and their names in texts.
GEOMETRY_WORDS = {"cylinder": "in a cylinder", "any": "between walls of any direction"}
GEOMETRIES = tuple(GEOMETRY_WORDS)

#: First and last hit of each group of hits that are compared together. Hit 1 is left out, because
#: grains do not spin before it.
GROUPS = ((2, 2), (3, 6), (7, 10), (11, 20), (21, 40), (41, 60))

#: Number of grains of each kind on each side.
SAMPLES = 20_000

#: All grains are followed to this hit. Later groups have more hits and need fewer grains, so that
#: only this share of the grains goes on.
_LAST_HIT_OF_ALL, _SHARE_AFTER = 10, 0.4

#: Grains of each kind are chosen from this many particles.
_SEARCHED_PARTICLES = 500_000

#: Range of the speeds V [m/s], cut to the range of the table, and uniform in the logarithm. V is
#: also at most this share of the table's highest speed: a spin adds to the energy of a grain, and
#: so to the effective speed at which the spin law is read.
_SPEEDS, _LARGEST_SPEED_SHARE = (15.0, 150.0), 0.8

#: A departure is slow if its normal velocity is below this share of V, and flat if its angle from
#: the wall has a smaller sine than this one, of 10 degrees. Shares of rebounds that are smaller
#: than these two count as these.
_SLOW, _FLAT = 0.03, math.sin(math.radians(10.0))
_LEAST_SLOW, _LEAST_FLAT = 1e-3, 1e-2

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

#: Probabilities at whose quantiles (of direct simulation) distribution functions are compared.
_QUANTILES = np.linspace(0.0, 1.0, 513)[1:-1]

#: Noise of the largest of three Kolmogorov-Smirnov distances, in units of the largest standard
#: error of a difference of distribution functions. For one variable it is 1.74.
_KS_NOISE = 2.1

#: Rows of an array of recorded variables: speed over V, sine of the angle from the wall, and size
#: of the spin times a/V.
_SPEED, _SINE, _SPIN = range(3)


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


@dataclass(frozen=True)
class LaterHit:
    """Comparison of a table with direct simulation at a group of hits of a chain.

    The last three fields have two numbers each: of the table, and of direct simulation.
    """

    #: Hits, kind of grains and geometry in words.
    place: str
    #: Estimates by the names of the limits.
    estimates: dict[str, Estimate]
    #: Mean share of its translational energy that a grain keeps at a hit; mean squared spin after a
    #: hit, times (a/V)^2; median angle between the wall and the velocity after a hit.
    energy: tuple[float, float]
    spin: tuple[float, float]
    angle_deg: tuple[float, float]

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers as a dictionary for JSON."""
        return asdict(self)


def kinds_of_grains(
    model: DirectModel, seed: int, count: int = SAMPLES
) -> dict[str, NDArray[np.uint64]]:
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
        left[_SPEED, hit] = size / speed
        left[_SINE, hit] = sine
        left[_SPIN, hit] = spin / speed
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
        low, high = ANY_ANGLES
        alpha1 = low + (high - low) * uniform[0]
        return velocity, normals_at(velocity / speed[:, None], alpha1, uniform[1])
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


def compare_chain(
    wall: Wall,
    config: Config,
    kind: tuple[str, NDArray[np.uint64]],
    geometry: str,
    seed: int,
) -> list[LaterHit]:
    """Follow the grains of one kind on both sides, and compare each of the `GROUPS` of hits.

    ``kind`` is its name and the indices of the grains (`kinds_of_grains`). First angles
    are uniform over their range, and speeds V in the logarithm.
    """
    name, index = kind
    low, high = config.domain.speed
    slow, fast = np.clip(_SPEEDS, low, max(low, _LARGEST_SPEED_SHARE * high))
    spread = np.random.default_rng([seed % 2**64, len(index)]).random((2, len(index)))
    # Only the first angle is kept inside the domain. Later angles follow from the geometry.
    flat, steep = np.clip(ANY_ANGLES, *np.radians(config.domain.alpha_deg))
    alpha1 = flat + (steep - flat) * spread[0]
    arrivals = first_arrivals(index, alpha1, slow * (fast / slow) ** spread[1])
    sides = []
    for law in (wall, silent_model(config)):
        early, on = follow_grains(law, arrivals, geometry, seed, _LAST_HIT_OF_ALL)
        few = on.first(max(round(_SHARE_AFTER * len(index)), 2))
        late, _ = follow_grains(law, few, geometry, seed, GROUPS[-1][1] - _LAST_HIT_OF_ALL)
        sides.append((early, late))
    compared = []
    for first, last in GROUPS:
        part = int(first > _LAST_HIT_OF_ALL)
        rows = slice(first - 1 - part * _LAST_HIT_OF_ALL, last - part * _LAST_HIT_OF_ALL)
        hits = f"hit {first}" if first == last else f"hits {first} to {last}"
        place = f"{hits}, {name} {GEOMETRY_WORDS[geometry]}"
        compared.append(later_hit(place, *(side[part][:, rows] for side in sides)))
    return compared


def later_hit(place: str, table: FloatArray, direct: FloatArray) -> LaterHit:
    """Compare the variables (3, hits, n) of `follow_grains` at a group of hits.

    Column i of both sides is the same grain. The head of this module has the formulae.
    """
    energies, spins = ([side[k] ** 2 for side in (table, direct)] for k in (_SPEED, _SPIN))
    medians = [float(np.median(side[_SINE])) for side in (table, direct)]
    slow_table, slow_direct = (side[_SPEED] * side[_SINE] < _SLOW for side in (table, direct))
    estimates = {
        "chain_ks": _ks(table, direct),
        "chain_energy": _mean_difference(*energies),
        "chain_spin": _mean_ratio(*spins),
        "chain_angle": _median_ratio(table[_SINE], direct[_SINE]),
        "chain_slow": _share_ratio(slow_table, slow_direct, _LEAST_SLOW),
        "chain_flat": _share_ratio(table[_SINE] < _FLAT, direct[_SINE] < _FLAT, _LEAST_FLAT),
    }
    angles = np.degrees(np.arcsin(medians))
    return LaterHit(
        place,
        estimates,
        energy=(float(energies[0].mean()), float(energies[1].mean())),
        spin=(float(spins[0].mean()), float(spins[1].mean())),
        angle_deg=(float(angles[0]), float(angles[1])),
    )


def _standard_error(values: FloatArray) -> float:
    """Compute the standard error of the mean of values (hits, n); the n grains are independent."""
    means = values.mean(axis=0)
    return float(means.std() / np.sqrt(means.size))


def _mean_difference(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate |mean(table) - mean(direct)|."""
    difference = table - direct
    return Estimate(abs(float(difference.mean())), _standard_error(difference))


def _mean_ratio(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate |mean(table) / mean(direct) - 1| of positive numbers."""
    ratio, mean = float(table.mean() / direct.mean()), float(direct.mean())
    return Estimate(abs(ratio - 1.0), _standard_error(table - ratio * direct) / mean)


def _median_ratio(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate |median(table) / median(direct) - 1| of positive numbers."""
    low, median, high = np.quantile(direct, (0.45, 0.5, 0.55))
    ratio = float(np.median(table) / median)
    # An error of the share above the median moves the median by this error over the density.
    above = (table > ratio * median).astype(float) - (direct > median)
    inverse_density = (high - low) / 0.1
    return Estimate(abs(ratio - 1.0), float(_standard_error(above) * inverse_density / median))


def _share_ratio(table: NDArray[np.bool_], direct: NDArray[np.bool_], least: float) -> Estimate:
    """Estimate the error of a share of rebounds over the share, or over ``least`` if it is less."""
    over = max(float(direct.mean()), least)
    estimate = _mean_difference(table.astype(float), direct.astype(float))
    return Estimate(estimate.value / over, estimate.error / over)


def _ks(table: FloatArray, direct: FloatArray) -> Estimate:
    """Estimate the largest gap of distribution functions of any of the three variables.

    The standard error is the largest at the three quartiles, of all variables. As in
    `tablegen.accuracy.metrics`, the error is this plus a third of the noise.
    """
    values, errors = [], []
    for a, b in zip(table, direct, strict=True):
        points = np.quantile(b, _QUANTILES)
        low, high, below = (
            np.searchsorted(np.sort(x, axis=None), points + shift) / x.size
            for x, shift in ((a, -TOLERANCE), (a, TOLERANCE), (b, 0.0))
        )
        values.append(max(float((low - below).max()), float((below - high).max()), 0.0))
        quartiles = np.quantile(b, (0.25, 0.5, 0.75))
        errors.append(max(_standard_error((a < x).astype(float) - (b < x)) for x in quartiles))
    return Estimate(max(values), (1.0 + _KS_NOISE / 3.0) * max(errors), tuple(values))


def chain_comparisons(
    wall: Wall, config: Config, seed: int, samples: int | None = None
) -> list[Callable[[], list[LaterHit]]]:
    """Return functions that each compare a law of the wall with direct simulation when called.

    There is one for each kind of grains in each geometry, for `tablegen.parallel.in_threads`.
    ``samples`` is the number of grains of a kind on each side; default and maximum are `SAMPLES`.
    """
    count = min(samples or SAMPLES, SAMPLES)
    kinds = kinds_of_grains(silent_model(config), seed, count)
    return [
        partial(compare_chain, wall, config, kind, geometry, seed)
        for kind, geometry in product(kinds.items(), GEOMETRIES)
    ]
