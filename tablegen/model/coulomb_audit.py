"""Check of a collision under Coulomb friction, by small steps along its defining equations.

The normal impulse is taken from the motion after the collision, and friction and work are followed
up to it in the variable s by the classical Runge-Kutta method, with steps in proportion to the
slide. Nothing is shared with `tablegen.model.coulomb`, which uses series in another variable.
"""

import math

from tablegen.model.jit import kernel

#: Step over the least impulse that could turn or stop the slide.
STEP = 0.02

#: Slide over the contact speed that counts as rest.
REST = 1e-11

#: Halvings of a step that ends where compression does.
SECANTS = 8


@kernel
def contact_mobility(moments, point, motion):
    """Entries A_xx, A_xy, A_xz, A_yy, A_yz, A_zz of dV_c = A dV_p at a contact point."""
    r1, r2, r3 = point
    x1, x2, x3 = motion[6], motion[7], motion[8]
    n1, n2, n3 = motion[3], motion[4], motion[5]
    z1, z2, z3 = x2 * n3 - x3 * n2, x3 * n1 - x1 * n3, x1 * n2 - x2 * n1
    a = r2 * x3 - r3 * x2, r3 * x1 - r1 * x3, r1 * x2 - r2 * x1
    b = r2 * n3 - r3 * n2, r3 * n1 - r1 * n3, r1 * n2 - r2 * n1
    c = r2 * z3 - r3 * z2, r3 * z1 - r1 * z3, r1 * z2 - r2 * z1
    xx, xy, xz, yy, yz, zz = 1.0, 0.0, 0.0, 1.0, 0.0, 1.0
    for i in range(3):
        xx += a[i] * a[i] / moments[i]
        xy += a[i] * b[i] / moments[i]
        xz += a[i] * c[i] / moments[i]
        yy += b[i] * b[i] / moments[i]
        yz += b[i] * c[i] / moments[i]
        zz += c[i] * c[i] / moments[i]
    return xx, xy, xz, yy, yz, zz


@kernel
def _rates(friction, mobility, state, holds):
    """Rates in s of the contact velocity (u, v, w) and of the normal work."""
    xx, xy, xz, yy, yz, zz = mobility
    u, v, w, _ = state
    if holds:
        det = xx * zz - xz * xz
        f_x, f_z = (zz * xy - xz * yz) / det, (xx * yz - xz * xy) / det
        return 0.0, yy - xy * f_x - yz * f_z, 0.0, v
    slide = math.sqrt(u * u + w * w)
    f_x, f_z = friction * u / slide, friction * w / slide
    return xy - xx * f_x - xz * f_z, yy - xy * f_x - yz * f_z, yz - xz * f_x - zz * f_z, v


@kernel
def _moved(state, rates, h):
    """State after a step with constant rates."""
    return (
        state[0] + h * rates[0],
        state[1] + h * rates[1],
        state[2] + h * rates[2],
        state[3] + h * rates[3],
    )


@kernel
def _stepped(friction, mobility, state, holds, h):
    """State after one step of the classical Runge-Kutta method."""
    a = _rates(friction, mobility, state, holds)
    b = _rates(friction, mobility, _moved(state, a, 0.5 * h), holds)
    c = _rates(friction, mobility, _moved(state, b, 0.5 * h), holds)
    d = _rates(friction, mobility, _moved(state, c, h), holds)
    mean = (
        (a[0] + 2.0 * (b[0] + c[0]) + d[0]) / 6.0,
        (a[1] + 2.0 * (b[1] + c[1]) + d[1]) / 6.0,
        (a[2] + 2.0 * (b[2] + c[2]) + d[2]) / 6.0,
        (a[3] + 2.0 * (b[3] + c[3]) + d[3]) / 6.0,
    )
    return _moved(state, mean, h)


@kernel
def _least_work(friction, mobility, state, holds, after, h):
    """Work where the normal velocity passes through zero on a step from below to above."""
    t = h
    for _ in range(SECANTS):
        t *= state[1] / (state[1] - after[1])
        after = _stepped(friction, mobility, state, holds, t)
    return after[3]


@kernel
def static_hold(mobility):
    """Tangential impulse over the normal one that holds a contact at rest: |A_tt^-1 A_tn|."""
    xx, xy, xz, _, yz, zz = mobility
    det = xx * zz - xz * xz
    return math.hypot((zz * xy - xz * yz) / det, (xx * yz - xz * xy) / det)


@kernel
def followed(static, dynamic, mobility, velocity, impulse):
    """Contact velocity and work at a normal impulse, by small steps.

    Parameters
    ----------
    static, dynamic : float
        Coefficients of friction.
    mobility : tuple of six floats
    velocity : tuple of three floats
        Before the collision, (u, v, w).
    impulse : float
        Normal impulse of the collision.

    Returns
    -------
    tuple (u, v, w, work, least work)
    """
    xx, xy, _, _, yz, zz = mobility
    size = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    rate = math.hypot(xy, yz) + dynamic * (xx + zz)
    state = velocity[0], velocity[1], velocity[2], 0.0
    least, left = 0.0, impulse
    holds = slips = False
    while left > 0.0:
        slide = math.hypot(state[0], state[2])
        if slide <= REST * size and not slips:
            holds = static_hold(mobility) <= static
            slips = not holds
            # a slip grows from a push along the pull of the wall, and soon forgets it
            push = REST * size / math.hypot(xy, yz) if slips else 0.0
            state = push * xy, state[1], push * yz, state[3]
            slide = REST * size
        h = left if holds else min(left, STEP * slide / rate)
        after = _stepped(dynamic, mobility, state, holds, h)
        if state[1] < 0.0 < after[1]:
            least = min(least, _least_work(dynamic, mobility, state, holds, after, h))
        state, left = after, left - h
        least = min(least, state[3])
    return state[0], state[1], state[2], state[3], least
