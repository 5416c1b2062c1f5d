"""A whole rebound: collisions and free flights until the particle has left the wall.

Units: lengths in a, velocities in the impact speed V, angular velocities in V / a, mass one.
The motion is kept in one array so that every piece of the model reads the same state:

    0:3  angular velocity in body axes
    3:6  wall normal n in body axes
    6:9  wall axis x in body axes
    9:12 velocity of the centre in wall axes (u, v, w)
    12   height of the centre over the wall

The angular velocity changes in flight (the body tumbles), so the state after a rebound needs an
instant: it is the one at which the centre is `CLEARANCE` above the largest radius of the particle,
where no point of it can touch the wall any more.
"""

import math
from typing import NamedTuple

import numpy as np

from sampler.jit import borrowing_kernel, inline_kernel, kernel
from tablegen.model.audit import PENETRATION, audit_collision, audit_flight
from tablegen.model.collision import energy_gain, impulse
from tablegen.model.contact import contact_point, search
from tablegen.model.laws import resistance, restitution
from tablegen.model.rotation import ORDER, evaluate, expand, rate_bounds, series_span
from tablegen.model.shapes import lowest_depth

MOTION_SIZE = 13
U, V, W, HEIGHT = 9, 10, 11, 12

#: Results of :func:`rebound`.
LEFT, UNFINISHED = 0, 1

#: Collisions after which a particle is reported as unfinished. It is an alarm, not a cap: the
#: caller must raise, never use the state. The longest chain met at the default resolution has
#: some hundreds of collisions.
COLLISION_ALARM = 100_000_000

#: Height over its reach at which a particle has left and its state is taken. Any positive height
#: would do; this one is the mean height gained in half a step of 0.04 rad, by which the independent
#: reference simulation passes the reach. At zero, correlations of omega_x and omega_y differ from
#: the reference's by up to 0.008, at this height by no more than its noise.
CLEARANCE = 0.006


class Condition(NamedTuple):
    """Impact condition and numerical parameters of a rebound.

    ``alpha1`` [rad], ``speed`` [m/s], ``spin``: angular velocity before the impact in wall axes
    times a / V, ``resolution``: smallest rebound speed of a contact point over V, ``tolerance``:
    truncation of the flight series.
    """

    alpha1: float
    speed: float
    spin: tuple[float, float, float]
    resolution: float
    tolerance: float


@inline_kernel
def _cross(a1, a2, a3, b1, b2, b3):
    return a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1


@inline_kernel
def rotational_energy(moments, motion):
    """Rotational energy per unit mass, in units of V^2."""
    j1, j2, j3 = moments
    return 0.5 * (j1 * motion[0] ** 2 + j2 * motion[1] ** 2 + j3 * motion[2] ** 2)


@inline_kernel
def wall_spin(motion):
    """Angular velocity in wall axes."""
    w1, w2, w3 = motion[0], motion[1], motion[2]
    n1, n2, n3 = motion[3], motion[4], motion[5]
    x1, x2, x3 = motion[6], motion[7], motion[8]
    z1, z2, z3 = _cross(x1, x2, x3, n1, n2, n3)
    return (
        w1 * x1 + w2 * x2 + w3 * x3,
        w1 * n1 + w2 * n2 + w3 * n3,
        w1 * z1 + w2 * z2 + w3 * z3,
    )


