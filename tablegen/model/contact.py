"""When and where a particle in free flight next touches the wall.

The height of a material point over the wall is y + p . n, with the height y of the centre, the
point p in body axes and the wall normal n in body axes, which the flight series gives as a
polynomial of time (`tablegen.model.rotation`). The acceleration of the point is bounded. So at any
instant there is a time before which no point can reach the wall. The search advances by that time,
never past a contact. Close to a contact it converges like Newton's method.

With n'' = n x W' + W (n . W) - n W^2, and with (p . W)(n . W) >= (p . n - |p|) W^2 / 2, a point
accelerates downwards by at most

    (|p| + p . n) W^2 / 2 + |p| |W'|.

That is little for a point low under the centre, which is on its way up. In a time s, p . n grows by
at most |p| |W| s.

Units: lengths in the half-size a, velocities in the impact speed V. The bounds are ours; the paper
finds contacts by small steps.
"""

import math

from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.rotation import NORMAL, ORDER
from tablegen.model.shapes import most_candidates, update_candidates
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
)

#: Height, in units of a, below which a point counts as touching. The search passes a contact by no
#: more than this.
CONTACT_HEIGHT = 1e-12

#: Vertices within this height of the lowest one share its contact: an edge or face that lands flat.
TIE_HEIGHT = 1e-9

#: Keeps the acceleration bound of a body at rest positive.
TINY = 1e-300


@no_refcount_inline_kernel
def _normal_and_rate(series, t):
    """Evaluate the wall normal in body axes and its rate at time t of the series."""
    n1, n2, n3 = load_three(series, NORMAL, ORDER)
    d1 = d2 = d3 = 0.0
    for k in range(ORDER - 1, -1, -1):
        d1, d2, d3 = fma(d1, t, n1), fma(d2, t, n2), fma(d3, t, n3)
        a1, a2, a3 = load_three(series, NORMAL, k)
        n1, n2, n3 = fma(n1, t, a1), fma(n2, t, a2), fma(n3, t, a3)
    return (n1, n2, n3), (d1, d2, d3)


@inline_kernel
def safe_time(gap, rate, acceleration, limit):
    """Compute the time before which gap + rate t - acceleration t^2 / 2 stays positive.

    It is at most ``limit``. The parabola is concave: if it is positive at both ends of [0, limit],
    no root is needed.
    """
    clear = gap + limit * (rate - 0.5 * acceleration * limit) > 0.0
    length = sqrt(rate * rate + 2.0 * acceleration * gap)
    rising = rate >= 0.0
    over = select(rising, rate + length, 2.0 * gap)
    under = select(rising, acceleration, length - rate)
    return select(clear, limit, minimum(limit, over / under))


@no_refcount_inline_kernel
def _height_and_rate(points, i, n, d, height, v):
    """Compute the height over the wall of point ``i`` of a body, and its rate."""
    p1, p2, p3 = load(points, (i, 0)), load(points, (i, 1)), load(points, (i, 2))
    gap = fma(p3, n[2], fma(p2, n[1], fma(p1, n[0], height)))
    return gap, fma(p3, d[2], fma(p2, d[1], fma(p1, d[0], v)))


@inline_kernel
def _fall_bound(bounding_radius, bounds, height, limit):
    """Bound the downward acceleration of a vertex over a time ``limit``.

    ``bounds`` are those on |W| and |W'|, ``height`` is that of the centre. Returns two numbers: a
    vertex at the height h over the wall accelerates downwards by at most the first plus h times the
    second.
    """
    turn, change = bounds
    half = 0.5 * turn * turn
    # p . n is h - height, and its growth over the time counts a third in the distance fallen
    constant = bounding_radius * (half + half * turn * limit * (1.0 / 3.0) + change)
    return constant - half * height + TINY, half


