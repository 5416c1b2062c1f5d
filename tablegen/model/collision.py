"""One collision of a rigid particle with the wall, solved through one scalar equation.

Paper: Panfilov & Tsirkunov 2022, equations (1)-(7). Given the normal impulse s = dv_p, the
tangential contact equations (5) are linear; putting their solution into the normal equation
leaves a cubic in s with one positive root. Nothing is iterated to a fixed point.

Vectors with index 0, 1, 2 are components along the wall axes x (tangential, impact plane),
y (wall normal), z. The mobility has the six numbers A_xx, A_xy, A_xz, A_yy, A_yz, A_zz of
dV_c = A dV_p. The mass is one, so an impulse is a velocity change.
"""

import math

from tablegen.model.jit import inline_kernel, kernel
from tablegen.model.simd import any_lane, logical_not, maximum, minimum, select

#: Relative Newton step after which the root is exact to rounding: the error of a step is the
#: square of that of the one before.
CONVERGED = 1e-10


@inline_kernel
def tangential_impulse(s, k, mobility, u_t, w_t):
    """Tangential impulse that goes with a normal impulse s.

    Solves (I + k s A_tt / 2) S_t = -k s (u_t + s A_tn / 2): the tangential equations (5) with the
    change of the contact velocity, A_tt S_t + A_tn s, put in from (3) and (4). ``k`` is
    C_f / |V_c|, (u_t, w_t) the tangential contact velocity before the collision.
    """
    axx, axy, axz, _, ayz, azz = mobility
    half = 0.5 * k * s
    mxx = 1.0 + half * axx
    mzz = 1.0 + half * azz
    mxz = half * axz
    bx = -k * s * (u_t + 0.5 * s * axy)
    bz = -k * s * (w_t + 0.5 * s * ayz)
    det = mxx * mzz - mxz * mxz
    return (mzz * bx - mxz * bz) / det, (mxx * bz - mxz * bx) / det


@inline_kernel
def impulse_cubic(k, jump, mobility, u_t, w_t):
    """Coefficients c0..c3 of the cubic whose positive root is the normal impulse.

    It is the normal equation A_yy s + A_yt . S_t(s) = jump times det(I + k s A_tt / 2); the
    leading coefficient k^2 det(A) / 4 and -c0 = jump are positive.
    """
    axx, axy, axz, ayy, ayz, azz = mobility
    trace = axx + azz
    det = axx * azz - axz * axz
    # adj(A_tt) applied to A_tn
    px = azz * axy - axz * ayz
    pz = axx * ayz - axz * axy
    coupling = axy * u_t + ayz * w_t
    c0 = -jump
    c1 = ayy - 0.5 * k * jump * trace - k * coupling
    c2 = 0.5 * k * (ayy * trace - axy * axy - ayz * ayz) - 0.25 * k * k * jump * det
    c2 -= 0.5 * k * k * (px * u_t + pz * w_t)
    c3 = 0.25 * k * k * (ayy * det - axy * px - ayz * pz)
    return c0, c1, c2, c3


@kernel
def positive_root(c0, c1, c2, c3, start):
    """Positive root of c0 + c1 s + c2 s^2 + c3 s^3 with c0 < 0 and c3 >= 0, from a guess > 0.

    Newton's method kept inside a bracket; a step that leaves it is replaced by bisection, so
    the search ends for any coefficients.
    """
    low = 0.0
    high = start
    short = c0 + high * (c1 + high * (c2 + high * c3)) < 0.0
    while any_lane(short):
        low = select(short, high, low)
        high = select(short, 2.0 * high, high)
        short = c0 + high * (c1 + high * (c2 + high * c3)) < 0.0
    s = high
    searching = s == s
    while any_lane(searching):
        value = c0 + s * (c1 + s * (c2 + s * c3))
        slope = c1 + s * (2.0 * c2 + s * 3.0 * c3)
        step = select(slope == 0.0, math.inf, value / slope)
        # in this form a NaN ends the search
        far = abs(step) > CONVERGED * s
        low = select(value < 0.0, s, low)
        high = select(value < 0.0, high, s)
        middle = 0.5 * (low + high)
        newton = s - step
        leaves = far & logical_not((low < newton) & (newton < high))
        s = select(searching, select(leaves, middle, newton), s)
        searching = (
            searching & far & logical_not(leaves & logical_not((low < middle) & (middle < high)))
        )
    return s


@kernel
def impulse(k, jump, mobility, u_t, w_t):
    """Impulse (Su, Sv, Sw) that changes the normal contact velocity by ``jump`` > 0.

    ``k`` is C_f / |V_c|, zero for a contact that slides freely, (u_t, w_t) the tangential contact
    velocity before the collision.
    """
    c0, c1, c2, c3 = impulse_cubic(k, jump, mobility, u_t, w_t)
    s = positive_root(c0, c1, c2, c3, jump / mobility[3])
    s_x, s_z = tangential_impulse(s, k, mobility, u_t, w_t)
    return s_x, s, s_z


@inline_kernel
def energy_gain(k, s, jump, approach):
    """Energy gained in a collision: S . (V_c + dV_c / 2), per unit mass.

    The tangential part is -|S_t|^2 / (k s), never positive, and absent where nothing resists
    sliding (k = 0); the normal part is s (v_c+ - |v_c-|) / 2 with v_c+ = jump - approach.
    """
    s_x, s_y, s_z = s
    slides = k > 0.0
    lost = (s_x * s_x + s_z * s_z) / select(slides, k * s_y, 1.0)
    return 0.5 * s_y * (jump - 2.0 * approach) - select(slides, lost, 0.0)


@inline_kernel
def mean_velocity(velocity, mobility, impulse):
    """Mean of the contact velocities before and after a collision, V_c + A S / 2."""
    u, v, w = velocity
    axx, axy, axz, ayy, ayz, azz = mobility
    s_x, s_y, s_z = impulse
    return (
        u + 0.5 * (axx * s_x + axy * s_y + axz * s_z),
        v + 0.5 * (axy * s_x + ayy * s_y + ayz * s_z),
        w + 0.5 * (axz * s_x + ayz * s_y + azz * s_z),
    )


@inline_kernel
def energies_taken(velocity, mobility, impulse, normal):
    """Energies that the normal and the tangential impulse of a collision take, per unit mass.

    Their sum is the loss of kinetic energy, -S . (V_c + dV_c / 2). By the contact laws neither is
    negative. A bounce that was lifted to the resolution may gain energy from the normal impulse;
    that is no law of a wall, and is taken off the tangential part. ``normal`` is minus the integral
    of v_c dS_n along the collision.
    """
    u, v, w = mean_velocity(velocity, mobility, impulse)
    lost = -(impulse[0] * u + impulse[1] * v + impulse[2] * w)
    normal = maximum(minimum(normal, lost), 0.0)
    return normal, lost - normal