@borrowing_kernel
def collide(law, speed, resolution, moments, point, motion):
    """Apply one collision at the contact ``point`` to ``motion``.

    The rebound velocity of the contact point is a_nc |v_c| (6), or the resolution where that is
    smaller: tiny bounces are nearly elastic and would go on for ever (sustained contact).

    Parameters
    ----------
    law : LawArguments
        Laws that stand for (6) and (7).
    speed : float
        Impact speed V [m/s].
    resolution : float
        Smallest rebound speed of the contact point over V.
    moments : tuple of three floats
        Principal moments of inertia per unit mass.
    point : (3,) float64
        Contact point from the centre, body axes.
    motion : (13,) float64
    """
    n1, n2, n3 = motion[3], motion[4], motion[5]
    x1, x2, x3 = motion[6], motion[7], motion[8]
    r1, r2, r3 = point[0], point[1], point[2]
    z1, z2, z3 = _cross(x1, x2, x3, n1, n2, n3)
    # r x e for each wall axis e: the torque arm of an impulse along e
    a1, a2, a3 = _cross(r1, r2, r3, x1, x2, x3)
    b1, b2, b3 = _cross(r1, r2, r3, n1, n2, n3)
    c1, c2, c3 = _cross(r1, r2, r3, z1, z2, z3)
    i1, i2, i3 = 1.0 / moments[0], 1.0 / moments[1], 1.0 / moments[2]
    mobility = (
        1.0 + a1 * a1 * i1 + a2 * a2 * i2 + a3 * a3 * i3,
        a1 * b1 * i1 + a2 * b2 * i2 + a3 * b3 * i3,
        a1 * c1 * i1 + a2 * c2 * i2 + a3 * c3 * i3,
        1.0 + b1 * b1 * i1 + b2 * b2 * i2 + b3 * b3 * i3,
        b1 * c1 * i1 + b2 * c2 * i2 + b3 * c3 * i3,
        1.0 + c1 * c1 * i1 + c2 * c2 * i2 + c3 * c3 * i3,
    )
    w1, w2, w3 = motion[0], motion[1], motion[2]
    u, v, w = motion[U], motion[V], motion[W]
    # contact velocity (2)
    u_c = u + w1 * a1 + w2 * a2 + w3 * a3
    v_c = v + w1 * b1 + w2 * b2 + w3 * b3
    w_c = w + w1 * c1 + w2 * c2 + w3 * c3
    size_c = math.sqrt(u_c * u_c + v_c * v_c + w_c * w_c)
    bounce = restitution(law, speed * size_c, -v_c / size_c) * -v_c
    r_dot_v = u * (r1 * x1 + r2 * x2 + r3 * x3) + v * (r1 * n1 + r2 * n2 + r3 * n3)
    r_dot_v += w * (r1 * z1 + r2 * z2 + r3 * z3)
    r_length = math.sqrt(r1 * r1 + r2 * r2 + r3 * r3)
    c_f = resistance(law, r_dot_v, r_length, math.sqrt(u * u + v * v + w * w))
    k = c_f / size_c
    jump = max(bounce, resolution) - v_c
    s_x, s_y, s_z = impulse(k, jump, mobility, u_c, w_c)
    if bounce < resolution and energy_gain(k, s_x, s_y, s_z, jump, -v_c) > 0.0:
        # Lifting a nearly rolling contact to the resolution would add energy; an elastic bounce
        # is the strongest one that cannot.
        jump = max(bounce, -v_c) - v_c
        s_x, s_y, s_z = impulse(k, jump, mobility, u_c, w_c)
    motion[U] = u + s_x
    motion[V] = v + s_y
    motion[W] = w + s_z
    motion[0] = w1 + i1 * (a1 * s_x + b1 * s_y + c1 * s_z)
    motion[1] = w2 + i2 * (a2 * s_x + b2 * s_y + c2 * s_z)
    motion[2] = w3 + i3 * (a3 * s_x + b3 * s_y + c3 * s_z)


@kernel
def _translate(body, motion):
    """Move a body that does not turn to its contact, or off the wall; whether it touches."""
    touches = motion[V] < 0.0
    if touches:
        # a body that starts inside the wall is not lifted, so that the audit can see it
        motion[HEIGHT] = min(motion[HEIGHT], lowest_depth(body, motion[3:6]))
    else:
        motion[HEIGHT] = body.reach + CLEARANCE
    return touches


