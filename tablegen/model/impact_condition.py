"""Impact conditions: of one particle, as a record, and of many, as rows of an array.

A row has eight numbers, in the order of the fields of `Condition`, the spin as three; so the
conditions of WIDTH particles are eight lanes (see `tablegen.model.simd`), and the kernels of a
rebound take a record of floats or of lanes.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel
from tablegen.model.simd import load

#: Numbers of a condition.
CONDITION_SIZE = 8

#: Sine of the impact angle, half a degree, below which the resolution of contacts shrinks with it.
GRAZING = 0.0087

#: Angle [rad] turned before the first contact above which the flight's tolerance shrinks with it.
MANY_TURNS = 10.0


class Condition(NamedTuple):
    """Impact condition and numerical parameters of a rebound.

    ``cosine`` and ``sine`` of the impact angle, which are the velocity before the impact,
    ``speed`` [m/s], ``spin``: angular velocity before the impact in wall axes times a / V,
    ``resolution``: smallest rebound speed of a contact point over V, ``tolerance``: truncation of
    the flight series.
    """

    cosine: float
    sine: float
    speed: float
    spin: tuple[float, float, float]
    resolution: float
    tolerance: float


@inline_kernel
def angle_turned(sine, spin):
    """Angle [rad] that a particle turns at most before its first contact."""
    # from its greatest height to its least, turning all the way
    return math.sqrt(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]) * 2.0 / sine


@inline_kernel
def impact_condition(cosine, sine, speed, spin, numerics):
    """Condition of an impact, with numerical parameters that are small beside what they resolve.

    Parameters
    ----------
    cosine, sine : float
        Of the impact angle.
    speed : float
        Impact speed [m/s].
    spin : tuple of three floats
        Angular velocity before the impact times a / V, wall axes.
    numerics : tuple of two floats
        Resolution of contacts and tolerance of flights, as a configuration says.
    """
    resolution, tolerance = numerics
    turned = angle_turned(sine, spin)
    return Condition(
        cosine,
        sine,
        speed,
        spin,
        resolution * min(1.0, sine / GRAZING),
        tolerance / max(1.0, turned / MANY_TURNS),
    )


@inline_kernel
def translates(condition):
    """Whether particles arrive without spin."""
    x, y, z = condition.spin
    return (x == 0.0) & (y == 0.0) & (z == 0.0)


@no_refcount_inline_kernel
def condition_of(values):
    """Condition from its eight numbers: the row of one particle, (8,), or lanes, (8, WIDTH)."""
    return Condition(
        load(values, 0),
        load(values, 1),
        load(values, 2),
        (load(values, 3), load(values, 4), load(values, 5)),
        load(values, 6),
        load(values, 7),
    )


@no_refcount_inline_kernel
def put_condition(condition, values, row):
    """Write a condition to a row of an array."""
    values[row, 0], values[row, 1], values[row, 2] = (
        condition.cosine,
        condition.sine,
        condition.speed,
    )
    for k in range(3):
        values[row, 3 + k] = condition.spin[k]
    values[row, 6], values[row, 7] = condition.resolution, condition.tolerance


def one_row(condition: Condition) -> NDArray[np.float64]:
    """Array (1, 8) of a condition that all particles have."""
    values = np.empty((1, CONDITION_SIZE))
    put_condition(condition, values, 0)
    return values