@no_refcount_inline_kernel
def _safe_step(body, n, d, height, v, bounds, limit):
    """Tell whether a vertex touches and approaches; and the time before which none can touch.

    A vertex that touches but does not approach counts as one at the contact height, so it sinks by
    no more than that. ``n`` and ``d`` are the wall normal in body axes and its rate, ``height`` and
    ``v`` the height and the normal velocity of the centre, ``limit`` the longest time of interest.
    """
    count = most_candidates(body.counts)
    constant, share = _fall_bound(body.bounding_radius, bounds, height, limit)
    touches = False
    lowest = gap = rate = math.inf
    drop = 0.5 * limit * limit
    for i in range(count):
        h, r = _height_and_rate(body.candidates, i, n, d, height, v)
        touches = touches | ((h <= CONTACT_HEIGHT) & (r < 0.0))
        end = fma(-drop, fma(share, h, constant), fma(limit, r, h))
        lower = end < lowest
        lowest = select(lower, end, lowest)
        gap = select(lower, h, gap)
        rate = select(lower, r, rate)
    # the vertex that would be lowest at the limit usually touches first; the loop below shortens
    # the step where another vertex may touch earlier
    gap = maximum(gap, CONTACT_HEIGHT)
    step = safe_time(gap, rate, fma(share, gap, constant), limit)
    half = 0.5 * step
    for i in range(count):
        h, r = _height_and_rate(body.candidates, i, n, d, height, v)
        h = maximum(h, CONTACT_HEIGHT)
        fall = fma(share, h, constant)
        early = fma(step, fma(-half, fall, r), h) < -0.25 * CONTACT_HEIGHT
        if any_lane(early):
            step = select(early, safe_time(h, r, fall, step), step)
            half = 0.5 * step
    return touches, step


@no_refcount_kernel
def first_contact_of_polyhedron(body, series, y, v, bounds, span):
    """Find the time of the first contact of a polyhedron within ``span``, or -1.

    ``y`` and ``v`` are the height and normal velocity of the centre now, ``bounds`` those on |W|
    and |W'| (`tablegen.model.rotation.rate_bounds`).
    """
    # the list of candidates is complete until the direction has turned by the slack of the map
    map_lifetime = body.support_map.slack / (bounds[0] + TINY)
    t = valid_until = 0.0
    lands = False
    searching = span > 0.0
    while any_lane(searching):
        n, d = _normal_and_rate(series, t)
        limit = span - t
        if body.support_map.resolution > 0:
            stale = searching & (t >= valid_until)
            update_candidates(body, n[0], n[1], n[2], stale)
            valid_until = select(stale, t + map_lifetime, valid_until)
            limit = minimum(limit, maximum(valid_until - t, 0.0))
        touches, step = _safe_step(body, n, d, fma(v, t, y), v, bounds, limit)
        lands = lands | (searching & touches)
        searching = searching & logical_not(touches)
        t = select(searching, t + step, t)
        searching = searching & (t < span)
    return select(lands, t, -1.0)


@no_refcount_kernel
def first_contact_of_ellipsoid(body, series, y, v, bounds, span):
    """Find the time of the first contact of an ellipsoid within ``span``, or -1.

    It is the first zero of F = y^2 - |D n|^2 with D = diag(1, b, c), which has the sign of the gap
    between wall and lowest point. Unlike those of the gap, its second derivatives stay bounded for
    flat and sharp bodies: |D n|^2 is 1 - n . E n with E = diag(0, 1 - b^2, 1 - c^2), and its second
    derivative is at most 2 (1 - c^2) (|n'|^2 + |n''|).
    """
    _, b, c = body.half
    b2, c2 = b * b, c * c
    turn, change = bounds
    uneven = 1.0 - c2
    acceleration = maximum(2.0 * (uneven * (2.0 * turn * turn + change) - v * v), TINY)
    t = 0.0
    lands = False
    searching = span > 0.0
    while any_lane(searching):
        n, d = _normal_and_rate(series, t)
        height = fma(v, t, y)
        h2 = n[0] * n[0] + b2 * (n[1] * n[1]) + c2 * (n[2] * n[2])
        gap = height * height - h2
        rate = 2.0 * (height * v - (n[0] * d[0] + b2 * (n[1] * d[1]) + c2 * (n[2] * d[2])))
        contact = 2.0 * CONTACT_HEIGHT * sqrt(h2)
        touches = (gap <= contact) & (rate < 0.0)
        lands = lands | (searching & touches)
        searching = searching & logical_not(touches)
        step = safe_time(maximum(gap, contact), rate, acceleration, span - t)
        t = select(searching, t + step, t)
        searching = searching & (t < span)
    return select(lands, t, -1.0)