@borrowing_kernel
def next_contact(body, tolerance, motion, series):
    """Move ``motion`` to the next contact, or off the wall if there is none.

    Parameters
    ----------
    body : Body
    tolerance : float
        Truncation of the flight series.
    motion : (13,) float64
    series : (9, ORDER + 1) float64
        Work space.

    Returns
    -------
    bool
        Whether the particle touches the wall.
    """
    bounds = rate_bounds(body.moments, motion)
    if bounds[0] == 0.0:
        return _translate(body, motion)
    v = motion[V]
    while True:
        y = motion[HEIGHT]
        # whether the flight ends is decided by this time and not by a height reached, which
        # rounding may hold back for ever where v is small
        leaving = (body.reach + CLEARANCE - y) / v if v > 0.0 else math.inf
        if leaving <= 0.0:
            return False
        expand(body.moments, motion, series)
        span = min(series_span(series, tolerance), leaving)
        if v < 0.0:
            span = min(span, (y + body.reach) / -v)
        t = search(body, series, y, v, bounds, span)
        touches = t >= 0.0
        if not touches:
            t = span
        evaluate(body.moments, series, t, motion)
        motion[HEIGHT] = y + v * t
        if touches:
            return True
        if span == leaving:
            motion[HEIGHT] = body.reach + CLEARANCE
            return False


@borrowing_kernel
def _remember(motion, before):
    """Copy the motion; a slice assignment would make a temporary array."""
    for i in range(MOTION_SIZE):
        before[i] = motion[i]


@borrowing_kernel
def rebound(law, condition, body, motion, work, audit):
    """Follow a particle from before its first contact until it has left the wall.

    Parameters
    ----------
    law : LawArguments
    condition : Condition
        Speed [m/s], contact resolution and flight tolerance are read.
    body : Body
    motion : (13,) float64
        In: before the rebound. Out: as the particle leaves, `CLEARANCE` above its reach.
    work : tuple of ((9, ORDER + 1) float64, (3,) float64, (13,) float64)
    audit : (0,) or (AUDIT_SIZE,) float64
        Largest violations met so far; an empty array switches the audit off.

    Returns
    -------
    tuple (status, collisions)
    """
    series, point, before = work
    collisions = 0
    while True:
        _remember(motion, before)
        touches = next_contact(body, condition.tolerance, motion, series)
        if audit.size > 0:
            audit_flight(body.moments, before, motion, audit)
        if not touches:
            return LEFT, collisions
        if collisions == COLLISION_ALARM:
            return UNFINISHED, collisions
        gap = contact_point(body, motion, motion[HEIGHT], motion[V], point)
        motion[HEIGHT] -= min(gap, 0.0)
        _remember(motion, before)
        collide(law, condition.speed, condition.resolution, body.moments, point, motion)
        collisions += 1
        if audit.size > 0:
            audit[PENETRATION] = max(audit[PENETRATION], -gap)
            audit_collision(
                law,
                condition.speed,
                condition.resolution,
                body.moments,
                point,
                before,
                motion,
                audit,
            )


@kernel
def approach(condition, body, motion):
    """Set velocity, spin and height of an oriented particle before its rebound.

    Without spin the particle translates, so it starts at its contact; with spin it starts as
    high as it can reach and falls, turning.

    Parameters
    ----------
    condition : Condition
    body : Body
    motion : (13,) float64
        Rows 3:9 hold the orientation; the others are written.
    """
    n, x = motion[3:6], motion[6:9]
    z = _cross(x[0], x[1], x[2], n[0], n[1], n[2])
    s_x, s_y, s_z = condition.spin
    for i in range(3):
        motion[i] = s_x * x[i] + s_y * n[i] + s_z * z[i]
    motion[U] = math.cos(condition.alpha1)
    motion[V] = -math.sin(condition.alpha1)
    motion[W] = 0.0
    translates = s_x == 0.0 and s_y == 0.0 and s_z == 0.0
    motion[HEIGHT] = lowest_depth(body, n) if translates else body.reach


@inline_kernel
def workspace():
    """Arrays that :func:`rebound` works in."""
    return np.empty((9, ORDER + 1)), np.empty(3), np.empty(MOTION_SIZE)
