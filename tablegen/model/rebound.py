"""A whole rebound: collisions and free flights until the particle has left the wall.

Units: lengths in a, velocities in the impact speed V, angular velocities in V / a, mass one.
Source: Panfilov & Tsirkunov 2022, equations (1) to (7), with Coulomb's law of friction and the
resolution of sustained contact added.

The motion is one array, from which every part of the model reads the same state:

    0:3  angular velocity in body axes
    3:6  wall normal n in body axes
    6:9  wall axis x in body axes
    9:12 velocity of the centre in wall axes (u, v, w)
    12   height of the centre over the wall

The body tumbles in flight: its angular velocity W changes, but its angular momentum L = J W and its
rotational energy T do not. The angular velocities before and after a rebound are means over that
tumbling, M = (2T/L^2) L. From M and the orientation follows L = M M^2 / (M . J^-1 M). On request
the angular velocity after the rebound is that of an instant: the one at which the centre passes
`CLEARANCE` above the bounding radius of the particle, where no point can touch the wall any more.

`apply_collision` and `fly_one_series` are the two steps of a rebound, by which
`tablegen.model.lockstep` follows particles. They take the arrays of one particle or of lanes.
"""

import math

from tablegen.model.collision import energies_taken, energy_gain, impulse, mean_velocity
from tablegen.model.contact import first_contact
from tablegen.model.contact_laws import COULOMB, resistance, restitution, tabulated_resistance
from tablegen.model.coulomb import Ending, coulomb_impulse
from tablegen.model.impacts import translates
from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.reach import tumbling_reach
from tablegen.model.rotation import (
    NORMAL,
    advance_motion,
    expand_motion,
    rate_bounds,
    series_span,
)
from tablegen.model.shapes import support_depth
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
    store_three,
)
from tablegen.model.sliding import Friction
from tablegen.model.vectors import cross

MOTION_SIZE = 13
U, V, W, HEIGHT = 9, 10, 11, 12

#: Collisions after which a particle is reported as unfinished. It is an alarm, not a cap: the
#: caller must raise an error, and never use the state. At the default resolution the longest chains
#: have a few hundred collisions.
COLLISION_ALARM = 100_000_000

#: Height over the bounding radius at which a particle has left and its state is taken. Any positive
#: height would do. This one is the mean height gained in half a step of 0.04 rad, by which the
#: independent reference simulation passes the bounding radius. With a height of zero, correlations
#: of omega_x and omega_y differ from those of the reference by up to 0.008; with this height they
#: differ by no more than its noise.
CLEARANCE = 0.006

#: Square of an angle [rad]. A particle that would turn by less until it passes the bounding radius
#: is followed up to there.
_LONG_WAY = 9.0


@no_refcount_inline_kernel
def rotational_energy(moments, motion):
    """Compute the rotational energy per unit mass, in units of V^2."""
    w1, w2, w3 = load_three(motion, 0)
    return 0.5 * (moments[0] * w1 * w1 + moments[1] * w2 * w2 + moments[2] * w3 * w3)


@no_refcount_inline_kernel
def _wall_axes(motion):
    """Read the wall axes x, y = n and z in body axes."""
    x, n = load_three(motion, 6), load_three(motion, 3)
    return x, n, cross(x, n)


@inline_kernel
def _dot(a, b):
    return fma(a[2], b[2], fma(a[1], b[1], a[0] * b[0]))


@no_refcount_inline_kernel
def departing_spin(moments, instant, motion):
    """Compute the angular velocity in wall axes, and the inertia about its mean over free tumbling.

    The angular velocity is that mean, or the present one if ``instant`` is positive. Both results
    are 0 for a particle without spin.
    """
    x, n, z = _wall_axes(motion)
    w = load_three(motion, 0)
    momentum = moments[0] * w[0], moments[1] * w[1], moments[2] * w[2]
    square, twice_energy = _dot(momentum, momentum), _dot(momentum, w)
    turns = (square > 0.0) & (twice_energy > 0.0)
    scale = select(turns, twice_energy / select(turns, square, 1.0), 0.0)
    inertia = square / select(turns, twice_energy, 1.0)
    inertia = select(turns, minimum(maximum(inertia, moments[0]), moments[2]), 0.0)
    mean = momentum[0] * scale, momentum[1] * scale, momentum[2] * scale
    w = select_three(instant > 0.0, w, mean)
    return (_dot(w, x), _dot(w, n), _dot(w, z)), inertia


@no_refcount_kernel
def departure_height(body, instant, motion):
    """Compute the height at which a particle that rises has left.

    It is `CLEARANCE` above the bounding radius. If the particle would turn far until then, it is
    the lower height from which no phase of its tumbling touches the wall (`tumbling_reach`), unless
    the angular velocity of an instant is asked for.
    """
    w, v, top = load_three(motion, 0), load(motion, V), body.bounding_radius + CLEARANCE
    way = top - load(motion, HEIGHT)
    long = (way * way * _dot(w, w) > _LONG_WAY * v * v) & (v > 0.0) & logical_not(instant > 0.0)
    if any_lane(long):
        momentum = body.moments[0] * w[0], body.moments[1] * w[1], body.moments[2] * w[2]
        top = select(long, tumbling_reach(body, momentum, load_three(motion, NORMAL)), top)
    return top


