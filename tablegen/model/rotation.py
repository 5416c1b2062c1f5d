"""Free rotation of an asymmetric body, as a Taylor series in time.

Euler's equations and the kinematics of the wall axes seen from the body,

    J1 W1' = (J2 - J3) W2 W3 (and cyclic),   n' = n x W,   x' = x x W,

are quadratic, so their Taylor coefficients follow from one convolution an order. The series is
its own dense output: contact search evaluates a polynomial instead of integrating again.

Contact search needs W and n only. The axis x is found at the end of a step from the angular
momentum, whose horizontal part is constant in wall axes; where that part is too small to give a
direction, x has its own series.
"""

import math

import numpy as np

from sampler.jit import borrowing_kernel, kernel

#: Order of the series.
ORDER = 12

#: First row of the wall normal n in the coefficient array; before it the angular velocity, after
#: it the wall axis x, all in body axes.
NORMAL = 3

#: Least share of the squared angular momentum that must be horizontal to give the axis x.
HORIZONTAL_SHARE = 0.01


@borrowing_kernel
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
        series[i, 0] = motion[i]
    for k in range(ORDER):
        p1 = p2 = p3 = 0.0
        n1 = n2 = n3 = 0.0
        for j in range(k + 1):
            w1 = series[0, k - j]
            w2 = series[1, k - j]
            w3 = series[2, k - j]
            p1 += series[1, j] * w3
            p2 += series[2, j] * w1
            p3 += series[0, j] * w2
            a, b, c = series[3, j], series[4, j], series[5, j]
            n1 += b * w3 - c * w2
            n2 += c * w1 - a * w3
            n3 += a * w2 - b * w1
        scale = 1.0 / (k + 1)
        series[0, k + 1] = k1 * p1 * scale
        series[1, k + 1] = k2 * p2 * scale
        series[2, k + 1] = k3 * p3 * scale
        series[3, k + 1], series[4, k + 1], series[5, k + 1] = n1 * scale, n2 * scale, n3 * scale


@borrowing_kernel
def expand_axis(motion, series):
    """Taylor coefficients of x, rows 6 to 8, once those of W are known; arguments as above."""
    for i in range(6, 9):
        series[i, 0] = motion[i]
    for k in range(ORDER):
        x1 = x2 = x3 = 0.0
        for j in range(k + 1):
            w1 = series[0, k - j]
            w2 = series[1, k - j]
            w3 = series[2, k - j]
            a, b, c = series[6, j], series[7, j], series[8, j]
            x1 += b * w3 - c * w2
            x2 += c * w1 - a * w3
            x3 += a * w2 - b * w1
        scale = 1.0 / (k + 1)
        series[6, k + 1], series[7, k + 1], series[8, k + 1] = x1 * scale, x2 * scale, x3 * scale


@borrowing_kernel
def series_span(series, tolerance):
    """Time over which the truncated series stays within the tolerance.

    The last two coefficients measure the remainder, the rates relative to the largest angular
    velocity; the span makes the last term at most ``tolerance``.
    """
    rate = max(abs(series[0, 0]), abs(series[1, 0]), abs(series[2, 0]))
    if rate == 0.0:
        return math.inf
    # A term may vanish by symmetry where its neighbour does not; in units of 1 / rate the two
    # are alike.
    size = 0.0
    for i in range(3):
        size = max(size, abs(series[i, ORDER]) / rate, abs(series[i, ORDER - 1]))
    for i in range(3, 6):
        size = max(size, abs(series[i, ORDER]), abs(series[i, ORDER - 1]) * rate)
    # Two radians keep the bound honest where both terms happen to be small.
    span = 2.0 / rate
    if size > 0.0:
        span = min(span, (tolerance / size) ** (1.0 / ORDER))
    return span


@borrowing_kernel
def _polynomial(series, row, t):
    value = series[row, ORDER]
    for k in range(ORDER - 1, -1, -1):
        value = value * t + series[row, k]
    return value


