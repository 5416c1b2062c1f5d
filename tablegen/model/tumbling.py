"""Free tumbling: orientations that a grain takes while it turns with a given spin and inertia.

In free flight the angular momentum L and the rotational energy T of a grain stay. With the mean
angular velocity W = (2T/|L|^2) L goes the inertia about it, k = |L|^2/(2T), between the smallest
and the largest principal moment (per unit mass, as all moments here). L = k W stands still in the
lab. In body axes its direction l follows the curve on which

    l1^2 + l2^2 + l3^2 = 1,    l1^2/j1 + l2^2/j2 + l3^2/j3 = 1/k,

round the shortest axis of the grain where 1/k < 1/j2, else round the longest, by Jacobi's elliptic
functions of time. Three things are not told by W and k, and are drawn: where on this curve l is and
how far the grain has turned about L, two phases that are uniform in time after a flight of a few
turns; and around which end of the axis l goes, because there is such a curve at either end.
"""

import math

import numpy as np

from tablegen.model.elementary import sine_and_cosine
from tablegen.model.frames import combine, cross, perpendicular, unit
from tablegen.model.jit import inline_kernel, kernel

#: Share of the largest moment by which the moments of a grain that has no axis may differ.
ROUND = 1e-9

#: Least complement of the parameter of elliptic functions: rounding of k gives no smaller one.
_LEAST_COMPLEMENT = 2.0**-53

#: Means after which the arithmetic and the geometric one are equal to rounding.
_MEANS = 8


@inline_kernel
def is_round(moments):
    """Whether a grain turns about any axis alike, as a sphere and a cube do."""
    return moments[2] - moments[0] <= ROUND * moments[2]


@kernel
def jacobi(turn, complement):
    """Return sn, cn and dn of 4 K ``turn``, where K is the quarter period and 0 <= turn <= 1.

    ``complement`` is 1 - m, from 0 excluded to 1. Gauss's transformation by arithmetic-geometric
    means: the last parameter is 0, and the functions are those of the angle 2 pi turn.
    """
    sine, cosine = sine_and_cosine(turn)
    if sine == 0.0:
        return 0.0, cosine, 1.0
    means = np.empty((_MEANS, 2))
    a, b = 1.0, math.sqrt(complement)
    for k in range(_MEANS):
        means[k, 0], means[k, 1] = a, b
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    ratio = cosine / sine
    c, dn = a * ratio, 1.0
    for k in range(_MEANS - 1, -1, -1):
        a, b = means[k, 0], means[k, 1]
        ratio *= c
        c *= dn
        dn = (b + ratio) / (a + ratio)
        ratio = c / a
    sn = math.copysign(1.0 / math.sqrt(c * c + 1.0), sine)
    return sn, c * sn, dn


@kernel
def momentum_direction(moments, inertia, turn, positive):
    """Direction in body axes of the angular momentum of a tumbling grain.

    ``moments`` ascend, and are not all equal (`is_round`); ``turn``, from 0 to 1, is the phase of
    the tumbling, ``positive`` the side of the centre on which the direction goes round.
    """
    i1, i2, i3 = 1.0 / moments[0], 1.0 / moments[1], 1.0 / moments[2]
    x = min(max(1.0 / inertia, i3), i1)
    side = 1.0 if positive else -1.0
    first, third = math.sqrt((x - i3) / (i1 - i3)), math.sqrt((i1 - x) / (i1 - i3))
    # of two equal moments the axes turn alike, and the parameter is 0
    if i1 == i2 or x < i2:
        second = math.sqrt((x - i3) / (i2 - i3))
        complement = (i1 - i3) * (i2 - x) / ((i2 - i3) * (i1 - x)) if i1 > i2 else 1.0
        sn, cn, dn = jacobi(turn, max(complement, _LEAST_COMPLEMENT))
        return first * cn, second * sn, side * third * dn
    second = math.sqrt((i1 - x) / (i1 - i2))
    complement = (i1 - i3) * (x - i2) / ((i1 - i2) * (x - i3)) if i2 > i3 else 1.0
    sn, cn, dn = jacobi(turn, max(complement, _LEAST_COMPLEMENT))
    return side * first * dn, second * sn, third * cn


@kernel
def axes_of_tumbling(moments, inertia, spin, phases):
    """Wall axes n and x in body axes of a grain that tumbles.

    ``spin`` is its mean angular velocity in wall axes, not zero, and ``phases`` are uniform numbers
    from 0 to 1: of the tumbling, of the turn about the spin, and of the side.
    """
    tumbled, turned, side = phases
    momentum = momentum_direction(moments, inertia, tumbled, side < 0.5)
    along = unit(spin)
    p, first = perpendicular(along, 0.0), perpendicular(unit(momentum), turned)
    q, second = cross(along, p), cross(momentum, first)
    n = combine(1.0, combine(p[1], first, q[1], second), along[1], momentum)
    x = combine(1.0, combine(p[0], first, q[0], second), along[0], momentum)
    return n, x