@inline_kernel
def present_spin(moments, mean):
    """Compute the present angular velocity in body axes from the mean over free tumbling."""
    over = mean[0] / moments[0], mean[1] / moments[1], mean[2] / moments[2]
    share = _dot(mean, over)
    turns = share > 0.0
    scale = select(turns, _dot(mean, mean) / select(turns, share, 1.0), 0.0)
    return over[0] * scale, over[1] * scale, over[2] * scale


@inline_kernel
def _mobility(a, b, c, inverse):
    """Compute the mobility: A_xx, A_xy, A_xz, A_yy, A_yz, A_zz of dV_c = A dV_p.

    ``a``, ``b``, ``c`` are the torque arms r x e of the three wall axes in body axes, ``inverse``
    the reciprocal moments of inertia.
    """
    ai = a[0] * inverse[0], a[1] * inverse[1], a[2] * inverse[2]
    bi = b[0] * inverse[0], b[1] * inverse[1], b[2] * inverse[2]
    ci = c[0] * inverse[0], c[1] * inverse[1], c[2] * inverse[2]
    a_xx, a_yy, a_zz = 1.0 + _dot(a, ai), 1.0 + _dot(b, bi), 1.0 + _dot(c, ci)
    return a_xx, _dot(a, bi), _dot(a, ci), a_yy, _dot(b, ci), a_zz


@no_refcount_inline_kernel
def _impulse_of_bounce(k, bounce, resolution, mobility, velocity):
    """Compute the impulse for a rebound velocity ``bounce`` of the contact, or for the resolution.

    The larger of the two counts. If lifting a nearly rolling contact to the resolution would add
    energy, the bounce is elastic instead, the strongest that adds none. Also returns the energy
    that the normal impulse takes. Both parts of the impulse act at the mean contact velocity,
    because they are proportional to each other throughout the collision.
    """
    u, v, w = velocity
    jump = maximum(bounce, resolution) - v
    s = impulse(k, jump, mobility, u, w)
    lifted = bounce < resolution
    if any_lane(lifted):
        gains = lifted & (energy_gain(k, s, jump, -v) > 0.0)
        if any_lane(gains):
            elastic = impulse(k, maximum(bounce, -v) - v, mobility, u, w)
            s = select_three(gains, elastic, s)
    return s, -s[1] * mean_velocity(velocity, mobility, s)[1]


@no_refcount_kernel
def _spring_back_impulse(law, mobility, velocity, s):
    """Compute the impulse of a sphere with a tangential restitution b.

    If the contact does not slide throughout, it springs back along the wall: the tangential impulse
    is -(1 + b) u / A_tt. It is at most Coulomb's impulse of sliding. Source: Walton & Braun,
    J. Rheol. 30 (1986) 949.
    """
    u, v, w = velocity
    slide = sqrt(u * u + w * w)
    back = 1.0 + tabulated_resistance(law, -v / sqrt(slide * slide + v * v))
    slides = slide > 0.0
    limit = law.factor * s[1] / select(slides, slide, 1.0)
    share = select(slides, minimum(limit, back / mobility[0]), 0.0)
    return -share * u, s[1], -share * w


@no_refcount_kernel
def _coulomb_impulse(law, a_nc, resolution, mobility, velocity, series, where):
    """Compute the impulse by Coulomb's law, and the energy that its normal part takes.

    The restitution is energetic (`tablegen.model.coulomb`). Contacts that approach more slowly than
    the resolution belong to a sustained contact. They follow the constant law with the dynamic
    coefficient, which is Coulomb's law while they slide; with an energetic restitution the bounces
    of a rolling contact would become smaller without end.
    """
    u, v, w = velocity
    hard = where & (v <= -resolution)
    friction = Friction(law.strength, law.factor)
    ending = Ending((1.0 - a_nc) * (1.0 + a_nc), resolution)
    s, taken = coulomb_impulse(friction, ending, mobility, velocity, series, hard)
    if law.resistances.size > 0:
        s = _spring_back_impulse(law, mobility, velocity, s)
    soft = where & logical_not(hard)
    if any_lane(soft):
        k = law.factor / sqrt(u * u + v * v + w * w)
        t, gone = _impulse_of_bounce(k, a_nc * -v, resolution, mobility, velocity)
        s = select_three(soft, t, s)
        taken = select(soft, gone, taken)
    return s, taken


