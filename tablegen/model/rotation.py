"""Free rotation of an asymmetric body between collisions, as a Taylor series in time.

Seen from the body, the angular velocity W and the wall axes n and x obey Euler's equations

    J1 W1' = (J2 - J3) W2 W3 (and cyclic),   n' = n x W,   x' = x x W.

They are quadratic, so each order of their Taylor coefficients follows from one convolution of the
orders before. The contact search evaluates the series at any time, and integrates nothing again.

The contact search needs W and n only. The axis x is computed at the end of a step from the angular
momentum, whose part along the wall is constant in wall axes. Where that part is too small to give
a direction, x is expanded in a series of its own.

Units: angular velocities in V / a, times in a / V, moments of inertia in m a^2. The paper solves
the same equations by small steps.
"""

from tablegen.model.elementary import exponential, logarithm, sine_and_cosine
from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.simd import (
    any_lane,
    fma,
    load,
    load_three,
    logical_not,
    maximum,
    minimum,
    select,
    select_three,
    sqrt,
    store,
    store_three,
)
from tablegen.model.vectors import combine, cross, dot

#: Order of the series.
ORDER = 12

#: First row of the wall normal n in the coefficient array; before it the angular velocity, after
#: it the wall axis x, all in body axes.
NORMAL = 3

#: Least share of the squared angular momentum along the wall with which it gives the axis x.
HORIZONTAL_SHARE = 0.01

#: A coefficient below this number counts as zero.
TINY = 1e-280


@no_refcount_inline_kernel
def _cross_terms(series, row, j, k, more, less):
    """Add term j of order k of (axis x W) to the positive and the negative part of its sum.

    The parts are apart because additions and subtractions in one sum would have to wait for each
    other.
    """
    w1, w2, w3 = load_three(series, 0, k - j)
    a, b, c = load_three(series, row, j)
    more = fma(b, w3, more[0]), fma(c, w1, more[1]), fma(a, w2, more[2])
    less = fma(c, w2, less[0]), fma(a, w3, less[1]), fma(b, w1, less[2])
    return more, less


@no_refcount_kernel
def expand_motion(moments, motion, series):
    """Write the Taylor coefficients of W and n around the present instant.

    ``motion`` (>= 9,) has the angular velocity, the wall normal and the wall x axis in body axes;
    row i of ``series`` (9, ORDER + 1) gets the coefficients of motion[i], i < 6.
    """
    j1, j2, j3 = moments
    k1 = (j2 - j3) / j1
    k2 = (j3 - j1) / j2
    k3 = (j1 - j2) / j3
    for i in range(6):
        store(series, (i, 0), load(motion, i))
    for k in range(ORDER):
        p1 = p2 = p3 = 0.0
        more = less = (0.0, 0.0, 0.0)
        for j in range(k + 1):
            p1 = fma(load(series, (1, j)), load(series, (2, k - j)), p1)
            p2 = fma(load(series, (2, j)), load(series, (0, k - j)), p2)
            p3 = fma(load(series, (0, j)), load(series, (1, k - j)), p3)
            more, less = _cross_terms(series, NORMAL, j, k, more, less)
        scale = 1.0 / (k + 1)
        store(series, (0, k + 1), k1 * p1 * scale)
        store(series, (1, k + 1), k2 * p2 * scale)
        store(series, (2, k + 1), k3 * p3 * scale)
        for i in range(3):
            store(series, (NORMAL + i, k + 1), (more[i] - less[i]) * scale)


@no_refcount_kernel
def expand_axis(motion, series):
    """Write the Taylor coefficients of the axis x to rows 6 to 8; those of W must be there."""
    for i in range(6, 9):
        store(series, (i, 0), load(motion, i))
    for k in range(ORDER):
        more = less = (0.0, 0.0, 0.0)
        for j in range(k + 1):
            more, less = _cross_terms(series, 6, j, k, more, less)
        scale = 1.0 / (k + 1)
        for i in range(3):
            store(series, (6 + i, k + 1), (more[i] - less[i]) * scale)


@inline_kernel
def _largest(a):
    """Find the largest size of the three numbers of a vector."""
    return maximum(maximum(abs(a[0]), abs(a[1])), abs(a[2]))


@no_refcount_inline_kernel
def last_terms(series, first):
    """Find the largest coefficients, of the last order and of the order before, of three rows."""
    return _largest(load_three(series, first, ORDER)), _largest(
        load_three(series, first, ORDER - 1)
    )


@no_refcount_kernel
def series_span(series, tolerance):
    """Compute the time over which the truncated series stays within a tolerance; infinite at rest.

    The last two coefficients measure what is cut off. The time makes the last term at most
    ``tolerance``; angular velocities are relative to the largest one.
    """
    rate = _largest(load_three(series, 0, 0))
    # One term may vanish by symmetry where its neighbour does not. If time is measured in units of
    # 1 / rate, both are of similar size.
    last, before = last_terms(series, 0)
    size = maximum(last / rate, before)
    last, before = last_terms(series, NORMAL)
    size = maximum(size, maximum(last, before * rate))
    # At most two radians, so that the bound holds where both terms happen to be small.
    longest = 2.0 / rate
    measured = (size > TINY) & (rate > 0.0)
    share = tolerance / select(measured, size, 1.0)
    span = exponential(logarithm(share) * (1.0 / ORDER))
    return select(measured, minimum(longest, span), longest)


