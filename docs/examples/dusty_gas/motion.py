"""Motion of a particle over one step, and the instant at which it meets the body.

A step is one of the classical Runge-Kutta method, of fourth order. The end of a step is a smooth
function of its length, so a hit is the length at which the step ends on the surface; it is found
to rounding, and the order of the method is kept. The closest approach within a step is looked
for, so that no hit is jumped over: for steps short beside the body, within which a path turns
towards or away from the body once.
"""

from sampler.compilation.jit import inline_kernel, kernel

from dusty_gas.gas import SPHERE, acceleration, radius

#: Iterations after which a bracket of any length has shrunk to neighbouring numbers.
_BISECTIONS = 80


@inline_kernel
def _slope(flow, p):
    a = acceleration(flow, p[0], p[1], p[2], p[3], p[4], p[5])
    return p[3], p[4], p[5], a[0], a[1], a[2]


@inline_kernel
def _shifted(p, h, k):
    return (
        p[0] + h * k[0],
        p[1] + h * k[1],
        p[2] + h * k[2],
        p[3] + h * k[3],
        p[4] + h * k[4],
        p[5] + h * k[5],
    )


@kernel
def step(flow, p, h):
    """Position and velocity after a time h.

    Parameters
    ----------
    flow : Flow
    p : tuple of six float
        Position and velocity.
    h : float

    Returns
    -------
    tuple of six float
    """
    k1 = _slope(flow, p)
    k2 = _slope(flow, _shifted(p, 0.5 * h, k1))
    k3 = _slope(flow, _shifted(p, 0.5 * h, k2))
    k4 = _slope(flow, _shifted(p, h, k3))
    middle = _shifted(_shifted(p, h / 3.0, k2), h / 3.0, k3)
    return _shifted(_shifted(middle, h / 6.0, k1), h / 6.0, k4)


@inline_kernel
def gap(flow, p):
    """Distance from the surface."""
    return radius(flow.body, p[0], p[1], p[2]) - 1.0


@inline_kernel
def climb(flow, p):
    """Speed away from the surface, times the distance from the axis or centre."""
    return p[0] * p[3] + p[1] * p[4] + (p[2] * p[5] if flow.body == SPHERE else 0.0)


@kernel
def _turning_time(flow, p, h):
    """Time in (0, h) at which the climb changes its sign, which it does between the ends."""
    low, high = 0.0, h
    rising = climb(flow, p) > 0.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if (climb(flow, step(flow, p, middle)) > 0.0) == rising:
            low = middle
        else:
            high = middle
    return low


@kernel
def _hit_time(flow, p, low, high):
    """Time of the hit between `low`, outside the body, and `high`, inside: Newton in a bracket."""
    t = 0.5 * (low + high)
    for _ in range(_BISECTIONS):
        q = step(flow, p, t)
        over = gap(flow, q)
        if over > 0.0:
            low = t
        else:
            high = t
        fall = climb(flow, q)
        newton = t - over * (over + 1.0) / fall if fall != 0.0 else low
        if newton == t:
            break
        t = newton if low < newton < high else 0.5 * (low + high)
        if not low < t < high:
            break
    return t


@kernel
def advance(flow, p, h):
    """Move a particle that is outside the body or on it for a time h, or to its hit.

    Parameters
    ----------
    flow : Flow
    p : tuple of six float
        Position and velocity.
    h : float

    Returns
    -------
    tuple (bool, float, tuple of six float)
        Whether it hits, after which time, and position and velocity then; on the surface to
        rounding if it hits.
    """
    end = step(flow, p, h)
    inside = gap(flow, end) <= 0.0
    falls = climb(flow, p) < 0.0
    low, high = 0.0, h
    if falls and not inside and climb(flow, end) > 0.0:
        high = _turning_time(flow, p, h)
        inside = gap(flow, step(flow, p, high)) < 0.0
    if not inside:
        return False, h, end
    if not falls:
        # It has risen before; at the top of a bounce too low for the numbers it is not outside.
        low = _turning_time(flow, p, h)
    t = _hit_time(flow, p, low, high)
    q = step(flow, p, t)
    shrink = 1.0 / radius(flow.body, q[0], q[1], q[2])
    z = q[2] * shrink if flow.body == SPHERE else q[2]
    return True, t, (q[0] * shrink, q[1] * shrink, z, q[3], q[4], q[5])
