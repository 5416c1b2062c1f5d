"""Free tumbling: the orientations of a grain that turns with a given spin and inertia.

In free flight the angular momentum L and the rotational energy T of a grain are constant. So are
the mean angular velocity W = (2T/|L|^2) L and the inertia about it, k = |L|^2/(2T), which lies
between the smallest and the largest principal moment. L = k W does not turn in the lab. In body
axes its direction l follows the curve on which

    l1^2 + l2^2 + l3^2 = 1,    l1^2/j1 + l2^2/j2 + l3^2/j3 = 1/k.

The curve goes round the shortest axis of the grain (that of j3) if 1/k < 1/j2, else round the
longest, and l moves along it by Jacobi's elliptic functions of time. W and k leave three things
open, which are drawn: where on the curve l is, how far the grain has turned about L, and round
which end of the axis l goes, because there is one curve at either end. The first two are phases
that are uniform in time after a flight of a few turns.

Units: angular velocities in V / a, moments of inertia per unit mass in a^2.
Source: Landau & Lifshitz, Mechanics, section 37.
"""

import math

from tablegen.model.elementary import sine_and_cosine
from tablegen.model.jit import inline_kernel, kernel
from tablegen.model.memory import stack_array
from tablegen.model.vectors import combine, cross, perpendicular, unit

#: Share of the largest moment of inertia by which the moments of a round grain may differ.
ROUND = 1e-9

#: Least complement 1 - m of the parameter of elliptic functions; rounding of k gives none smaller.
_LEAST_COMPLEMENT = 2.0**-53

#: Steps after which the arithmetic and the geometric mean are equal to rounding.
_MEANS = 8


@inline_kernel
def is_round(moments):
    """Tell whether a grain has equal moments about all axes, as a sphere and a cube do."""
    return moments[2] - moments[0] <= ROUND * moments[2]


@kernel
def jacobi(turn, complement):
    """Compute Jacobi's sn, cn and dn of 4 K ``turn``, where K is the quarter period.

    ``turn`` is from 0 to 1. ``complement`` is 1 - m, above 0 and up to 1. Gauss's transformation
    leads by arithmetic-geometric means to the parameter 0, where the functions are the sine and the
    cosine of 2 pi turn.
    """
    sine, cosine = sine_and_cosine(turn)
    if sine == 0.0:
        return 0.0, cosine, 1.0
    means = stack_array((_MEANS, 2))
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
    """Compute the direction in body axes of the angular momentum of a tumbling grain.

    ``moments`` are in rising order and not all equal (`is_round`). ``turn``, from 0 to 1, is the
    phase of the tumbling. ``positive`` tells which end of the axis the direction goes round.
    """
    i1, i2, i3 = 1.0 / moments[0], 1.0 / moments[1], 1.0 / moments[2]
    x = min(max(1.0 / inertia, i3), i1)
    side = 1.0 if positive else -1.0
    first, third = math.sqrt((x - i3) / (i1 - i3)), math.sqrt((i1 - x) / (i1 - i3))
    # if two moments are equal, the motion is a steady precession and the parameter is 0
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
    """Compute the wall axes n and x in body axes of a grain that tumbles.

    ``spin`` is its mean angular velocity in wall axes, not zero. ``phases`` are three uniform
    numbers from 0 to 1: for the tumbling, for the turn about the spin, and for the end of the axis.
    """
    tumbled, turned, side = phases
    momentum = momentum_direction(moments, inertia, tumbled, side < 0.5)
    along = unit(spin)
    p, first = perpendicular(along, 0.0), perpendicular(unit(momentum), turned)
    q, second = cross(along, p), cross(momentum, first)
    n = combine(1.0, combine(p[1], first, q[1], second), along[1], momentum)
    x = combine(1.0, combine(p[0], first, q[0], second), along[0], momentum)
    return n, x