@no_refcount_inline_kernel
def first_contact(body, series, y, v, bounds, span):
    """Find the time of the first contact of any body within ``span``, or -1."""
    if body.candidates.shape[0] == 0:
        return first_contact_of_ellipsoid(body, series, y, v, bounds, span)
    return first_contact_of_polyhedron(body, series, y, v, bounds, span)


@no_refcount_inline_kernel
def _ellipsoid_point(body, n1, n2, n3, point):
    """Write the lowest point of an ellipsoid, -D^2 n / h; return its depth h under the centre."""
    _, b, c = body.half
    m2, m3 = b * n2, c * n3
    depth = sqrt(n1 * n1 + m2 * m2 + m3 * m3)
    store(point, 0, -n1 / depth)
    store(point, 1, -b * m2 / depth)
    store(point, 2, -c * m3 / depth)
    return depth


@no_refcount_inline_kernel
def _centre_of_ties(body, n, d, v, lowest, fastest):
    """Sum up and count the vertices as low as ``lowest`` that rise slower than ``fastest``."""
    s1 = s2 = s3 = ties = 0.0
    for i in range(most_candidates(body.counts)):
        h, r = _height_and_rate(body.candidates, i, n, d, 0.0, v)
        share = select((r < fastest) & (h <= lowest + TIE_HEIGHT), 1.0, 0.0)
        s1 = fma(share, load(body.candidates, (i, 0)), s1)
        s2 = fma(share, load(body.candidates, (i, 1)), s2)
        s3 = fma(share, load(body.candidates, (i, 2)), s3)
        ties += share
    return (s1, s2, s3), ties


@no_refcount_kernel
def contact_point(body, motion, y, v, point):
    """Put the contact point, from the centre in body axes, into ``point``; return its height.

    Where several vertices touch and approach together, the contact is the centre of their edge
    or face (paper, Sec. 1); a vertex that touches but is already rising has no part in it.
    """
    n = n1, n2, n3 = load(motion, 3), load(motion, 4), load(motion, 5)
    if body.candidates.shape[0] == 0:
        return y - _ellipsoid_point(body, n1, n2, n3, point)
    update_candidates(body, n1, n2, n3, n1 == n1)
    # rate of a material point p: v + p . (n x W)
    w1, w2, w3 = load(motion, 0), load(motion, 1), load(motion, 2)
    d = n2 * w3 - n3 * w2, n3 * w1 - n1 * w3, n1 * w2 - n2 * w1
    lowest = math.inf
    for i in range(most_candidates(body.counts)):
        lowest = minimum(lowest, _height_and_rate(body.candidates, i, n, d, 0.0, v)[0])
    total, ties = _centre_of_ties(body, n, d, v, lowest, 0.0)
    none_approaching = ties == 0.0
    if any_lane(none_approaching):
        # by rounding, none may approach where the last vertex that did is just turning upwards
        all_sum, all_count = _centre_of_ties(body, n, d, v, lowest, math.inf)
        total = select_three(none_approaching, all_sum, total)
        ties = select(none_approaching, all_count, ties)
    for i in range(3):
        store(point, i, total[i] / ties)
    return y + lowest
