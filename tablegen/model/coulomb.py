"""One collision under Coulomb friction, followed over the growing normal impulse (Routh's method).

With the contact velocity V_c = V_c- + A S, the mobility A and the normal impulse s = S_n as the
variable, the tangential impulse obeys Coulomb's law at every instant of the collision:

- a contact that slides along e has dS_t/ds = -mu_d e;
- where sliding has come to rest, the contact sticks if the impulse that holds it lies within the
  static cone, |A_tt^-1 A_tn| <= mu_s: dS_t/ds = -A_tt^-1 A_tn, which does not change any more;
- else it slides anew, along the one direction e in which sliding from rest keeps its direction:
  A_tn - mu_d A_tt e = f e with f > 0.

While it slides, du/ds = -A_tt grad(mu_d |u| - b . u) with b = A_tt^-1 A_tn. The bracket is convex,
so two solutions never part in the metric of A_tt^-1: the path is unique, rest is reached if and
only if |b| <= mu_d (or sliding goes straight against b), and errors made on the way do not grow.

The normal impulse does the work w(s), the integral of v_c. The collision ends with Stronge's
energetic restitution: the part e^2 of the work of compression is recovered,

    w = (1 - e^2) min w.

Energy is changed by w <= 0 and by the work of friction, -mu_d times the integral of |u|: it never
grows, whatever the body. In central contacts e is the ratio of normal velocities.

Sources: Routh, Dynamics of a System of Rigid Bodies (1860), Part I, ch. 5; Keller, J. Appl. Mech.
53 (1986) 1; Stronge, Proc. R. Soc. Lond. A 431 (1990) 169; Batlle, J. Appl. Mech. 63 (1996) 804.

The mass is one.
"""

import math
from typing import NamedTuple

from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.simd import any_lane, logical_not, maximum, minimum, select, sqrt
from tablegen.model.sliding import (
    IMPULSE,
    NORMAL_VELOCITY,
    PATH_TOLERANCE,
    SLIDE_X,
    SLIDE_Z,
    WORK,
    expand_sliding,
    gained,
    put_line,
    sliding_span,
    slope,
    straight_piece,
)

#: Relative Newton step after which a root is exact to rounding: the error of a step is the square
#: of that of the one before.
CONVERGED = 1e-9

#: Halvings of an interval, down to rounding.
HALVINGS = 53

#: Rate dv_c/ds that counts as none where the normal velocity has a turning point.
FLAT = 1e-9

#: Pieces after which a path that has not ended is given up. It is an alarm, not a cap: the impulse
#: is NaN, and the caller must raise. The longest path met in some million rebounds had 150 pieces;
#: of blades with ratios of 0.02, 279.
PIECE_ALARM = 100_000


class Ending(NamedTuple):
    """When a collision ends: ``loss`` = 1 - e^2, and the least normal velocity, positive."""

    loss: float
    resolution: float


class Path(NamedTuple):
    """State of a collision since it began.

    Present tangential contact velocity and its changes, normal impulse, present normal contact
    velocity, work of the normal impulse and its minimum so far, whether the contact is compressed.
    Of a slide that is nearly at rest, the changes have lost the direction to rounding.
    """

    u: float
    w: float
    x: float
    z: float
    impulse: float
    v: float
    work: float
    least: float
    compresses: bool


@inline_kernel
def _begin(velocity):
    """Path of no impulse."""
    u, v, w = velocity
    none = 0.0 * v
    return Path(u, w, none, none, none, v, none, none, v < 0.0)


@no_refcount_inline_kernel
def _piece(friction, mobility, velocity, size, series):
    """Write the next piece; its length, whether it leads to rest, growth of s in its variable."""
    line, turns = straight_piece(friction, mobility, velocity, size)
    length, growth = line.length, 1.0 + 0.0 * size
    if any_lane(turns):
        axx, axy, _, _, ayz, azz = mobility
        # lanes that do not turn may be at rest, which has no series
        u = select(turns, velocity[0], size)
        expand_sliding(friction.dynamic, mobility, (u, velocity[1], velocity[2]), series)
        rate = sqrt(axy * axy + ayz * ayz) + friction.dynamic * (axx + azz)
        span = sliding_span(series, rate, PATH_TOLERANCE * size)
        length = select(turns, span, length)
        growth = select(turns, slope(series, IMPULSE, 0.0 * size), growth)
    put_line(series, velocity, line.rates, turns)
    return length, line.stops & logical_not(turns), growth


