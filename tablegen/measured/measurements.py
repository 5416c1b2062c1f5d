"""Measured rebound statistics: the quantities, the record of a file, and its rows.

A quantity is one number of each rebound; its mean and its standard deviation over many particles
are measured. With u, v, w the velocity after the impact over the impact speed V, in the wall frame
(x along the tangential velocity before the impact, y into the gas), and the impact angle alpha from
the wall:

- e_n = v / sin(alpha), normal restitution of the centre of mass;
- e_t = u / cos(alpha), tangential restitution, undefined at 90 degrees;
- rebound_angle_deg: the mean is the angle of the mean velocity from the wall, atan2(mean v, mean
  u); the spread is that of the particles' own angles atan2(v, u), both in the impact plane;
- out_of_plane_deg = asin(w / sqrt(u^2 + v^2 + w^2)), angle between velocity and impact plane;
- omega_z: spin about z times a / V, negative for a particle that rolls forward.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sampler.errors import InputError
from tablegen.config.pairs import MaterialPair
from tablegen.model.float_array import FloatArray

#: End of the name of a column of standard deviations.
SPREAD = "_std"

#: Impact speed [m/s] of rows without one if the rebounds do not depend on it.
ANY_SPEED = 100.0

#: Speeds that differ by less than this part are one.
_SAME_SPEED = 0.03

#: Rise of e_n with the angle from which angles are doubted: with known materials e_n falls.
_DOUBTED_RISE = 0.1


@dataclass(frozen=True)
class Quantity:
    """A number of a rebound that can be measured."""

    #: Column of `tablegen.measured.moments.variables_of`.
    variable: int
    #: Heading of its table, and label of its axis.
    title: str
    label: str
    #: Number of decimals in tables.
    digits: int = 3
    #: How far a simulated mean may be off, unless its count of particles allows more.
    tolerance: float = 0.04


#: Quantities by the name of their column.
QUANTITIES: Mapping[str, Quantity] = {
    "e_n": Quantity(
        1, "e_n, normal restitution v+/|v-|", r"normal restitution $v^+/|v^-|$", tolerance=0.02
    ),
    "e_t": Quantity(
        0, "e_t, tangential restitution u+/u-", r"tangential restitution $u^+/u^-$", tolerance=0.03
    ),
    "rebound_angle_deg": Quantity(
        2,
        "rebound angle from the wall [degrees]",
        "rebound angle from the wall [°]",
        digits=2,
        tolerance=2.0,
    ),
    # by symmetry its mean is 0
    "out_of_plane_deg": Quantity(
        3, "angle out of the impact plane [degrees]", "angle out of the impact plane [°]", digits=2
    ),
    "omega_z": Quantity(4, "omega_z, spin times a/V", r"spin $\Omega_z^+\,a/V$"),
}


class Moments(NamedTuple):
    """Mean and standard deviation of one quantity at each of n conditions; NaN: not measured."""

    #: Shape (n,).
    mean: FloatArray
    std: FloatArray


@dataclass(frozen=True)
class Measurements:
    """Measured rebounds at n impact conditions, from `read_measurements`.

    Attributes
    ----------
    name : str
        Name of the file, without its ending.
    alpha_deg : float64 array, shape (n,)
        Impact angles from the wall [degrees].
    speed : float64 array, shape (n,)
        Impact speeds [m/s]; NaN if not stated.
    moments : dict of Moments
        Means and standard deviations by the name of the quantity, shape (n,) each; NaN if not
        measured. The quantities are e_n, e_t, rebound_angle_deg, out_of_plane_deg and omega_z.
    count : float64 array, shape (n,)
        Numbers of particles; NaN if not stated.
    source : tuple of str
        Where each row comes from.
    remarks : tuple of str
        Notes on each row.
    about : dict of str
        Comments ``# key: value`` at the top of the file, such as title, particle and wall.
    """

    name: str
    alpha_deg: FloatArray
    speed: FloatArray
    moments: Mapping[str, Moments]
    count: FloatArray
    source: tuple[str, ...]
    remarks: tuple[str, ...]
    about: Mapping[str, str]

    def errors(self, quantity: str) -> Moments:
        """Compute the standard errors of the means and spreads of a quantity from the counts.

        They are NaN if a count or a spread is not known. The error of a spread is that of a normal
        law.
        """
        error = self.moments[quantity].std / np.sqrt(self.count)
        return Moments(error, error / np.sqrt(2.0))

    @property
    def doubt(self) -> str:
        """Sentence on what looks wrong in e_n and e_t; "" if nothing does."""
        known = np.isfinite(self.moments["e_n"].mean)
        angle, e_n = self.alpha_deg[known], self.moments["e_n"].mean[known]
        if (
            np.unique(angle).size > 1
            and np.polyfit(angle, e_n, 1)[0] * np.ptp(angle) > _DOUBTED_RISE
        ):
            return "e_n rises with the angle: if angles are from the normal, give 90 - angle"
        for name in ("e_n", "e_t"):
            above = self.alpha_deg[self.moments[name].mean > 1.0]
            if above.size:
                angles = ", ".join(f"{a:g}" for a in np.unique(above))
                return f"{name} is above 1 at {angles} degrees, which hardly a smooth wall gives"
        return ""


def impact_speeds(
    pair: MaterialPair, measured: Measurements, speed: float | None = None
) -> FloatArray:
    """Choose the impact speed of each row, (n,), m/s: its own, or the given one.

    Raises `InputError` if there is neither, and the rebounds depend on the speed.
    """
    unstated = np.isnan(measured.speed)
    if speed is None and unstated.any() and pair.restitution.depends_on_speed:
        raise InputError(
            "speed",
            problem=f"is missing for {unstated.sum()} of {unstated.size} rows of {measured.name}",
            remedy="give the speed of these rows in m/s, because the restitution depends on it",
        )
    return np.where(unstated, ANY_SPEED if speed is None else speed, measured.speed)


def distinct_speeds(speed: FloatArray, most: int) -> list[float]:
    """List the speeds that stand for stated ones [m/s], given in rising order; empty if none is.

    Speeds that nearly agree are one, their median. If more than `most` are left, so many from the
    lowest to the highest are returned, with equal ratios.
    """
    if speed.size == 0:
        return []
    groups = np.split(speed, np.flatnonzero(np.diff(np.log(speed)) > _SAME_SPEED) + 1)
    if len(groups) > most:
        return [float(v) for v in np.geomspace(speed[0], speed[-1], most).round(3)]
    return [float(np.median(group)) for group in groups]
