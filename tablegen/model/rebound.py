"""A whole rebound: collisions and free flights until the particle has left the wall.

Units: lengths in a, velocities in the impact speed V, angular velocities in V / a, mass one.
The motion is kept in one array so that every piece of the model reads the same state:

    0:3  angular velocity in body axes
    3:6  wall normal n in body axes
    6:9  wall axis x in body axes
    9:12 velocity of the centre in wall axes (u, v, w)
    12   height of the centre over the wall

The angular velocity W changes in flight (the body tumbles), but the angular momentum L = J W and
the rotational energy T do not. Angular velocities before and after a rebound are the mean M over
that tumbling, (2T/L^2) L. With the orientation it gives L = M M^2 / (M . J^-1 M) back. On request
that after the rebound is the one of an instant, as the centre passes `CLEARANCE` above the bounding
radius of the particle, where no point can touch the wall any more.

`collide` and `fly` are the two steps of a rebound; they take the arrays of one particle or
of lanes (see `tablegen.model.simd`). `rebound` follows one particle by them, step by step and
audited; `tablegen.model.lockstep` follows many.
"""

import math

import numpy as np

from sampler.formats.bounds import COULOMB
from tablegen.model.audit import PENETRATION, audit_collision, audit_flight
from tablegen.model.collision import energies_taken, energy_gain, impulse, mean_velocity
from tablegen.model.contact import contact_point, search
from tablegen.model.contact_laws import resistance, restitution, tabulated_resistance
from tablegen.model.coulomb import Ending, coulomb_impulse
from tablegen.model.frames import cross
from tablegen.model.impacts import translates
from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.reach import tumbling_reach
from tablegen.model.rotation import NORMAL, ORDER, evaluate, expand, rate_bounds, series_span
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

MOTION_SIZE = 13
U, V, W, HEIGHT = 9, 10, 11, 12

#: Results of :func:`rebound`.
LEFT, UNFINISHED = 0, 1

#: Collisions after which a particle is reported as unfinished. It is an alarm, not a cap: the
#: caller must raise, never use the state. The longest chain met at the default resolution has
#: some hundreds of collisions.
COLLISION_ALARM = 100_000_000

#: Height over its bounding radius at which a particle has left and its state is taken. Any positive
#: height would do; this one is the mean height gained in half a step of 0.04 rad, by which the
#: independent reference simulation passes the bounding radius. At zero, correlations of omega_x and
#: omega_y differ from the reference's by up to 0.008, at this height by no more than its noise.
CLEARANCE = 0.006

#: Square of an angle [rad]: a particle that turns less before it has left is followed so far.
_LONG_WAY = 9.0


@no_refcount_inline_kernel
def rotational_energy(moments, motion):
    """Rotational energy per unit mass, in units of V^2."""
    w1, w2, w3 = load_three(motion, 0)
    return 0.5 * (moments[0] * w1 * w1 + moments[1] * w2 * w2 + moments[2] * w3 * w3)


@no_refcount_inline_kernel
def _wall_axes(motion):
    """Wall axes x, y = n and z in body axes."""
    x, n = load_three(motion, 6), load_three(motion, 3)
    return x, n, cross(x, n)


@inline_kernel
def _dot(a, b):
    return fma(a[2], b[2], fma(a[1], b[1], a[0] * b[0]))


@no_refcount_inline_kernel
def departing_spin(moments, instant, motion):
    """Angular velocity in wall axes, and the inertia about its mean over free tumbling.

    The angular velocity is that mean, or that of ``instant``. Without spin both are 0.
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
    """Height at which a particle that rises has left.

    No phase of its tumbling touches the wall from there; it is looked for where the way to the
    bounding radius is long. Where angular velocities of an instant are asked for, it is that of the
    instant.
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
    """Angular velocity now in body axes, from the mean over free tumbling."""
    over = mean[0] / moments[0], mean[1] / moments[1], mean[2] / moments[2]
    share = _dot(mean, over)
    turns = share > 0.0
    scale = select(turns, _dot(mean, mean) / select(turns, share, 1.0), 0.0)
    return over[0] * scale, over[1] * scale, over[2] * scale


@inline_kernel
def _mobility(a, b, c, inverse):
    """Entries A_xx, A_xy, A_xz, A_yy, A_yz, A_zz of dV_c = A dV_p.

    ``a``, ``b``, ``c`` are the torque arms r x e of the three wall axes in body axes.
    """
    ai = a[0] * inverse[0], a[1] * inverse[1], a[2] * inverse[2]
    bi = b[0] * inverse[0], b[1] * inverse[1], b[2] * inverse[2]
    ci = c[0] * inverse[0], c[1] * inverse[1], c[2] * inverse[2]
    a_xx, a_yy, a_zz = 1.0 + _dot(a, ai), 1.0 + _dot(b, bi), 1.0 + _dot(c, ci)
    return a_xx, _dot(a, bi), _dot(a, ci), a_yy, _dot(b, ci), a_zz


