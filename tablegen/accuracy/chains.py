"""Follow grains through sixty hits by a table and by direct simulation, and compare the two.

`tablegen.simulation.billiard` follows the grains. Both sides begin with the same grains, speeds V
and first angles. From then on each side follows its own rebounds, so that an error at one hit is
carried to the next, and can grow as it would in a cyclone.

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
"""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tablegen.accuracy.metrics import TOLERANCE, Estimate
from tablegen.config.config import Config, Domain
from tablegen.model.float_array import FloatArray
from tablegen.simulation.billiard import (
    GEOMETRIES,
    GEOMETRY_WORDS,
    SINE_ROW,
    SPEED_ROW,
    SPIN_ROW,
    Wall,
    first_arrivals,
    follow_grains,
    kinds_of_grains,
)
from tablegen.simulation.direct import model_without_warnings
from tablegen.simulation.impact_chains import ANY_ANGLES

#: First and last hit of each group of hits that are compared together. Hit 1 is left out, because
#: grains do not spin before it.
GROUPS = ((2, 2), (3, 6), (7, 10), (11, 20), (21, 40), (41, 60))

#: Number of grains of each kind on each side.
SAMPLES = 20_000

#: All grains are followed to this hit. Later groups have more hits and need fewer grains, so that
#: only this share of the grains goes on.
_LAST_HIT_OF_ALL, _SHARE_AFTER = 10, 0.4

#: Range of the speeds V [m/s], cut to the range of the table, and uniform in the logarithm. V is
#: also at most this share of the table's highest speed: a spin adds to the energy of a grain, and
#: so to the effective speed at which the spin law is read.
_SPEEDS, _LARGEST_SPEED_SHARE = (15.0, 150.0), 0.8

#: A departure is slow if its normal velocity is below this share of V, and flat if its angle from
#: the wall has a smaller sine than this one, of 10 degrees. Shares of rebounds that are smaller
#: than these two count as these.
_SLOW, _FLAT = 0.03, math.sin(math.radians(10.0))
_LEAST_SLOW, _LEAST_FLAT = 1e-3, 1e-2

#: Probabilities at whose quantiles (of direct simulation) distribution functions are compared.
_QUANTILES = np.linspace(0.0, 1.0, 513)[1:-1]

#: Noise of the largest of three Kolmogorov-Smirnov distances, in units of the largest standard
#: error of a difference of distribution functions. For one variable it is 1.74.
_KS_NOISE = 2.1


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


def compare_chain(
    wall: Wall,
    direct: Wall,
    domain: Domain,
    kind: tuple[str, NDArray[np.uint64]],
    geometry: str,
    seed: int,
) -> list[LaterHit]:
    """Follow the grains of one kind on both sides, and compare each of the `GROUPS` of hits.

    ``direct`` is direct simulation, ``domain`` the range of the table, and ``kind`` the name of the
    kind and the indices of its grains (`kinds_of_grains`). First angles are uniform over their
    range, and speeds V in the logarithm.
    """
    name, index = kind
    low, high = domain.speed
    slow, fast = np.clip(_SPEEDS, low, max(low, _LARGEST_SPEED_SHARE * high))
    spread = np.random.default_rng([seed % 2**64, len(index)]).random((2, len(index)))
    # Only the first angle is kept inside the domain. Later angles follow from the geometry.
    flat, steep = np.clip(ANY_ANGLES, *np.radians(domain.alpha_deg))
    alpha1 = flat + (steep - flat) * spread[0]
    arrivals = first_arrivals(index, alpha1, slow * (fast / slow) ** spread[1])
    sides = []
    for law in (wall, direct):
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
    energies, spins = ([side[k] ** 2 for side in (table, direct)] for k in (SPEED_ROW, SPIN_ROW))
    medians = [float(np.median(side[SINE_ROW])) for side in (table, direct)]
    slow_table, slow_direct = (side[SPEED_ROW] * side[SINE_ROW] < _SLOW for side in (table, direct))
    estimates = {
        "chain_ks": _ks(table, direct),
        "chain_energy": _mean_difference(*energies),
        "chain_spin": _mean_ratio(*spins),
        "chain_angle": _median_ratio(table[SINE_ROW], direct[SINE_ROW]),
        "chain_slow": _share_ratio(slow_table, slow_direct, _LEAST_SLOW),
        "chain_flat": _share_ratio(table[SINE_ROW] < _FLAT, direct[SINE_ROW] < _FLAT, _LEAST_FLAT),
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
    direct = model_without_warnings(config)
    kinds = kinds_of_grains(direct, seed, count)
    return [
        partial(compare_chain, wall, direct, config.domain, kind, geometry, seed)
        for kind, geometry in product(kinds.items(), GEOMETRIES)
    ]
