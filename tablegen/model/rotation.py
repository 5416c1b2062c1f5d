"""Free rotation of an asymmetric body, as a Taylor series in time.

Euler's equations and the kinematics of the wall axes seen from the body,

    J1 W1' = (J2 - J3) W2 W3 (and cyclic),   n' = n x W,   x' = x x W,

are quadratic, so their Taylor coefficients follow from one convolution an order. The series is
its own dense output: contact search evaluates a polynomial instead of integrating again.

Every kernel here takes the arrays of one particle or of lanes (see `tablegen.model.simd`); a
shape such as (9, ORDER + 1) stands for (9, ORDER + 1, WIDTH) too.

Contact search needs W and n only. The axis x is found at the end of a step from the angular
momentum, whose horizontal part is constant in wall axes; where that part is too small to give a
direction, x has its own series.
"""

from tablegen.model.elementary import exponential, logarithm, sine_and_cosine
from tablegen.model.jit import no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.simd import (
    any_lane,
    fma,
    load,
    logical_not,
    maximum,
    minimum,
    select,
    sqrt,
    store,
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

    Two sums, because additions and subtractions in one would form a longer chain of dependencies.
    """
    w1, w2, w3 = load(series, (0, k - j)), load(series, (1, k - j)), load(series, (2, k - j))
    a, b, c = load(series, (row, j)), load(series, (row + 1, j)), load(series, (row + 2, j))
    more = fma(b, w3, more[0]), fma(c, w1, more[1]), fma(a, w2, more[2])
    less = fma(c, w2, less[0]), fma(a, w3, less[1]), fma(b, w1, less[2])
    return more, less


@no_refcount_kernel
def expand(moments, motion, series):
    """Taylor coefficients of W and n around the present instant.

    Parameters
    ----------
    moments : tuple of three floats
        Principal moments of inertia.
    motion : (>= 9,) float64
        Angular velocity, wall normal and wall x axis in body axes.
    series : (9, ORDER + 1) float64
        Rows 0 to 5 are written; row i holds the coefficients of motion[i].
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
        store(series, (3, k + 1), (more[0] - less[0]) * scale)
        store(series, (4, k + 1), (more[1] - less[1]) * scale)
        store(series, (5, k + 1), (more[2] - less[2]) * scale)


@no_refcount_kernel
def expand_axis(motion, series):
    """Taylor coefficients of x, rows 6 to 8, once those of W are known; arguments as above."""
    for i in range(6, 9):
        store(series, (i, 0), load(motion, i))
    for k in range(ORDER):
        more = less = (0.0, 0.0, 0.0)
        for j in range(k + 1):
            more, less = _cross_terms(series, 6, j, k, more, less)
        scale = 1.0 / (k + 1)
        store(series, (6, k + 1), (more[0] - less[0]) * scale)
        store(series, (7, k + 1), (more[1] - less[1]) * scale)
        store(series, (8, k + 1), (more[2] - less[2]) * scale)


@no_refcount_inline_kernel
def _last_terms(series, first):
    """Largest coefficients of the last order and of the one before, of three rows."""
    last = maximum(abs(load(series, (first, ORDER))), abs(load(series, (first + 1, ORDER))))
    last = maximum(last, abs(load(series, (first + 2, ORDER))))
    before = maximum(
        abs(load(series, (first, ORDER - 1))), abs(load(series, (first + 1, ORDER - 1)))
    )
    return last, maximum(before, abs(load(series, (first + 2, ORDER - 1))))


@no_refcount_kernel
def series_span(series, tolerance):
    """Time over which the truncated series stays within the tolerance.

    The last two coefficients measure the remainder, the rates relative to the largest angular
    velocity; the span makes the last term at most ``tolerance``. It is infinite at rest.
    """
    rate = maximum(abs(load(series, (0, 0))), abs(load(series, (1, 0))))
    rate = maximum(rate, abs(load(series, (2, 0))))
    # A term may vanish by symmetry where its neighbour does not; in units of 1 / rate the two
    # are alike.
    last, before = _last_terms(series, 0)
    size = maximum(last / rate, before)
    last, before = _last_terms(series, NORMAL)
    size = maximum(size, maximum(last, before * rate))
    # Two radians keep the bound honest where both terms happen to be small.
    longest = 2.0 / rate
    measured = (size > TINY) & (rate > 0.0)
    share = tolerance / select(measured, size, 1.0)
    span = exponential(logarithm(share) * (1.0 / ORDER))
    return select(measured, minimum(longest, span), longest)


@no_refcount_inline_kernel
def _polynomial(series, row, t):
    value = load(series, (row, ORDER))
    for k in range(ORDER - 1, -1, -1):
        value = fma(value, t, load(series, (row, k)))
    return value


@no_refcount_inline_kernel
def _three(motion, first):
    """Three entries of a motion, from ``first`` on."""
    return load(motion, first), load(motion, first + 1), load(motion, first + 2)


@no_refcount_inline_kernel
def _put_three(motion, first, vector):
    """Write three entries of a motion."""
    for i in range(3):
        store(motion, first + i, vector[i])


@no_refcount_inline_kernel
def _horizontal_momentum(moments, motion):
    """Angular momentum along the wall axes x and z, and its square."""
    w, n, x = _three(motion, 0), _three(motion, 3), _three(motion, 6)
    a1, a2, a3 = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    l_x = a1 * x[0] + a2 * x[1] + a3 * x[2]
    l_z = a1 * (x[1] * n[2] - x[2] * n[1]) + a2 * (x[2] * n[0] - x[0] * n[2])
    l_z += a3 * (x[0] * n[1] - x[1] * n[0])
    return l_x, l_z, a1 * a1 + a2 * a2 + a3 * a3


@no_refcount_inline_kernel
def _axis_from_momentum(moments, l_x, l_z, w, n):
    """Axis x, not yet of unit length, for the horizontal angular momentum (l_x, l_z).

    With p the part of J W normal to n, p = l_x x + l_z z and n x p = l_z x - l_x z.
    """
    p1, p2, p3 = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    l_y = p1 * n[0] + p2 * n[1] + p3 * n[2]
    p1, p2, p3 = p1 - l_y * n[0], p2 - l_y * n[1], p3 - l_y * n[2]
    return (
        l_x * p1 + l_z * (n[1] * p3 - n[2] * p2),
        l_x * p2 + l_z * (n[2] * p1 - n[0] * p3),
        l_x * p3 + l_z * (n[0] * p2 - n[1] * p1),
    )


@no_refcount_inline_kernel
def _unit(a1, a2, a3):
    """Vector of unit length along a vector."""
    scale = 1.0 / sqrt(a1 * a1 + a2 * a2 + a3 * a3)
    return a1 * scale, a2 * scale, a3 * scale


@no_refcount_kernel
def evaluate(moments, series, t, motion):
    """Move the motion by the time ``t`` along its series; its axes come out orthonormal.

    Parameters
    ----------
    moments : tuple of three floats
    series : (9, ORDER + 1) float64
        Expanded around ``motion``.
    t : float
    motion : (>= 9,) float64
    """
    l_x, l_z, square = _horizontal_momentum(moments, motion)
    has_direction = l_x * l_x + l_z * l_z > HORIZONTAL_SHARE * square
    w = _polynomial(series, 0, t), _polynomial(series, 1, t), _polynomial(series, 2, t)
    n = _polynomial(series, 3, t), _polynomial(series, 4, t), _polynomial(series, 5, t)
    n = _unit(n[0], n[1], n[2])
    x1, x2, x3 = _axis_from_momentum(moments, l_x, l_z, w, n)
    if any_lane(logical_not(has_direction)):
        expand_axis(motion, series)
        x1 = select(has_direction, x1, _polynomial(series, 6, t))
        x2 = select(has_direction, x2, _polynomial(series, 7, t))
        x3 = select(has_direction, x3, _polynomial(series, 8, t))
    skew = n[0] * x1 + n[1] * x2 + n[2] * x3
    _put_three(motion, 0, w)
    _put_three(motion, 3, n)
    _put_three(motion, 6, _unit(x1 - skew * n[0], x2 - skew * n[1], x3 - skew * n[2]))


@no_refcount_kernel
def rate_bounds(moments, motion):
    """Bounds on |W| and |W'| that hold for the whole free motion.

    On the polhode 2E and L^2 are constant; each component is largest where one of the other
    two vanishes. With j1 <= j2 <= j3 this gives the bounds below, each also limited by the
    energy alone.

    Returns
    -------
    tuple of two floats
    """
    j1, j2, j3 = moments
    w1, w2, w3 = _three(motion, 0)
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

    ``u1, u2, u3`` are independent and uniform on (0, 1); rows 3..8 of ``motion`` are written.
    """
    r1, r2 = sqrt(1.0 - u1), sqrt(u1)
    s1, c1 = sine_and_cosine(u2)
    s2, c2 = sine_and_cosine(u3)
    x, y = r1 * s1, r1 * c1
    z, w = r2 * s2, r2 * c2
    n = 2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)
    _put_three(motion, 3, n)
    axis = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)
    _put_three(motion, 6, axis)
