"""Checks of every collision and flight against the laws that they must obey.

The audit computes each law again in its defining form, from the motion before and after, and keeps
the largest violation:

- energy does not grow, and J dW = r x S;
- v_c+ = -a_nc v_c-, equation (6), and S_t opposes the mean tangential contact velocity in
  proportion to C_f S_n, equations (5) and (7);
- under Coulomb friction, a collision followed by small steps of Runge-Kutta's method along its
  defining equations ends with the same velocity and the energetic restitution;
- in flight, energy and angular momentum are constant.

It shares no intermediate result with the solvers that it checks, only the contact laws, which have
tests of their own. `tablegen.model.coulomb` follows a collision by series in another variable.

Units: velocities in the impact speed V, lengths in a, mass one.
Sources: Panfilov & Tsirkunov 2022, equations (1) to (7), and those of `tablegen.model.coulomb`.
"""

import math

from tablegen.model.contact_laws import COULOMB, resistance, restitution
from tablegen.model.jit import inline_kernel, kernel
from tablegen.model.vectors import combine, cross, dot

#: Entries of an audit array.
ENERGY, ANGULAR, NORMAL, TANGENTIAL, PENETRATION, FLIGHT_ENERGY, FLIGHT_MOMENTUM = range(7)
AUDIT_SIZE = 7

#: Length of a step over the least impulse that could turn or stop the slide.
_STEP = 0.02

#: Over the contact speed: the sliding velocity below which a contact rests, and the change of
#: direction below which a slide is straight.
_REST = 1e-11

#: Share of the impulse to rest that a straight step takes.
_SHORT = 1.0 - 1e-6

#: Number of secant steps to the end of compression.
_SECANTS = 8


@inline_kernel
def _row(motion, first):
    """Read three entries of a motion."""
    return motion[first], motion[first + 1], motion[first + 2]


@inline_kernel
def _norm(a):
    return math.sqrt(dot(a, a))


@kernel
def wall_vector(motion, a):
    """Convert a vector from body axes to wall axes x, y, z."""
    n, x = _row(motion, 3), _row(motion, 6)
    return dot(a, x), dot(a, n), dot(a, cross(x, n))


@kernel
def contact_velocity(motion, point):
    """Compute the velocity of the material point ``point`` in wall axes, equation (2)."""
    turning = wall_vector(motion, cross(_row(motion, 0), _row(point, 0)))
    return combine(1.0, _row(motion, 9), 1.0, turning)


@inline_kernel
def _momentum(moments, w):
    """Compute the angular momentum in body axes from the angular velocity."""
    return moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]


@kernel
def total_energy(moments, motion):
    """Compute the kinetic energy per unit mass."""
    w, v = _row(motion, 0), _row(motion, 9)
    return 0.5 * (dot(w, _momentum(moments, w)) + dot(v, v))


@inline_kernel
def _impulse(before, after):
    return combine(1.0, _row(after, 9), -1.0, _row(before, 9))


@kernel
def _audit_torque(moments, point, before, after, audit):
    """Check J dW = r x S."""
    turned = combine(1.0, _row(after, 0), -1.0, _row(before, 0))
    torque = cross(wall_vector(before, _row(point, 0)), _impulse(before, after))
    miss = combine(1.0, torque, -1.0, wall_vector(before, _momentum(moments, turned)))
    audit[ANGULAR] = max(audit[ANGULAR], abs(miss[0]) + abs(miss[1]) + abs(miss[2]))


@kernel
def _audit_resistance(law, speed, resolution, point, before, after, audit):
    """Check equations (5), (6) and (7).

    If the rebound velocity by (6) is below the resolution, the contact may leave with the
    resolution or, where that would add energy, with the speed of its approach.
    """
    s_x, s_y, s_z = _impulse(before, after)
    u0, v0, w0 = contact_velocity(before, point)
    u1, v1, w1 = contact_velocity(after, point)
    size = math.sqrt(u0 * u0 + v0 * v0 + w0 * w0)
    a_nc = restitution(law, speed * size, -v0 / size)
    miss = abs(v1 + a_nc * v0)
    if -a_nc * v0 < resolution:
        miss = min(abs(v1 - resolution), abs(v1 + max(1.0, a_nc) * v0))
    audit[NORMAL] = max(audit[NORMAL], miss)

    r, centre = wall_vector(before, _row(point, 0)), _row(before, 9)
    c_f = resistance(law, dot(r, centre), _norm(r), _norm(centre), -v0 / size)
    factor = c_f * s_y / size
    slip = abs(s_x + factor * 0.5 * (u0 + u1)) + abs(s_z + factor * 0.5 * (w0 + w1))
    audit[TANGENTIAL] = max(audit[TANGENTIAL], slip)


