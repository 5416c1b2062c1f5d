"""Measured rebound statistics: the record that their reader gives.

A quantity is one number of each rebound; what is measured is its mean over many particles and its
standard deviation. With u, v, w the components of the velocity after the impact over the impact
speed V, in the wall frame (x along the tangential velocity before, y into the gas), and with the
impact angle alpha from the wall:

- e_n = v / sin(alpha), normal restitution of the centre of mass;
- e_t = u / cos(alpha), tangential restitution; there is none at 90 degrees;
- rebound_angle_deg: its mean is the angle of the mean velocity from the wall, atan2(mean v, mean
  u); its spread is that of the particles' own angles atan2(v, u), both in the impact plane;
- out_of_plane_deg = asin(w / sqrt(u^2 + v^2 + w^2)), angle between velocity and impact plane;
- omega_z: spin about z times a / V, negative for one that rolls forward.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from tablegen.model.float_array import FloatArray

#: What can be measured; the spread of a quantity has its name with `SPREAD` behind it.
QUANTITIES = ("e_n", "e_t", "rebound_angle_deg", "out_of_plane_deg", "omega_z")

#: End of the name of a column with standard deviations.
SPREAD = "_std"


@dataclass(frozen=True)
class Moments:
    """Mean and standard deviation of one quantity at each of n conditions; NaN: not measured."""

    #: Shape (n,).
    mean: FloatArray
    std: FloatArray


@dataclass(frozen=True)
class Measurements:
    """Measured rebounds at n impact conditions.

    Attributes
    ----------
    name : str
        Name of the file, without its ending.
    alpha_deg : (n,) float64
        Impact angle from the wall, degrees.
    speed : (n,) float64
        Impact speed, m/s; NaN where it is not stated.
    moments : mapping of str to Moments
        For each of `QUANTITIES`.
    count : (n,) float64
        Number of particles; NaN where it is not stated.
    source, remarks : tuple of n str
        Where each row comes from, and what is to be known of it.
    about : mapping of str to str
        Lines ``# key: value`` at the top of the file, such as title, particle and wall.
    """

    name: str
    alpha_deg: FloatArray
    speed: FloatArray
    moments: Mapping[str, Moments]
    count: FloatArray
    source: tuple[str, ...]
    remarks: tuple[str, ...]
    about: Mapping[str, str]
