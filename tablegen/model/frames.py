"""Vectors of three numbers, and the axes of the wall in the lab frame.

The wall axis y is the normal into the gas, x is along the tangential part of the velocity relative
to the wall, and z = x cross y. At exactly normal impact there is no tangential part. Then the law
is symmetric about y, and the direction of x is drawn uniformly.

Units: lab frame in SI; states have velocities over the impact speed V and angular velocities times
a / V.
"""

import math

import numpy as np

from sampler.errors import HALF_SIZE, NORMAL_NOT_USABLE, NOT_FINITE, OK
from tablegen.model.elementary import sine_and_cosine
from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel
from tablegen.model.random_numbers import philox_block, uniform

#: Tangential over total speed below which an impact counts as normal, because the direction of so
#: small a tangential velocity is rounding noise.
_NORMAL_IMPACT = 1e-12

#: Least and largest half-size [m], as in the draw of a table. Others are mistaken units.
_LEAST_HALF_SIZE, _MOST_HALF_SIZE = 1e-9, 100.0

#: Block of random words that gives the azimuth at normal impact.
_AZIMUTH_BLOCK = 2


@inline_kernel
def dot(a, b):
    """Compute a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inline_kernel
def cross(a, b):
    """Compute a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inline_kernel
def combine(p, a, q, b):
    """Compute p a + q b."""
    return (p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2])


@inline_kernel
def unit(a):
    """Compute the unit vector along a finite vector of any length but zero."""
    largest = max(abs(a[0]), abs(a[1]), abs(a[2]))
    # a division, because 1 / largest overflows for the smallest vectors
    a = (a[0] / largest, a[1] / largest, a[2] / largest)
    scale = 1.0 / math.sqrt(dot(a, a))
    return (scale * a[0], scale * a[1], scale * a[2])


@inline_kernel
def is_finite(a):
    """Tell whether all three numbers are finite."""
    return math.isfinite(a[0]) and math.isfinite(a[1]) and math.isfinite(a[2])


@no_refcount_inline_kernel
def vector(values, k):
    """Read row k of an (n, 3) array, or the only row of a (1, 3) array."""
    k = k if values.shape[0] > 1 else 0
    return (values[k, 0], values[k, 1], values[k, 2])


@no_refcount_inline_kernel
def item(values, k):
    """Read element k of an (n,) array, or the only element of a (1,) array."""
    return values[np.uint64(k)] if values.size > 1 else values[0]


@no_refcount_inline_kernel
def keys_of_row(keys, k):
    """Read seed, index and hit of row k; index and hit have n elements, or one for all rows."""
    seed, index, hit = keys
    return seed, item(index, k), item(hit, k)


@inline_kernel
def perpendicular(e_y, turns):
    """Compute a unit vector perpendicular to the unit vector e_y, at an angle about it.

    The angle is in turns. At 0 the vector is in the plane of e_y and of the coordinate axis that is
    farthest from it.
    """
    x, y, z = abs(e_y[0]), abs(e_y[1]), abs(e_y[2])
    if x <= y and x <= z:
        axis = (1.0, 0.0, 0.0)
    elif y <= z:
        axis = (0.0, 1.0, 0.0)
    else:
        axis = (0.0, 0.0, 1.0)
    zero = unit(combine(1.0, axis, -dot(axis, e_y), e_y))
    sine, cosine = sine_and_cosine(turns)
    return combine(cosine, zero, sine, cross(e_y, zero))


@inline_kernel
def tangent(relative, e_y, keys):
    """Compute the unit vector e_x along the tangential velocity.

    At normal impact its azimuth is drawn by the keys (seed, index, hit), uniform in [0, 2 pi).
    """
    along = combine(1.0, relative, -dot(relative, e_y), e_y)
    if math.sqrt(dot(along, along)) > _NORMAL_IMPACT * math.sqrt(dot(relative, relative)):
        # projected twice, because near normal impact the first projection loses digits
        e_x = unit(along)
        return unit(combine(1.0, e_x, -dot(e_x, e_y), e_y))
    word = philox_block(keys[0], keys[1], keys[2], _AZIMUTH_BLOCK)[0]
    return perpendicular(e_y, uniform(word))


@inline_kernel
def impact_frame(relative, normal, keys):
    """Compute the wall axes x, y and z of an impact in the lab frame."""
    e_y = unit(normal)
    e_x = tangent(relative, e_y, keys)
    return e_x, e_y, cross(e_x, e_y)


@inline_kernel
def impact_status(velocity, normal, half_size, wall_velocity):
    """Return a negative code if the numbers describe no impact, else `OK`."""
    finite = is_finite(velocity) and is_finite(wall_velocity)
    if not (finite and is_finite(normal) and math.isfinite(half_size)):
        return NOT_FINITE
    if normal[0] == 0.0 and normal[1] == 0.0 and normal[2] == 0.0:
        return NORMAL_NOT_USABLE
    return OK if _LEAST_HALF_SIZE <= half_size <= _MOST_HALF_SIZE else HALF_SIZE


@inline_kernel
def impact_angle(relative, e_y):
    """Compute the impact angle from the wall [rad]; it is not positive for a receding velocity."""
    approach = -dot(relative, e_y)
    along = combine(1.0, relative, approach, e_y)
    return math.atan2(approach, math.sqrt(dot(along, along)))


@no_refcount_inline_kernel
def to_lab(impact, keys, out):
    """Replace a state by velocity [m/s] and angular velocity [rad/s] in the lab frame, in place.

    ``impact`` is the velocity before the impact [m/s], the wall normal, the half-size [m] and the
    velocity of the wall [m/s]; ``keys`` are seed, index and hit.
    """
    velocity, normal, half_size, wall_velocity = impact
    relative = combine(1.0, velocity, -1.0, wall_velocity)
    speed = math.sqrt(dot(relative, relative))
    e_x, e_y, e_z = impact_frame(relative, normal, keys)
    for part in range(2):
        scale = speed if part == 0 else speed / half_size
        plane = combine(out[3 * part], e_x, out[3 * part + 1], e_y)
        turned = combine(scale, plane, scale * out[3 * part + 2], e_z)
        for axis in range(3):
            out[3 * part + axis] = turned[axis]
    for axis in range(3):
        out[axis] += wall_velocity[axis]