@kernel
def contact_mobility(moments, point, motion):
    """Compute the mobility at a contact point: A_xx, A_xy, A_xz, A_yy, A_yz, A_zz."""
    r, n, x = _row(point, 0), _row(motion, 3), _row(motion, 6)
    a, b, c = cross(r, x), cross(r, n), cross(r, cross(x, n))
    inverse = 1.0 / moments[0], 1.0 / moments[1], 1.0 / moments[2]
    ai, bi, ci = _momentum(inverse, a), _momentum(inverse, b), _momentum(inverse, c)
    diagonal = 1.0 + dot(a, ai), 1.0 + dot(b, bi), 1.0 + dot(c, ci)
    return diagonal[0], dot(a, bi), dot(a, ci), diagonal[1], dot(b, ci), diagonal[2]


@inline_kernel
def _holding_impulse(mobility):
    """Compute minus the tangential over the normal impulse that holds a contact at rest."""
    xx, xy, xz, _, yz, zz = mobility
    det = xx * zz - xz * xz
    return (zz * xy - xz * yz) / det, (xx * yz - xz * xy) / det


@kernel
def static_hold(mobility):
    """Compute |A_tt^-1 A_tn|, the tangential over the normal impulse that holds a contact."""
    x, z = _holding_impulse(mobility)
    return math.hypot(x, z)


@kernel
def _rates(friction, mobility, state, holds):
    """Compute the rates in s of the contact velocity (u, v, w) and of the normal work."""
    xx, xy, xz, yy, yz, zz = mobility
    u, v, w, _ = state
    if holds:
        f_x, f_z = _holding_impulse(mobility)
        return 0.0, yy - xy * f_x - yz * f_z, 0.0, v
    slide = math.sqrt(u * u + w * w)
    f_x, f_z = friction * u / slide, friction * w / slide
    return xy - xx * f_x - xz * f_z, yy - xy * f_x - yz * f_z, yz - xz * f_x - zz * f_z, v


@kernel
def _sum_with_factor(a, h, b):
    """Compute a + h b for states of four numbers."""
    return a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2], a[3] + h * b[3]


@kernel
def _state_after_step(friction, mobility, state, holds, h):
    """Compute the state after one step of the classical Runge-Kutta method."""
    a = _rates(friction, mobility, state, holds)
    b = _rates(friction, mobility, _sum_with_factor(state, 0.5 * h, a), holds)
    c = _rates(friction, mobility, _sum_with_factor(state, 0.5 * h, b), holds)
    d = _rates(friction, mobility, _sum_with_factor(state, h, c), holds)
    total = _sum_with_factor(_sum_with_factor(a, 2.0, b), 1.0, _sum_with_factor(d, 2.0, c))
    return _sum_with_factor(state, h / 6.0, total)


@kernel
def _least_work(friction, mobility, state, holds, after, h):
    """Compute the work where the normal velocity passes through zero on a step, upwards."""
    t = h
    for _ in range(_SECANTS):
        t *= state[1] / (state[1] - after[1])
        after = _state_after_step(friction, mobility, state, holds, t)
    return after[3]


@kernel
def _straight_step(rates, state, left, size):
    """Compute the length of a step in which a slide keeps its direction, or 0 if it turns.

    The step ends where the normal velocity is zero, and shortly before rest. Small steps alone
    would take too long where a slide near rest grows slowly in a fixed direction.
    """
    slide = math.hypot(state[0], state[2])
    along = (rates[0] * state[0] + rates[2] * state[2]) / slide
    across = (rates[2] * state[0] - rates[0] * state[2]) / slide
    if abs(across) * left > _REST * size:
        return 0.0
    h = left if along >= 0.0 else min(left, _SHORT * slide / -along)
    return min(h, -state[1] / rates[1]) if state[1] < 0.0 < rates[1] else h


