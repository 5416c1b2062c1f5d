"""Checks of every collision and flight against the laws they must obey.

The audit recomputes each law from the motion before and after, in its defining form, and keeps
the largest violation met. It shares no intermediate result with the solver that it checks, only
the contact laws, which are checked on their own.
"""

import math

from tablegen.model.contact_laws import COULOMB, resistance, restitution
from tablegen.model.coulomb_audit import contact_mobility, followed, static_hold
from tablegen.model.jit import kernel

#: Entries of an audit array.
ENERGY, ANGULAR, NORMAL, TANGENTIAL, PENETRATION, FLIGHT_ENERGY, FLIGHT_MOMENTUM = range(7)
AUDIT_SIZE = 7


@kernel
def wall_vector(motion, a1, a2, a3):
    """Components along the wall axes of a vector given in body axes."""
    n1, n2, n3 = motion[3], motion[4], motion[5]
    x1, x2, x3 = motion[6], motion[7], motion[8]
    return (
        a1 * x1 + a2 * x2 + a3 * x3,
        a1 * n1 + a2 * n2 + a3 * n3,
        a1 * (x2 * n3 - x3 * n2) + a2 * (x3 * n1 - x1 * n3) + a3 * (x1 * n2 - x2 * n1),
    )


@kernel
def contact_velocity(motion, point):
    """Velocity of the material point ``point`` in wall axes, equation (2)."""
    w1, w2, w3 = motion[0], motion[1], motion[2]
    r1, r2, r3 = point
    x, y, z = wall_vector(motion, w2 * r3 - w3 * r2, w3 * r1 - w1 * r3, w1 * r2 - w2 * r1)
    return motion[9] + x, motion[10] + y, motion[11] + z


@kernel
def total_energy(moments, motion):
    """Kinetic energy per unit mass."""
    rotation = 0.0
    for i in range(3):
        rotation += moments[i] * motion[i] ** 2
    return 0.5 * (rotation + motion[9] ** 2 + motion[10] ** 2 + motion[11] ** 2)


@kernel
def _audit_torque(moments, point, before, after, audit):
    """Check J dW = r x S."""
    s_x, s_y, s_z = after[9] - before[9], after[10] - before[10], after[11] - before[11]
    rx, ry, rz = wall_vector(before, point[0], point[1], point[2])
    lx, ly, lz = wall_vector(
        before,
        moments[0] * (after[0] - before[0]),
        moments[1] * (after[1] - before[1]),
        moments[2] * (after[2] - before[2]),
    )
    torque = abs(ry * s_z - rz * s_y - lx) + abs(rz * s_x - rx * s_z - ly)
    torque += abs(rx * s_y - ry * s_x - lz)
    audit[ANGULAR] = max(audit[ANGULAR], torque)


@kernel
def _audit_resistance(law, speed, resolution, point, before, after, audit):
    """Check equations (5)-(7).

    Below the resolution the contact may leave with the resolution or, where that would add
    energy, with its own speed.
    """
    s_x, s_y, s_z = after[9] - before[9], after[10] - before[10], after[11] - before[11]
    u0, v0, w0 = contact_velocity(before, point)
    u1, v1, w1 = contact_velocity(after, point)
    size = math.sqrt(u0 * u0 + v0 * v0 + w0 * w0)
    a_nc = restitution(law, speed * size, -v0 / size)
    miss = abs(v1 + a_nc * v0)
    if -a_nc * v0 < resolution:
        miss = min(abs(v1 - resolution), abs(v1 + max(1.0, a_nc) * v0))
    audit[NORMAL] = max(audit[NORMAL], miss)

    rx, ry, rz = wall_vector(before, point[0], point[1], point[2])
    centre = math.sqrt(before[9] ** 2 + before[10] ** 2 + before[11] ** 2)
    r_dot_v = rx * before[9] + ry * before[10] + rz * before[11]
    r_length = math.sqrt(rx * rx + ry * ry + rz * rz)
    factor = resistance(law, r_dot_v, r_length, centre, -v0 / size) * s_y / size
    slip = abs(s_x + factor * 0.5 * (u0 + u1)) + abs(s_z + factor * 0.5 * (w0 + w1))
    audit[TANGENTIAL] = max(audit[TANGENTIAL], slip)


@kernel
def _audit_coulomb(law, speed, resolution, moments, point, before, after, audit):
    """Check Coulomb's law along the collision, its cone, and the energetic restitution.

    The work of the normal impulse must be the part that the restitution leaves of that of
    compression, or more, up to none: where the contact leaves with the resolution, or elastically.
    """
    s_x, s_y, s_z = after[9] - before[9], after[10] - before[10], after[11] - before[11]
    velocity = contact_velocity(before, point)
    u1, v1, w1 = contact_velocity(after, point)
    size = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    a_nc = restitution(law, speed * size, -velocity[1] / size)
    mobility = contact_mobility(moments, point, before)
    u, v, w, work, least = followed(law.strength, law.factor, mobility, velocity, s_y)
    miss = work - (1.0 - a_nc * a_nc) * least
    if miss > 0.0:
        miss = min(miss, abs(v1 - resolution), abs(work))
    audit[NORMAL] = max(audit[NORMAL], abs(miss), abs(v - v1))
    hold = static_hold(mobility)
    cone = max(law.factor, hold if hold <= law.strength else 0.0) * s_y
    audit[TANGENTIAL] = max(
        audit[TANGENTIAL], abs(u - u1), abs(w - w1), math.hypot(s_x, s_z) - cone
    )


@kernel
def audit_collision(law, speed, resolution, moments, point, before, after, audit):
    """Check one collision: energy, J dW = r x S, and the contact laws.

    Parameters
    ----------
    law : LawArguments
    speed, resolution : float
    moments : tuple of three floats
    point : (3,) float64
    before, after : (13,) float64
    audit : (AUDIT_SIZE,) float64
    """
    gain = total_energy(moments, after) - total_energy(moments, before)
    audit[ENERGY] = max(audit[ENERGY], gain)
    _audit_torque(moments, point, before, after, audit)
    _, v, _ = contact_velocity(before, point)
    # a contact that approaches below the resolution follows the constant law instead
    if law.resistance_law == COULOMB and v <= -resolution:
        _audit_coulomb(law, speed, resolution, moments, point, before, after, audit)
    else:
        _audit_resistance(law, speed, resolution, point, before, after, audit)


@kernel
def audit_flight(moments, before, after, audit):
    """Check a free flight: energy and angular momentum in wall axes, both relative."""
    energy = total_energy(moments, before)
    drift = abs(total_energy(moments, after) - energy) / energy
    audit[FLIGHT_ENERGY] = max(audit[FLIGHT_ENERGY], drift)
    j1, j2, j3 = moments
    x0, y0, z0 = wall_vector(before, j1 * before[0], j2 * before[1], j3 * before[2])
    x1, y1, z1 = wall_vector(after, j1 * after[0], j2 * after[1], j3 * after[2])
    size = math.sqrt(x0 * x0 + y0 * y0 + z0 * z0)
    if size > 0.0:
        drift = math.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2 + (z1 - z0) ** 2) / size
        audit[FLIGHT_MOMENTUM] = max(audit[FLIGHT_MOMENTUM], drift)