@no_refcount_kernel
def apply_collision(law, speed, resolution, moments, point, motion, series, where=True):
    """Apply one collision at the contact ``point`` to ``motion``, in the lanes that collide.

    The contact point leaves with the velocity a_nc |v_c|, equation (6), or with the resolution if
    that is larger: tiny bounces are nearly elastic and would go on without end (sustained contact).
    Under Coulomb's law a_nc is the energetic restitution instead (`tablegen.model.coulomb`).

    ``speed`` is V [m/s]; ``resolution`` is the smallest rebound speed of the contact point over V;
    ``moments`` are the principal moments of inertia; ``point`` (3,) is measured from the centre in
    body axes; ``series`` (9, ORDER + 1) is work space. Returns the energies that the normal and the
    tangential impulse took, per unit mass and in units of V^2.
    """
    x, n, z = _wall_axes(motion)
    r = load_three(point, 0)
    # the torque arm of an impulse along each wall axis e is r x e
    a, b, c = cross(r, x), cross(r, n), cross(r, z)
    inverse = 1.0 / moments[0], 1.0 / moments[1], 1.0 / moments[2]
    mobility = _mobility(a, b, c, inverse)
    w = load_three(motion, 0)
    u, v, w_z = load_three(motion, U)
    # the velocity of the contact point, equation (2)
    u_c, v_c, w_c = u + _dot(w, a), v + _dot(w, b), w_z + _dot(w, c)
    # a lane that does not collide may recede, and then the search for an impulse would not end
    v_c = select(where, v_c, -1.0)
    size_c = sqrt(u_c * u_c + v_c * v_c + w_c * w_c)
    cosine = -v_c / size_c
    a_nc = restitution(law, speed * size_c, cosine)
    velocity = u_c, v_c, w_c
    if law.resistance_law == COULOMB:
        s, taken = _coulomb_impulse(law, a_nc, resolution, mobility, velocity, series, where)
    else:
        r_dot_v = u * _dot(r, x) + v * _dot(r, n) + w_z * _dot(r, z)
        c_f = resistance(law, r_dot_v, sqrt(_dot(r, r)), sqrt(u * u + v * v + w_z * w_z), cosine)
        s, taken = _impulse_of_bounce(c_f / size_c, a_nc * -v_c, resolution, mobility, velocity)
    after = u + s[0], v + s[1], w_z + s[2]
    store_three(motion, U, select_three(where, after, (u, v, w_z)))
    for i in range(3):
        turned = w[i] + inverse[i] * (a[i] * s[0] + b[i] * s[1] + c[i] * s[2])
        store(motion, i, select(where, turned, w[i]))
    taken, rest = energies_taken(velocity, mobility, s, taken)
    return select(where, taken, 0.0), select(where, rest, 0.0)


@inline_kernel
def has_no_impulse(taken):
    """Tell from its energies whether a collision did not end (`coulomb.PIECE_ALARM`)."""
    return logical_not(taken[1] == taken[1])


@no_refcount_kernel
def fly_one_series(body, top, tolerance, motion, series, where):
    """Advance ``motion`` along one flight series, up to a contact, departure or end of the series.

    ``top`` is the height at which a particle that rises has left, ``tolerance`` the truncation of
    the series, ``series`` (9, ORDER + 1) work space. Lanes outside of ``where`` stay. Returns
    whether the particle touches the wall, and whether it has left.
    """
    y, v = load(motion, HEIGHT), load(motion, V)
    # the flight ends by this time and not by a height, which rounding may keep out of reach
    # without end where v is small
    leaving = select(v > 0.0, maximum((top - y) / v, 0.0), math.inf)
    expand_motion(body.moments, motion, series)
    span = minimum(series_span(series, tolerance), leaving)
    # a particle that falls touches by the time at which its centre is one bounding radius below the
    # wall
    span = select(v < 0.0, minimum(span, maximum((y + body.bounding_radius) / -v, 0.0)), span)
    span = select(where, span, 0.0)
    t = first_contact(body, series, y, v, rate_bounds(body.moments, motion), span)
    touches = t >= 0.0
    t = select(touches, t, span)
    advance_motion(body.moments, series, t, motion)
    # a comparison with NaN is false, so a NaN ends the flight
    left = where & logical_not(touches) & logical_not(span < leaving)
    store(motion, HEIGHT, select(left & (leaving > 0.0), top, fma(v, t, y)))
    return touches, left


@no_refcount_kernel
def place_before_impact(condition, body, motion, where=True):
    """Set velocity, spin and height of oriented particles before their rebound.

    A particle without spin translates, so it starts at its first contact. A particle with spin
    starts where no phase of its tumbling touches the wall (`tumbling_reach`), and falls while it
    turns. Rows 3 to 8 of ``motion`` (13,) contain the orientation; the others are written, in the
    lanes ``where``.
    """
    x, n, z = _wall_axes(motion)
    s_x, s_y, s_z = condition.spin
    spin = (
        s_x * x[0] + s_y * n[0] + s_z * z[0],
        s_x * x[1] + s_y * n[1] + s_z * z[1],
        s_x * x[2] + s_y * n[2] + s_z * z[2],
    )
    present = present_spin(body.moments, spin)
    store_three(motion, 0, select_three(where, present, load_three(motion, 0)))
    velocity = condition.cosine, -condition.sine, 0.0 * condition.sine
    store_three(motion, U, select_three(where, velocity, load_three(motion, U)))
    height, still = body.bounding_radius, where & translates(condition)
    if any_lane(still):
        height = select(still, support_depth(body, n[0], n[1], n[2]), height)
    turns = where & logical_not(still)
    if any_lane(turns):
        height = select(turns, tumbling_reach(body, spin, n), height)
    store(motion, HEIGHT, select(where, height, load(motion, HEIGHT)))
