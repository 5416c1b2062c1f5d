"""Free rotation of an asymmetric body, as a Taylor series in time.

Euler's equations and the kinematics of the wall axes seen from the body,

    J1 W1' = (J2 - J3) W2 W3 (and cyclic),   n' = n x W,   x' = x x W,

are quadratic, so their Taylor coefficients follow from one convolution an order. The series is
its own dense output: contact search evaluates a polynomial instead of integrating again.

Contact search needs W and n only. The axis x is found at the end of a step from the angular
momentum, whose horizontal part is constant in wall axes; where that part is too small to give a
direction, x has its own series.
"""

from tablegen.model.elementary import exponential, logarithm, sine_and_cosine
from tablegen.model.frames import combine, cross, dot
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

#: Order of the series.
ORDER = 12

#: First row of the wall normal n in the coefficient array; before it the angular velocity, after
#: it the wall axis x, all in body axes.
NORMAL = 3

#: Least share of the squared angular momentum that must be horizontal to give the axis x.
HORIZONTAL_SHARE = 0.01

#: A coefficient below it counts as none.
TINY = 1e-280


@no_refcount_inline_kernel
def _cross_terms(series, row, j, k, more, less):
    """Add term j of order k of (axis x W) to the positive and negative parts of its sums.

    Two sums: additions and subtractions in one would form a longer chain of dependencies.
    """
    w1, w2, w3 = load_three(series, 0, k - j)
    a, b, c = load_three(series, row, j)
    more = fma(b, w3, more[0]), fma(c, w1, more[1]), fma(a, w2, more[2])
    less = fma(c, w2, less[0]), fma(a, w3, less[1]), fma(b, w1, less[2])
    return more, less


@no_refcount_kernel
def expand(moments, motion, series):
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
    """Write the Taylor coefficients of x, rows 6 to 8, once those of W are known."""
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
    """Largest component of a vector."""
    return maximum(maximum(abs(a[0]), abs(a[1])), abs(a[2]))


@no_refcount_inline_kernel
def last_terms(series, first):
    """Largest coefficients of the last order and of the one before, of three rows."""
    return _largest(load_three(series, first, ORDER)), _largest(
        load_three(series, first, ORDER - 1)
    )


@no_refcount_kernel
def series_span(series, tolerance):
    """Time over which the truncated series stays within the tolerance; infinite at rest.

    The last two coefficients measure the remainder, the rates relative to the largest angular
    velocity; the span makes the last term at most ``tolerance``.
    """
    rate = _largest(load_three(series, 0, 0))
    # A term may vanish by symmetry where its neighbour does not; in units of 1 / rate the two
    # are alike.
    last, before = last_terms(series, 0)
    size = maximum(last / rate, before)
    last, before = last_terms(series, NORMAL)
    size = maximum(size, maximum(last, before * rate))
    # Two radians keep the bound honest where both terms happen to be small.
    longest = 2.0 / rate
    measured = (size > TINY) & (rate > 0.0)
    share = tolerance / select(measured, size, 1.0)
    span = exponential(logarithm(share) * (1.0 / ORDER))
    return select(measured, minimum(longest, span), longest)


@no_refcount_inline_kernel
def _polynomials(series, first, t):
    """Values at t of three rows of the series."""
    a, b, c = load_three(series, first, ORDER)
    for k in range(ORDER - 1, -1, -1):
        p, q, r = load_three(series, first, k)
        a, b, c = fma(a, t, p), fma(b, t, q), fma(c, t, r)
    return a, b, c


@no_refcount_inline_kernel
def _horizontal_momentum(moments, motion):
    """Angular momentum along the wall axes x and z, and its square."""
    w, n, x = load_three(motion, 0), load_three(motion, 3), load_three(motion, 6)
    a1, a2, a3 = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    a = a1, a2, a3
    return dot(a, x), dot(a, cross(x, n)), dot(a, a)


@no_refcount_inline_kernel
def _axis_from_momentum(moments, l_x, l_z, w, n):
    """Axis x, not yet of unit length, for the horizontal angular momentum (l_x, l_z).

    With p the part of J W normal to n, p = l_x x + l_z z and n x p = l_z x - l_x z.
    """
    p1, p2, p3 = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    l_y = p1 * n[0] + p2 * n[1] + p3 * n[2]
    p = p1 - l_y * n[0], p2 - l_y * n[1], p3 - l_y * n[2]
    return combine(l_x, p, l_z, cross(n, p))


@inline_kernel
def _unit(a):
    """Vector of unit length along a vector."""
    scale = 1.0 / sqrt(dot(a, a))
    return a[0] * scale, a[1] * scale, a[2] * scale


@no_refcount_kernel
def evaluate(moments, series, t, motion):
    """Move the motion by the time ``t`` along its series; its axes come out orthonormal."""
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
    """Bounds on |W| and |W'| that hold for the whole free motion.

    On the polhode 2E and L^2 are constant; each component is largest where one of the other two
    vanishes. With j1 <= j2 <= j3 this gives the bounds below, each also limited by the energy.
    """
    j1, j2, j3 = moments
    w1, w2, w3 = load_three(motion, 0)
    q1, q2, q3 = w1 * w1, w2 * w2, w3 * w3
    energy = j1 * q1 + j2 * q2 + j3 * q3
    span, above, below = j3 - j1, j3 - j2, j2 - j1
    # where two moments are equal a quotient is infinite or NaN; `minimum` then keeps the
    # bound by the energy, its first argument
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
    """Write wall axes for a uniformly random rotation (Shoemake's quaternion).

    ``u1, u2, u3`` are independent and uniform on (0, 1); rows 3 to 8 of ``motion`` are written.
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