@no_refcount_inline_kernel
def _bounded_impulse(k, bounce, resolution, mobility, velocity):
    """Impulse for a rebound velocity ``bounce`` of the contact, no smaller than the resolution.

    Returns also the energy that its normal part takes: the tangential impulse is a constant times
    the mean tangential velocity and the normal one, so both act at the mean velocities. Lifting a
    nearly rolling contact to the resolution would add energy; there an elastic bounce is the
    strongest one that cannot.
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
def _sprung_back(law, mobility, velocity, s):
    """Impulse of a sphere whose contact springs back along the wall where it does not slide.

    With the tangential restitution b it is -(1 + b) u / A_tt, but at most Coulomb's of sliding.
    Source: Walton & Braun, J. Rheol. 30 (1986) 949.
    """
    u, v, w = velocity
    slide = sqrt(u * u + w * w)
    back = 1.0 + tabulated_resistance(law, -v / sqrt(slide * slide + v * v))
    slides = slide > 0.0
    limit = law.factor * s[1] / select(slides, slide, 1.0)
    share = select(slides, minimum(limit, back / mobility[0]), 0.0)
    return -share * u, s[1], -share * w


@no_refcount_kernel
def _friction_impulse(law, a_nc, resolution, mobility, velocity, series, where):
    """Impulse by Coulomb's law, with energetic restitution, and the energy its normal part takes.

    Contacts that approach more slowly than the resolution are those of a sustained contact. They
    follow the constant law with the dynamic coefficient, which is Coulomb's while they slide. An
    energetic restitution would make the bounces of a rolling contact smaller for ever.
    """
    u, v, w = velocity
    hard = where & (v <= -resolution)
    friction = Friction(law.strength, law.factor)
    ending = Ending((1.0 - a_nc) * (1.0 + a_nc), resolution)
    s, taken = coulomb_impulse(friction, ending, mobility, velocity, series, hard)
    if law.resistances.size > 0:
        s = _sprung_back(law, mobility, velocity, s)
    soft = where & logical_not(hard)
    if any_lane(soft):
        k = law.factor / sqrt(u * u + v * v + w * w)
        t, gone = _bounded_impulse(k, a_nc * -v, resolution, mobility, velocity)
        s = select_three(soft, t, s)
        taken = select(soft, gone, taken)
    return s, taken


@no_refcount_kernel
def collide(law, speed, resolution, moments, point, motion, series, where=True):
    """Apply one collision at the contact ``point`` to ``motion``, in the lanes that collide.

    The rebound velocity of the contact point is a_nc |v_c| (6), or the resolution where that is
    smaller: tiny bounces are nearly elastic and would go on for ever (sustained contact). Under
    Coulomb's law a_nc is the energetic restitution instead (`tablegen.model.coulomb`).

    ``speed`` is V [m/s], ``resolution`` the smallest rebound speed of the contact point over V,
    ``moments`` are those of inertia, ``point`` (3,) is from the centre in body axes, ``series``
    (9, ORDER + 1) work space. Returns the energies per unit mass, in units of V^2, that the normal
    and the tangential impulse took.
    """
    x, n, z = _wall_axes(motion)
    r = load_three(point, 0)
    # r x e for each wall axis e: the torque arm of an impulse along e
    a, b, c = cross(r, x), cross(r, n), cross(r, z)
    inverse = 1.0 / moments[0], 1.0 / moments[1], 1.0 / moments[2]
    mobility = _mobility(a, b, c, inverse)
    w = load_three(motion, 0)
    u, v, w_z = load_three(motion, U)
    # contact velocity (2)
    u_c, v_c, w_c = u + _dot(w, a), v + _dot(w, b), w_z + _dot(w, c)
    # lanes that do not collide may recede, which has no solution to search for
    v_c = select(where, v_c, -1.0)
    size_c = sqrt(u_c * u_c + v_c * v_c + w_c * w_c)
    cosine = -v_c / size_c
    a_nc = restitution(law, speed * size_c, cosine)
    velocity = u_c, v_c, w_c
    if law.resistance_law == COULOMB:
        s, taken = _friction_impulse(law, a_nc, resolution, mobility, velocity, series, where)
    else:
        r_dot_v = u * _dot(r, x) + v * _dot(r, n) + w_z * _dot(r, z)
        c_f = resistance(law, r_dot_v, sqrt(_dot(r, r)), sqrt(u * u + v * v + w_z * w_z), cosine)
        s, taken = _bounded_impulse(c_f / size_c, a_nc * -v_c, resolution, mobility, velocity)
    after = u + s[0], v + s[1], w_z + s[2]
    store_three(motion, U, select_three(where, after, (u, v, w_z)))
    for i in range(3):
        turned = w[i] + inverse[i] * (a[i] * s[0] + b[i] * s[1] + c[i] * s[2])
        store(motion, i, select(where, turned, w[i]))
    taken, rest = energies_taken(velocity, mobility, s, taken)
    return select(where, taken, 0.0), select(where, rest, 0.0)


@inline_kernel
def has_no_impulse(taken):
    """Whether a collision did not end (`tablegen.model.coulomb.PIECE_ALARM`), from its energies."""
    return logical_not(taken[1] == taken[1])


@no_refcount_kernel
def fly(body, top, tolerance, motion, series, where):
    """Move ``motion`` along one flight series: to the next contact, off the wall, or to its end.

    ``top`` is the height at which a particle that rises has left, ``tolerance`` the truncation of
    the series, ``series`` (9, ORDER + 1) work space; lanes outside of ``where`` stay. Returns
    whether the particle touches the wall, and whether it has left.
    """
    y, v = load(motion, HEIGHT), load(motion, V)
    # whether the flight ends is decided by this time and not by a height reached, which
    # rounding may hold back for ever where v is small
    leaving = select(v > 0.0, maximum((top - y) / v, 0.0), math.inf)
    expand(body.moments, motion, series)
    span = minimum(series_span(series, tolerance), leaving)
    # below minus the bounding radius, or after this time, every body touches
    span = select(v < 0.0, minimum(span, maximum((y + body.bounding_radius) / -v, 0.0)), span)
    span = select(where, span, 0.0)
    t = search(body, series, y, v, rate_bounds(body.moments, motion), span)
    touches = t >= 0.0
    t = select(touches, t, span)
    evaluate(body.moments, series, t, motion)
    # in this form a NaN ends the flight
    left = where & logical_not(touches) & logical_not(span < leaving)
    store(motion, HEIGHT, select(left & (leaving > 0.0), top, fma(v, t, y)))
    return touches, left


@no_refcount_kernel
def next_contact(body, top, tolerance, motion, series):
    """Move ``motion`` to the next contact, or off the wall; tell whether the particle touches."""
    while True:
        touches, left = fly(body, top, tolerance, motion, series, True)
        if touches or left:
            return touches


@no_refcount_kernel
def _remember(motion, before):
    """Copy the motion; a slice assignment would make a temporary array."""
    for i in range(MOTION_SIZE):
        before[i] = motion[i]


@no_refcount_kernel
def rebound(law, condition, body, motion, work, audit):
    """Follow a particle from before its first contact until it has left the wall.

    ``motion`` (13,) is that before the rebound, and on return as the particle leaves; ``work``
    comes from `workspace`; ``audit`` (AUDIT_SIZE,) keeps the largest violations, and (0,) switches
    the audit off. Returns the status, the number of collisions, and the energies that the normal
    and the tangential impulses took.
    """
    series, point, before = work
    collisions = 0
    normal = shear = 0.0
    # without spin a particle starts at its contact
    touches, top = translates(condition), body.bounding_radius
    while True:
        if not touches:
            _remember(motion, before)
            touches = next_contact(body, top, condition.tolerance, motion, series)
            if audit.size > 0:
                audit_flight(body.moments, before, motion, audit)
            if not touches:
                return LEFT, collisions, (normal, shear)
        if collisions == COLLISION_ALARM:
            return UNFINISHED, collisions, (normal, shear)
        gap = contact_point(body, motion, motion[HEIGHT], motion[V], point)
        motion[HEIGHT] -= min(gap, 0.0)
        _remember(motion, before)
        numbers = condition.speed, condition.resolution
        taken = collide(law, *numbers, body.moments, point, motion, series)
        normal, shear = normal + taken[0], shear + taken[1]
        if has_no_impulse(taken):
            return UNFINISHED, collisions, taken
        top = departure_height(body, condition.instant, motion)
        touches = False
        collisions += 1
        if audit.size > 0:
            audit[PENETRATION] = max(audit[PENETRATION], -gap)
            audit_collision(law, *numbers, body.moments, point, before, motion, audit)


@no_refcount_kernel
def approach(condition, body, motion, where=True):
    """Set velocity, spin and height of oriented particles before their rebound.

    Without spin a particle translates, so it starts at its contact; with spin it starts where no
    phase of its tumbling touches (`tumbling_reach`), and falls, turning. Rows 3:9 of ``motion``
    (13,) hold the orientation; the others are written, in the lanes ``where``.
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


@inline_kernel
def workspace():
    """Arrays that :func:`rebound` works in."""
    return np.empty((9, ORDER + 1)), np.empty(3), np.empty(MOTION_SIZE)