@no_refcount_inline_kernel
def _polynomials(series, first, t):
    """Evaluate three rows of the series at t."""
    a, b, c = load_three(series, first, ORDER)
    for k in range(ORDER - 1, -1, -1):
        p, q, r = load_three(series, first, k)
        a, b, c = fma(a, t, p), fma(b, t, q), fma(c, t, r)
    return a, b, c


@no_refcount_inline_kernel
def _horizontal_momentum(moments, motion):
    """Compute the angular momentum along the wall axes x and z, and the square of all of it."""
    w, n, x = load_three(motion, 0), load_three(motion, 3), load_three(motion, 6)
    a1, a2, a3 = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    a = a1, a2, a3
    return dot(a, x), dot(a, cross(x, n)), dot(a, a)


@no_refcount_inline_kernel
def _axis_from_momentum(moments, l_x, l_z, w, n):
    """Compute the axis x, not yet of unit length, from the angular momentum along the wall.

    Let p be the part of J W perpendicular to n. Then p = l_x x + l_z z and n x p = l_z x - l_x z.
    """
    p1, p2, p3 = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    l_y = p1 * n[0] + p2 * n[1] + p3 * n[2]
    p = p1 - l_y * n[0], p2 - l_y * n[1], p3 - l_y * n[2]
    return combine(l_x, p, l_z, cross(n, p))


@inline_kernel
def _unit(a):
    """Scale a vector to unit length."""
    scale = 1.0 / sqrt(dot(a, a))
    return a[0] * scale, a[1] * scale, a[2] * scale


@no_refcount_kernel
def advance_motion(moments, series, t, motion):
    """Advance the motion by the time ``t`` along its series, and make its axes orthonormal."""
    l_x, l_z, square = _horizontal_momentum(moments, motion)
    has_direction = l_x * l_x + l_z * l_z > HORIZONTAL_SHARE * square
    w, n = _polynomials(series, 0, t), _unit(_polynomials(series, NORMAL, t))
    x = _axis_from_momentum(moments, l_x, l_z, w, n)
    if any_lane(logical_not(has_direction)):
        expand_axis(motion, series)
        x = select_three(has_direction, x, _polynomials(series, 6, t))
    skew = dot(n, x)
    store_three(motion, 0, w)
    store_three(motion, 3, n)
    store_three(motion, 6, _unit((x[0] - skew * n[0], x[1] - skew * n[1], x[2] - skew * n[2])))


@no_refcount_kernel
def rate_bounds(moments, motion):
    """Bound |W| and |W'| for the whole free motion.

    In free motion 2E and L^2 are constant, so each of W1, W2 and W3 is largest where one of the
    other two vanishes. With j1 <= j2 <= j3 this gives the bounds below; the energy gives others,
    and the smaller bound counts.
    """
    j1, j2, j3 = moments
    w1, w2, w3 = load_three(motion, 0)
    q1, q2, q3 = w1 * w1, w2 * w2, w3 * w3
    energy = j1 * q1 + j2 * q2 + j3 * q3
    span, above, below = j3 - j1, j3 - j2, j2 - j1
    # if two moments are equal, a quotient is infinite or NaN, and `minimum` returns its first
    # argument, the bound by the energy
    m1 = minimum(energy / j1, q1 + q2 * (j2 * above) / (j1 * span))
    m3 = minimum(energy / j3, q3 + q2 * (j2 * below) / (j3 * span))
    m2 = minimum(energy / j2, q2 + q1 * (j1 * span) / (j2 * above))
    m2 = minimum(m2, q2 + q3 * (j3 * span) / (j2 * below))
    k1, k2, k3 = above / j1, span / j2, below / j3
    turn = sqrt(m1 + m2 + m3)
    change = sqrt(k1 * k1 * m2 * m3 + k2 * k2 * m3 * m1 + k3 * k3 * m1 * m2)
    return turn, change


@no_refcount_kernel
def set_orientation(u1, u2, u3, motion):
    """Write the wall axes of a uniformly random orientation to rows 3 to 8 of ``motion``.

    ``u1, u2, u3`` are independent and uniform on (0, 1). Source: K. Shoemake, "Uniform random
    rotations", Graphics Gems III (1992) 124-132.
    """
    r1, r2 = sqrt(1.0 - u1), sqrt(u1)
    s1, c1 = sine_and_cosine(u2)
    s2, c2 = sine_and_cosine(u3)
    x, y = r1 * s1, r1 * c1
    z, w = r2 * s2, r2 * c2
    n = 2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)
    store_three(motion, 3, n)
    axis = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)
    store_three(motion, 6, axis)