@borrowing_kernel
def _horizontal_momentum(moments, motion):
    """Angular momentum along the wall axes x and z, and its square."""
    a1, a2, a3 = moments[0] * motion[0], moments[1] * motion[1], moments[2] * motion[2]
    n1, n2, n3 = motion[3], motion[4], motion[5]
    x1, x2, x3 = motion[6], motion[7], motion[8]
    l_x = a1 * x1 + a2 * x2 + a3 * x3
    l_z = a1 * (x2 * n3 - x3 * n2) + a2 * (x3 * n1 - x1 * n3) + a3 * (x1 * n2 - x2 * n1)
    return l_x, l_z, a1 * a1 + a2 * a2 + a3 * a3


@borrowing_kernel
def _axis_from_momentum(moments, l_x, l_z, motion):
    """Write x so that the horizontal angular momentum is (l_x, l_z); n and W are up to date.

    With p the part of J W normal to n, p = l_x x + l_z z and n x p = l_z x - l_x z.
    """
    n1, n2, n3 = motion[3], motion[4], motion[5]
    p1, p2, p3 = moments[0] * motion[0], moments[1] * motion[1], moments[2] * motion[2]
    l_y = p1 * n1 + p2 * n2 + p3 * n3
    p1, p2, p3 = p1 - l_y * n1, p2 - l_y * n2, p3 - l_y * n3
    motion[6] = l_x * p1 + l_z * (n2 * p3 - n3 * p2)
    motion[7] = l_x * p2 + l_z * (n3 * p1 - n1 * p3)
    motion[8] = l_x * p3 + l_z * (n1 * p2 - n2 * p1)


@borrowing_kernel
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
    if not has_direction:
        expand_axis(motion, series)
        for i in range(6, 9):
            motion[i] = _polynomial(series, i, t)
    for i in range(6):
        motion[i] = _polynomial(series, i, t)
    scale = 1.0 / math.sqrt(motion[3] ** 2 + motion[4] ** 2 + motion[5] ** 2)
    for i in range(3, 6):
        motion[i] *= scale
    if has_direction:
        _axis_from_momentum(moments, l_x, l_z, motion)
    skew = motion[3] * motion[6] + motion[4] * motion[7] + motion[5] * motion[8]
    for i in range(6, 9):
        motion[i] -= skew * motion[i - 3]
    scale = 1.0 / math.sqrt(motion[6] ** 2 + motion[7] ** 2 + motion[8] ** 2)
    for i in range(6, 9):
        motion[i] *= scale


@borrowing_kernel
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
    q1 = motion[0] * motion[0]
    q2 = motion[1] * motion[1]
    q3 = motion[2] * motion[2]
    energy = j1 * q1 + j2 * q2 + j3 * q3
    m1 = energy / j1
    m2 = energy / j2
    m3 = energy / j3
    span = j3 - j1
    if span > 0.0:
        m1 = min(m1, q1 + q2 * j2 * (j3 - j2) / (j1 * span))
        m3 = min(m3, q3 + q2 * j2 * (j2 - j1) / (j3 * span))
        if j3 > j2:
            m2 = min(m2, q2 + q1 * j1 * span / (j2 * (j3 - j2)))
        if j2 > j1:
            m2 = min(m2, q2 + q3 * j3 * span / (j2 * (j2 - j1)))
    k1 = (j2 - j3) / j1
    k2 = (j3 - j1) / j2
    k3 = (j1 - j2) / j3
    turn = math.sqrt(m1 + m2 + m3)
    change = math.sqrt(k1 * k1 * m2 * m3 + k2 * k2 * m3 * m1 + k3 * k3 * m1 * m2)
    return turn, change


@kernel
def set_orientation(u1, u2, u3, motion):
    """Write wall axes for a uniformly random rotation (Shoemake's quaternion).

    ``u1, u2, u3`` are independent and uniform on (0, 1); rows 3..8 of ``motion`` are written.
    """
    r1 = math.sqrt(1.0 - u1)
    r2 = math.sqrt(u1)
    t1 = 2.0 * np.pi * u2
    t2 = 2.0 * np.pi * u3
    x, y = r1 * math.sin(t1), r1 * math.cos(t1)
    z, w = r2 * math.sin(t2), r2 * math.cos(t2)
    motion[3] = 2.0 * (x * y - z * w)
    motion[4] = 1.0 - 2.0 * (x * x + z * z)
    motion[5] = 2.0 * (y * z + x * w)
    motion[6] = 1.0 - 2.0 * (y * y + z * z)
    motion[7] = 2.0 * (x * y + z * w)
    motion[8] = 2.0 * (x * z - y * w)
