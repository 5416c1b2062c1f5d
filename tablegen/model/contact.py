"""When and where a free particle next touches the wall.

The height of a material point is a polynomial of the flight series. Its acceleration is bounded
for the whole flight, so from any instant there is a time before which no point can have reached
the wall. The search moves by that time, never past a contact; next to a contact it converges
like Newton's method, because the bound is exact to second order.
"""

import math

from sampler.jit import borrowing_inline_kernel, borrowing_kernel
from tablegen.model.rotation import NORMAL, ORDER
from tablegen.model.shapes import lowest_candidates

#: Height, in units of a, below which a point counts as touching. The search overshoots a contact
#: by no more than this.
CONTACT_HEIGHT = 1e-12

#: Vertices within this height of the lowest one share its contact: an edge or face that lands flat.
TIE_HEIGHT = 1e-9

#: Keeps the acceleration bound of a body at rest positive.
TINY = 1e-300


@borrowing_inline_kernel
def _normal_and_rate(series, t):
    """Wall normal in body axes and its rate at time t, from the series."""
    n1 = series[NORMAL, ORDER]
    n2 = series[NORMAL + 1, ORDER]
    n3 = series[NORMAL + 2, ORDER]
    d1 = d2 = d3 = 0.0
    for k in range(ORDER - 1, -1, -1):
        d1 = d1 * t + n1
        d2 = d2 * t + n2
        d3 = d3 * t + n3
        n1 = n1 * t + series[NORMAL, k]
        n2 = n2 * t + series[NORMAL + 1, k]
        n3 = n3 * t + series[NORMAL + 2, k]
    return n1, n2, n3, d1, d2, d3


@borrowing_inline_kernel
def safe_time(gap, rate, acceleration, limit):
    """Time, at most ``limit``, before which gap + rate t - acceleration t^2 / 2 stays positive.

    The parabola is concave, so being positive at both ends of [0, limit] settles the matter
    without a root.
    """
    if gap + limit * (rate - 0.5 * acceleration * limit) > 0.0:
        return limit
    root = math.sqrt(rate * rate + 2.0 * acceleration * gap)
    if rate >= 0.0:
        return min(limit, (rate + root) / acceleration)
    return min(limit, 2.0 * gap / (root - rate))


@borrowing_kernel
def search_polyhedron(body, series, y, v, bounds, span):
    """First contact of a polyhedron within ``span``.

    Parameters
    ----------
    body : Body
    series : (9, ORDER + 1) float64
    y, v : float
        Height and normal velocity of the centre now.
    bounds : tuple of two floats
        Bounds on |W| and |W'| (see rotation.rate_bounds).
    span : float

    Returns
    -------
    float
        Time of the contact, or -1 if there is none within the span.
    """
    turn, change = bounds
    acceleration = body.reach * (turn * turn + change) + TINY
    least = math.sqrt(2.0 * CONTACT_HEIGHT / acceleration)
    # the candidates found for a direction serve until it has turned by the slack of their map
    patience = body.near.slack / (turn + TINY)
    t = 0.0
    while True:
        n1, n2, n3, d1, d2, d3 = _normal_and_rate(series, t)
        height = y + v * t
        step = min(span - t, patience)
        points, first, end = lowest_candidates(body, n1, n2, n3)
        for i in range(first, end):
            p1, p2, p3 = points[i, 0], points[i, 1], points[i, 2]
            gap = height + p1 * n1 + p2 * n2 + p3 * n3
            rate = v + p1 * d1 + p2 * d2 + p3 * d3
            if gap <= CONTACT_HEIGHT:
                if rate < 0.0:
                    return t
                # touching but not approaching: sinks by no more than the contact height
                step = min(step, max(least, safe_time(0.0, rate, acceleration, step)))
            else:
                step = safe_time(gap, rate, acceleration, step)
        t += step
        if t >= span:
            return -1.0


