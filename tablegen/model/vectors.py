"""Vectors of three numbers, as tuples."""

import math

from tablegen.model.elementary import sine_and_cosine
from tablegen.model.jit import inline_kernel


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