@no_refcount_kernel
def _turning_point(series, v, first, turns, length, where):
    """Where the normal velocity of a piece has its extreme, or falls to zero; by bisection.

    ``v`` and ``first`` are the normal velocity at the start and its slope there; in the lanes
    ``turns`` the velocity has an extreme. Lanes outside of ``where`` keep their length.
    """
    low, high = 0.0 * length, length
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        above = v + gained(series, NORMAL_VELOCITY, middle)
        value = select(turns, first * slope(series, NORMAL_VELOCITY, middle), above)
        low, high = select(value > 0.0, middle, low), select(value > 0.0, high, middle)
    return select(where, high, length)


@no_refcount_inline_kernel
def _monotone(series, v, growth, length, going):
    """Shorten a piece so that its normal velocity only rises, or only falls and not below zero.

    Then its value at the end tells whether compression or the collision ends on the piece. It falls
    where a contact jams: friction drives it into the wall. Returns the length, whether the velocity
    falls, and whether it falls to zero.
    """
    first = slope(series, NORMAL_VELOCITY, 0.0 * length)
    last = slope(series, NORMAL_VELOCITY, length)
    turns = going & (first * last < 0.0)
    turns = turns & (minimum(abs(first), abs(last)) > FLAT * growth)
    end = v + gained(series, NORMAL_VELOCITY, length)
    sinks = going & logical_not(turns) & (v > 0.0) & (end < 0.0)
    if any_lane(turns | sinks):
        length = _turning_point(series, v, first, turns, length, turns | sinks)
        end = v + gained(series, NORMAL_VELOCITY, length)
    return length, end < v, sinks


@inline_kernel
def _progress(ending, path, falls, v, work):
    """Signed distance from the end of compression, or of the collision: below zero before it.

    In compression it is the velocity. The collision ends where the work has reached its part and
    the velocity the resolution, but no later than an elastic one. ``path`` is at the start of the
    piece: a velocity that falls from below the resolution does not reach it there.
    """
    part = work - ending.loss * path.least
    part = select(falls, part, minimum(part, v - ending.resolution))
    part = select(falls & (path.v < ending.resolution), work, part)
    return select(path.compresses, v, maximum(part, work))


@inline_kernel
def _straight_guess(ending, path, rate):
    """Guess the normal impulse to the next event: the normal velocity rises on at its rate."""
    rises = rate > 0.0
    rate = select(rises, rate, 1.0)
    start = maximum(path.v, 0.0)
    square = start * start
    back = sqrt(square + 2.0 * rate * maximum(ending.loss * path.least - path.work, 0.0))
    elastic = sqrt(square + 2.0 * rate * maximum(-path.work, 0.0))
    end = minimum(maximum(back, ending.resolution), elastic)
    return select(rises, select(path.compresses, -path.v, end - start) / rate, 0.0)


@no_refcount_kernel
def _crossing(series, ending, path, falls, guess, length, where):
    """Where the progress on a piece passes through zero: Newton's method kept in a bracket.

    ``path`` is at the start of the piece, ``guess`` the first guess; at ``length``, the end of the
    piece, the progress is not below zero. Lanes outside of ``where`` get no meaningful result.
    """
    low, high = 0.0 * length, length
    t = select((guess > 0.0) & (guess < length), guess, length)
    # a contact that falls may have done its part before
    done = _progress(ending, path, falls, path.v, path.work) >= 0.0
    done = done & logical_not(path.compresses)
    where = where & logical_not(done)
    while any_lane(where):
        v = path.v + gained(series, NORMAL_VELOCITY, t)
        work = path.work + gained(series, WORK, t)
        value = _progress(ending, path, falls, v, work)
        floor = v - ending.resolution
        waits = logical_not(falls) & (floor < work - ending.loss * path.least) & (floor > work)
        by_velocity = path.compresses | waits
        rate = select(by_velocity, slope(series, NORMAL_VELOCITY, t), slope(series, WORK, t))
        step = value / rate
        # in this form a NaN ends the search
        far = abs(step) > CONVERGED * t
        low, high = select(value < 0.0, t, low), select(value < 0.0, high, t)
        middle = 0.5 * (low + high)
        newton = t - step
        leaves = far & logical_not((low < newton) & (newton < high))
        t = select(where, select(leaves, middle, newton), t)
        where = where & far & logical_not(leaves & logical_not((low < middle) & (middle < high)))
    return select(done, 0.0, t)