@kernel
def state_after_impulse(static, dynamic, mobility, velocity, impulse):
    """Follow a collision by small steps up to a normal impulse.

    Returns the contact velocity (u, v, w), the work and the least work. ``static`` and ``dynamic``
    are the coefficients of friction; ``velocity`` is the contact velocity before the collision.
    """
    xx, xy, _, _, yz, zz = mobility
    size = _norm(velocity)
    rate = math.hypot(xy, yz) + dynamic * (xx + zz)
    state = velocity[0], velocity[1], velocity[2], 0.0
    least, left = 0.0, impulse
    holds = slips = False
    while left > 0.0:
        slide = math.hypot(state[0], state[2])
        if slide <= _REST * size and not slips:
            holds = static_hold(mobility) <= static
            slips = not holds
            # a slip begins with a small push along the pull of the wall, which it soon forgets
            push = _REST * size / math.hypot(xy, yz) if slips else 0.0
            state = push * xy, state[1], push * yz, state[3]
            slide = _REST * size
        rates = _rates(dynamic, mobility, state, holds)
        straight = 0.0 if holds else _straight_step(rates, state, left, size)
        if straight > 0.0:
            u, v, w, work = _sum_with_factor(state, straight, rates)
            state = u, v, w, work + 0.5 * straight * straight * rates[1]
            left, least = left - straight, min(least, state[3])
            continue
        h = left if holds else min(left, _STEP * slide / rate)
        after = _state_after_step(dynamic, mobility, state, holds, h)
        if state[1] < 0.0 < after[1]:
            least = min(least, _least_work(dynamic, mobility, state, holds, after, h))
        state, left = after, left - h
        least = min(least, state[3])
    return state[0], state[1], state[2], state[3], least


@kernel
def _audit_coulomb(law, speed, resolution, moments, point, before, after, audit):
    """Check Coulomb's law along the collision, its cone, and the energetic restitution.

    The work of the normal impulse must be the share 1 - e^2 of the work of compression. It may be
    closer to zero where the contact leaves with the resolution, or elastically.
    """
    s_x, s_y, s_z = _impulse(before, after)
    velocity = contact_velocity(before, point)
    u1, v1, w1 = contact_velocity(after, point)
    size = _norm(velocity)
    a_nc = restitution(law, speed * size, -velocity[1] / size)
    mobility = contact_mobility(moments, point, before)
    u, v, w, work, least = state_after_impulse(law.strength, law.factor, mobility, velocity, s_y)
    miss = work - (1.0 - a_nc * a_nc) * least
    if miss > 0.0:
        miss = min(miss, abs(v1 - resolution), abs(work))
    audit[NORMAL] = max(audit[NORMAL], abs(miss), abs(v - v1))
    hold = static_hold(mobility)
    cone = max(law.factor, hold if hold <= law.strength else 0.0) * s_y
    outside = math.hypot(s_x, s_z) - cone
    audit[TANGENTIAL] = max(audit[TANGENTIAL], abs(u - u1), abs(w - w1), outside)


@kernel
def audit_collision(law, speed, resolution, moments, point, before, after, audit):
    """Check one collision: energy, J dW = r x S, and the contact laws.

    ``point`` (3,) is the contact, ``before`` and ``after`` (13,) are the motion. The largest
    violations are kept in ``audit`` (AUDIT_SIZE,).
    """
    gain = total_energy(moments, after) - total_energy(moments, before)
    audit[ENERGY] = max(audit[ENERGY], gain)
    _audit_torque(moments, point, before, after, audit)
    _, v, _ = contact_velocity(before, point)
    # a contact that approaches more slowly than the resolution follows the constant law instead
    if law.resistance_law == COULOMB and v <= -resolution:
        _audit_coulomb(law, speed, resolution, moments, point, before, after, audit)
    else:
        _audit_resistance(law, speed, resolution, point, before, after, audit)


@kernel
def audit_flight(moments, before, after, audit):
    """Check that a flight keeps energy and angular momentum in wall axes, both relative."""
    energy = total_energy(moments, before)
    drift = abs(total_energy(moments, after) - energy) / energy
    audit[FLIGHT_ENERGY] = max(audit[FLIGHT_ENERGY], drift)
    first = wall_vector(before, _momentum(moments, _row(before, 0)))
    last = wall_vector(after, _momentum(moments, _row(after, 0)))
    size = _norm(first)
    if size > 0.0:
        drift = _norm(combine(1.0, last, -1.0, first)) / size
        audit[FLIGHT_MOMENTUM] = max(audit[FLIGHT_MOMENTUM], drift)
