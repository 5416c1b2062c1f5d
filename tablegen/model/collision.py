"""The impulse of one collision of a rigid particle with the wall.

The contact point moves with V_c before the collision. The impulse S changes its velocity by A S,
with the mobility

    A = I - [r]x J^-1 [r]x                                        from equations (1) to (4)

of the contact point r. The laws of contact ask for

    A_yy S_y + A_yt . S_t = (1 + a_nc) |v_c|                      normal, "jump" below
    S_t = -(C_f / |V_c|) S_y (u_t + (A S)_t / 2)                  tangential, equation (5)

where t stands for the axes x and z along the wall, and u_t is the tangential part of V_c. For a
given normal impulse s = S_y the tangential equations are linear. Their solution, put into the
normal equation, leaves a cubic in s with one positive root. Nothing is iterated to a fixed point.

Units: velocities over the impact speed V, mass one, so that an impulse is a change of velocity. All
vectors are in wall axes x, y, z. A mobility is the six numbers A_xx, A_xy, A_xz, A_yy, A_yz, A_zz.

Source: Panfilov & Tsirkunov, Tech. Phys. 2022, equations (1) to (5). The paper iterates them; the
cubic is ours.
"""

import math

from tablegen.model.jit import inline_kernel, kernel
from tablegen.model.simd import any_lane, logical_not, maximum, minimum, select

#: Relative Newton step after which the root is exact to rounding, because each step squares the
#: error.
CONVERGED = 1e-10


@inline_kernel
def tangential_impulse(s, k, mobility, u_t, w_t):
    """Compute the tangential impulse (S_x, S_z) that goes with a normal impulse s.

    It solves (I + k s A_tt / 2) S_t = -k s (u_t + s A_tn / 2), equation (5) with the change of the
    contact velocity, A_tt S_t + A_tn s, from (3) and (4). ``k`` is C_f / |V_c|; (u_t, w_t) is the
    tangential contact velocity before the collision.
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
    """Compute the coefficients c0, ..., c3 of the cubic whose positive root is the normal impulse.

    The cubic is the normal equation, A_yy s + A_yt . S_t(s) = jump, times det(I + k s A_tt / 2).
    Its leading coefficient k^2 det(A) / 4 and -c0 = jump are positive, so there is a positive root.
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
    """Find the positive root of c0 + c1 s + c2 s^2 + c3 s^3 with c0 < 0 and c3 >= 0.

    ``start`` is a positive guess. Newton's method is kept inside a bracket: a step that would leave
    the bracket is replaced by bisection, so the search ends for any coefficients.
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
        # a comparison with NaN is false, so a NaN ends the search
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
    """Compute the impulse (S_x, S_y, S_z) that changes the normal contact velocity by ``jump`` > 0.

    ``k`` is C_f / |V_c|, zero for a contact that slides freely; (u_t, w_t) is the tangential
    contact velocity before the collision.
    """
    c0, c1, c2, c3 = impulse_cubic(k, jump, mobility, u_t, w_t)
    s = positive_root(c0, c1, c2, c3, jump / mobility[3])
    s_x, s_z = tangential_impulse(s, k, mobility, u_t, w_t)
    return s_x, s, s_z


@inline_kernel
def energy_gain(k, s, jump, approach):
    """Compute the energy gained in a collision per unit mass, S . (V_c + dV_c / 2).

    ``approach`` is |v_c| before the collision. The tangential part is -|S_t|^2 / (k s), never
    positive, and absent where nothing resists sliding (k = 0); the normal part is s (v_c+ - |v_c-|)
    / 2 with v_c+ = jump - approach.
    """
    s_x, s_y, s_z = s
    slides = k > 0.0
    lost = (s_x * s_x + s_z * s_z) / select(slides, k * s_y, 1.0)
    return 0.5 * s_y * (jump - 2.0 * approach) - select(slides, lost, 0.0)


@inline_kernel
def mean_velocity(velocity, mobility, impulse):
    """Compute the mean of the contact velocities before and after a collision, V_c + A S / 2."""
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
    """Split the energy lost in a collision into the parts of the normal and tangential impulse.

    Both are per unit mass, and their sum is the loss of kinetic energy, -S . (V_c + dV_c / 2). By
    the contact laws neither is negative. If a bounce was lifted to the resolution, its normal
    impulse may add energy. No wall does that, so the gain is subtracted from the tangential part.
    ``normal`` is minus the integral of v_c dS_n along the collision.
    """
    u, v, w = mean_velocity(velocity, mobility, impulse)
    lost = -(impulse[0] * u + impulse[1] * v + impulse[2] * w)
    normal = maximum(minimum(normal, lost), 0.0)
    return normal, lost - normal