@borrowing_kernel
def search_ellipsoid(body, series, y, v, bounds, span):
    """First contact of an ellipsoid within ``span``.

    Works with F = y^2 - |D n|^2, D = diag(1, b, c), which has the sign of the gap y - h and,
    unlike it, second derivatives that stay bounded for flat and sharp bodies. Parameters and
    result as in :func:`search_polyhedron`.
    """
    b2, c2 = body.b * body.b, body.c * body.c
    turn, change = bounds
    acceleration = max(2.0 * (2.0 * turn * turn + change - v * v), TINY)
    least = math.sqrt(2.0 * CONTACT_HEIGHT * body.c / acceleration)
    t = 0.0
    while True:
        n1, n2, n3, d1, d2, d3 = _normal_and_rate(series, t)
        height = y + v * t
        h2 = n1 * n1 + b2 * n2 * n2 + c2 * n3 * n3
        gap = height * height - h2
        rate = 2.0 * (height * v - (n1 * d1 + b2 * n2 * d2 + c2 * n3 * d3))
        if gap <= 2.0 * CONTACT_HEIGHT * math.sqrt(h2):
            if rate < 0.0:
                return t
            t += max(least, safe_time(0.0, rate, acceleration, span - t))
        else:
            t += safe_time(gap, rate, acceleration, span - t)
        if t >= span:
            return -1.0


@borrowing_inline_kernel
def search(body, series, y, v, bounds, span):
    """First contact of any body within ``span``; -1 if there is none."""
    if body.vertices.shape[0] == 0:
        return search_ellipsoid(body, series, y, v, bounds, span)
    return search_polyhedron(body, series, y, v, bounds, span)


@borrowing_inline_kernel
def _ellipsoid_point(body, n1, n2, n3, point):
    """Lowest point of an ellipsoid, -D^2 n / h; returns its depth h."""
    depth = math.sqrt(n1 * n1 + (body.b * n2) ** 2 + (body.c * n3) ** 2)
    point[0] = -n1 / depth
    point[1] = -body.b * body.b * n2 / depth
    point[2] = -body.c * body.c * n3 / depth
    return depth


@borrowing_kernel
def contact_point(body, motion, y, v, point):
    """Put the contact point, from the centre in body axes, into ``point``; return its height.

    Where several vertices touch and approach together, the contact is the centre of their edge
    or face (paper, Sec. 1); a vertex that touches but is already rising has no part in it.

    Parameters
    ----------
    body : Body
    motion : (>= 9,) float64
        Angular velocity, wall normal and wall x axis in body axes.
    y, v : float
        Height and normal velocity of the centre.
    point : (3,) float64
        Output.
    """
    n1, n2, n3 = motion[3], motion[4], motion[5]
    if body.vertices.shape[0] == 0:
        return y - _ellipsoid_point(body, n1, n2, n3, point)
    vertices, first, end = lowest_candidates(body, n1, n2, n3)
    # rate of a material point p: v + p . (n x W)
    d1 = n2 * motion[2] - n3 * motion[1]
    d2 = n3 * motion[0] - n1 * motion[2]
    d3 = n1 * motion[1] - n2 * motion[0]
    lowest = math.inf
    for i in range(first, end):
        p1, p2, p3 = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        lowest = min(lowest, p1 * n1 + p2 * n2 + p3 * n3)
    # Of the vertices that touch only those that approach collide; rounding may leave none, where
    # the last of them is just turning.
    for fastest in (0.0, math.inf):
        ties = 0
        point[0] = point[1] = point[2] = 0.0
        for i in range(first, end):
            p1, p2, p3 = vertices[i, 0], vertices[i, 1], vertices[i, 2]
            approaches = v + p1 * d1 + p2 * d2 + p3 * d3 < fastest
            if approaches and p1 * n1 + p2 * n2 + p3 * n3 <= lowest + TIE_HEIGHT:
                point[0] += p1
                point[1] += p2
                point[2] += p3
                ties += 1
        if ties > 0:
            break
    for i in range(3):
        point[i] /= ties
    return y + lowest