@no_refcount_inline_kernel
def _advanced(path, series, length, where):
    """Path after a piece, in the lanes that take it."""
    x, z = gained(series, SLIDE_X, length), gained(series, SLIDE_Z, length)
    return Path(
        select(where, path.u + x, path.u),
        select(where, path.w + z, path.w),
        select(where, path.x + x, path.x),
        select(where, path.z + z, path.z),
        select(where, path.impulse + gained(series, IMPULSE, length), path.impulse),
        select(where, path.v + gained(series, NORMAL_VELOCITY, length), path.v),
        select(where, path.work + gained(series, WORK, length), path.work),
        path.least,
        path.compresses,
    )


@inline_kernel
def _at_rest(path, velocity, where):
    """Path whose tangential contact velocity is zero, in some lanes."""
    return Path(
        select(where, 0.0, path.u),
        select(where, 0.0, path.w),
        select(where, -velocity[0], path.x),
        select(where, -velocity[2], path.z),
        path.impulse,
        path.v,
        path.work,
        path.least,
        path.compresses,
    )


@no_refcount_kernel
def _step(contact, ending, path, series, going):
    """Follow one piece of a path, up to an event or to its end; tell whether the collision ends."""
    friction, mobility, velocity, size = contact
    least = PATH_TOLERANCE * size
    path = _at_rest(path, velocity, path.u * path.u + path.w * path.w <= least * least)
    present = path.u, path.v, path.w
    length, stops, growth = _piece(friction, mobility, present, size, series)
    length, falls, sinks = _monotone(series, path.v, growth, length, going)
    v = path.v + gained(series, NORMAL_VELOCITY, length)
    work = path.work + gained(series, WORK, length)
    reaches = going & (_progress(ending, path, falls, v, work) >= 0.0)
    if any_lane(reaches):
        rate = slope(series, NORMAL_VELOCITY, 0.0 * size) / growth
        guess = _straight_guess(ending, path, rate) / growth
        t = _crossing(series, ending, path, falls, guess, length, reaches)
        length = select(reaches, t, length)
    fast = path.v >= ending.resolution
    path = _advanced(path, series, length, going)
    path = _at_rest(path, velocity, going & stops & logical_not(reaches | sinks))
    turns_back, ended = reaches & path.compresses, reaches & logical_not(path.compresses)
    # it fell below the resolution before the work had reached its part
    slow = falls & fast & (path.v < ending.resolution) & (path.work < 0.0)
    ended = ended & logical_not(slow)
    return Path(
        path.u,
        path.w,
        path.x,
        path.z,
        path.impulse,
        select(turns_back | sinks, 0.0, path.v),
        path.work,
        select(turns_back, minimum(path.least, path.work), path.least),
        (path.compresses & logical_not(turns_back)) | (sinks & logical_not(ended)),
    ), ended


@no_refcount_kernel
def coulomb_impulse(friction, ending, mobility, velocity, series, where):
    """Impulse (Su, Sv, Sw) of a collision under Coulomb friction, and the energy that Sv takes.

    That energy is followed along the collision: the contact velocity is no linear function of the
    impulse where the direction of sliding turns or the contact sticks. ``velocity`` is that of the
    contact before the collision in wall axes, ``series`` (9, ORDER + 1) work space; lanes outside
    of ``where`` get meaningless impulses.
    """
    u, v, w = velocity
    size = sqrt(u * u + v * v + w * w)
    contact = friction, mobility, velocity, size
    path = _begin(velocity)
    going = where & path.compresses
    pieces = 0
    while any_lane(going) and pieces < PIECE_ALARM:
        path, ended = _step(contact, ending, path, series, going)
        # in this form a NaN ends the path
        going = going & logical_not(ended) & (path.impulse >= 0.0)
        pieces += 1
    normal = select(going, math.nan, path.impulse)
    axx, axy, axz, _, ayz, azz = mobility
    x, z = path.x - axy * normal, path.z - ayz * normal
    det = axx * azz - axz * axz
    return ((azz * x - axz * z) / det, normal, (axx * z - axz * x) / det), -path.work
