"""The impulse of one collision under Coulomb friction, by Routh's method.

The collision is followed while the normal impulse s = S_n grows. With the mobility A, the contact
velocity is V_c = V_c- + A S. The tangential impulse obeys Coulomb's law at every instant of the
collision:

- a contact that slides along e has dS_t/ds = -mu_d e;
- once sliding has come to rest, the contact sticks if the impulse that holds it is inside the
  static cone, |A_tt^-1 A_tn| <= mu_s. Then dS_t/ds = -A_tt^-1 A_tn until the end;
- otherwise it slides again, along the only direction e that sliding from rest keeps:
  A_tn - mu_d A_tt e = f e with f > 0.

While the contact slides, du/ds = -A_tt grad(mu_d |u| - b . u) with b = A_tt^-1 A_tn. The bracket is
convex, so two solutions never move apart in the metric of A_tt^-1. So the path is unique, numerical
errors do not grow along it, and sliding comes to rest if and only if |b| <= mu_d, or if it goes
straight against b.

The normal impulse does the work w(s), the integral of v_c. The collision ends by Stronge's
energetic restitution e = a_nc: the share e^2 of the work of compression is given back,

    w = (1 - e^2) min w.

The energy changes by w <= 0 and by the work of friction, -mu_d times the integral of |u|. So it
never grows, whatever the body. In central contacts e is the ratio of normal velocities.

Sources: Routh, Dynamics of a System of Rigid Bodies (1860), Part I, ch. 5; Keller, J. Appl. Mech.
53 (1986) 1; Stronge, Proc. R. Soc. Lond. A 431 (1990) 169; Batlle, J. Appl. Mech. 63 (1996) 804.

Units: velocities in the impact speed V, mass one, so that impulses are changes of velocity. Vectors
are in wall axes. `tablegen.model.sliding` has the pieces of the path.
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
    change_on_piece,
    expand_sliding,
    sliding_span,
    slope_on_piece,
    store_line,
    straight_piece,
)

#: Relative Newton step after which a root is exact to rounding, because each step squares the
#: error.
CONVERGED = 1e-9

#: Bisections after which an interval is as short as rounding.
HALVINGS = 53

#: Rate dv_c/ds below which the normal velocity counts as constant.
FLAT = 1e-9

#: Pieces after which a path is given up. It is an alarm, not a cap: the impulse is NaN, and the
#: caller must raise an error. The longest path in some million rebounds had 150 pieces, and 279 for
#: blades with ratios of 0.02.
PIECE_ALARM = 100_000


class Ending(NamedTuple):
    """When a collision ends: ``loss`` = 1 - e^2, ``resolution`` the least normal velocity, > 0."""

    loss: float
    resolution: float


class Path(NamedTuple):
    """State of a collision at some normal impulse.

    ``u, w``: tangential contact velocity; ``x, z``: its change since the collision began, which is
    kept beside the velocity because a velocity near rest loses its digits; ``impulse``: normal
    impulse; ``v``: normal contact velocity; ``work``: of the normal impulse; ``least``: minimum of
    the work so far; ``compresses``: whether the contact is still being compressed.
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
def _path_at_start(velocity):
    """Make the path at the beginning of a collision."""
    u, v, w = velocity
    none = 0.0 * v
    return Path(u, w, none, none, none, v, none, none, v < 0.0)


@no_refcount_inline_kernel
def _write_piece(friction, mobility, velocity, size, series):
    """Write the series of the next piece.

    Returns the length of the piece, whether it leads to rest, and the rate ds/dt of the impulse in
    the variable of the piece at its start.
    """
    line, turns = straight_piece(friction, mobility, velocity, size)
    length, growth = line.length, 1.0 + 0.0 * size
    if any_lane(turns):
        axx, axy, _, _, ayz, azz = mobility
        # a lane that does not turn may be at rest, where the series does not exist
        u = select(turns, velocity[0], size)
        expand_sliding(friction.dynamic, mobility, (u, velocity[1], velocity[2]), series)
        rate = sqrt(axy * axy + ayz * ayz) + friction.dynamic * (axx + azz)
        span = sliding_span(series, rate, PATH_TOLERANCE * size)
        length = select(turns, span, length)
        growth = select(turns, slope_on_piece(series, IMPULSE, 0.0 * size), growth)
    store_line(series, velocity, line.rates, turns)
    return length, line.stops & logical_not(turns), growth


@no_refcount_kernel
def _turning_point(series, v, first, turns, length, where):
    """Find by bisection where the normal velocity on a piece has its extreme, or falls to zero.

    ``v`` and ``first`` are the normal velocity and its slope at the start. In the lanes ``turns``
    the velocity has an extreme, in the others it falls to zero. Lanes outside of ``where`` keep
    their length.
    """
    low, high = 0.0 * length, length
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        above = v + change_on_piece(series, NORMAL_VELOCITY, middle)
        value = select(turns, first * slope_on_piece(series, NORMAL_VELOCITY, middle), above)
        low, high = select(value > 0.0, middle, low), select(value > 0.0, high, middle)
    return select(where, high, length)


@no_refcount_inline_kernel
def _shorten_to_monotone(series, v, growth, length, going):
    """Shorten a piece so that its normal velocity only rises, or only falls and not below zero.

    Then the value at the end tells whether the compression or the collision ends on the piece. The
    normal velocity falls where a contact jams, because friction drives it into the wall. Returns
    the length, whether the velocity falls, and whether it falls to zero.
    """
    first = slope_on_piece(series, NORMAL_VELOCITY, 0.0 * length)
    last = slope_on_piece(series, NORMAL_VELOCITY, length)
    turns = going & (first * last < 0.0)
    turns = turns & (minimum(abs(first), abs(last)) > FLAT * growth)
    end = v + change_on_piece(series, NORMAL_VELOCITY, length)
    sinks = going & logical_not(turns) & (v > 0.0) & (end < 0.0)
    if any_lane(turns | sinks):
        length = _turning_point(series, v, first, turns, length, turns | sinks)
        end = v + change_on_piece(series, NORMAL_VELOCITY, length)
    return length, end < v, sinks


@inline_kernel
def _progress(ending, path, falls, v, work):
    """Compute the signed distance from the end of compression, or of the collision.

    It is negative before that end. During compression it is the normal velocity. Afterwards the
    collision ends when the work has given back its share and the velocity has reached the
    resolution, but no later than an elastic collision would. ``path`` is the state at the start of
    the piece: a velocity that falls from below the resolution cannot reach it on this piece.
    """
    part = work - ending.loss * path.least
    part = select(falls, part, minimum(part, v - ending.resolution))
    part = select(falls & (path.v < ending.resolution), work, part)
    return select(path.compresses, v, maximum(part, work))


@inline_kernel
def _straight_guess(ending, path, rate):
    """Guess the normal impulse to the next event from the present rate of the normal velocity."""
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
    """Find where the progress on a piece passes through zero, by Newton's method in a bracket.

    ``path`` is the state at the start of the piece, ``guess`` the first guess. At ``length``, the
    end of the piece, the progress is not negative. Results of lanes outside of ``where`` mean
    nothing.
    """
    low, high = 0.0 * length, length
    t = select((guess > 0.0) & (guess < length), guess, length)
    # a contact whose velocity falls may have given back its share before this piece
    done = _progress(ending, path, falls, path.v, path.work) >= 0.0
    done = done & logical_not(path.compresses)
    where = where & logical_not(done)
    while any_lane(where):
        v = path.v + change_on_piece(series, NORMAL_VELOCITY, t)
        work = path.work + change_on_piece(series, WORK, t)
        value = _progress(ending, path, falls, v, work)
        floor = v - ending.resolution
        waits = logical_not(falls) & (floor < work - ending.loss * path.least) & (floor > work)
        by_velocity = path.compresses | waits
        rate = select(
            by_velocity, slope_on_piece(series, NORMAL_VELOCITY, t), slope_on_piece(series, WORK, t)
        )
        step = value / rate
        # a comparison with NaN is false, so a NaN ends the search
        far = abs(step) > CONVERGED * t
        low, high = select(value < 0.0, t, low), select(value < 0.0, high, t)
        middle = 0.5 * (low + high)
        newton = t - step
        leaves = far & logical_not((low < newton) & (newton < high))
        t = select(where, select(leaves, middle, newton), t)
        where = where & far & logical_not(leaves & logical_not((low < middle) & (middle < high)))
    return select(done, 0.0, t)


@no_refcount_inline_kernel
def _path_after_piece(path, series, length, where):
    """Compute the path after a piece, in the lanes ``where``."""
    x, z = change_on_piece(series, SLIDE_X, length), change_on_piece(series, SLIDE_Z, length)
    return Path(
        select(where, path.u + x, path.u),
        select(where, path.w + z, path.w),
        select(where, path.x + x, path.x),
        select(where, path.z + z, path.z),
        select(where, path.impulse + change_on_piece(series, IMPULSE, length), path.impulse),
        select(where, path.v + change_on_piece(series, NORMAL_VELOCITY, length), path.v),
        select(where, path.work + change_on_piece(series, WORK, length), path.work),
        path.least,
        path.compresses,
    )


@inline_kernel
def _path_at_rest(path, velocity, where):
    """Set the tangential contact velocity of a path to zero, in the lanes ``where``."""
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
def _follow_piece(contact, ending, path, series, going):
    """Follow one piece of a path, up to an event or to its end; tell whether the collision ends."""
    friction, mobility, velocity, size = contact
    least = PATH_TOLERANCE * size
    path = _path_at_rest(path, velocity, path.u * path.u + path.w * path.w <= least * least)
    present = path.u, path.v, path.w
    length, stops, growth = _write_piece(friction, mobility, present, size, series)
    length, falls, sinks = _shorten_to_monotone(series, path.v, growth, length, going)
    v = path.v + change_on_piece(series, NORMAL_VELOCITY, length)
    work = path.work + change_on_piece(series, WORK, length)
    reaches = going & (_progress(ending, path, falls, v, work) >= 0.0)
    if any_lane(reaches):
        rate = slope_on_piece(series, NORMAL_VELOCITY, 0.0 * size) / growth
        guess = _straight_guess(ending, path, rate) / growth
        t = _crossing(series, ending, path, falls, guess, length, reaches)
        length = select(reaches, t, length)
    fast = path.v >= ending.resolution
    path = _path_after_piece(path, series, length, going)
    path = _path_at_rest(path, velocity, going & stops & logical_not(reaches | sinks))
    turns_back, ended = reaches & path.compresses, reaches & logical_not(path.compresses)
    # the velocity fell below the resolution before the work had given back its share
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
    """Compute the impulse (S_x, S_y, S_z) of a collision and the energy that S_y takes.

    The energy is followed along the collision, because the contact velocity is no linear function
    of the impulse where the direction of sliding turns or the contact sticks. ``velocity`` is that
    of the contact before the collision in wall axes; ``series`` (9, ORDER + 1) is work space.
    Impulses of lanes outside of ``where`` mean nothing.
    """
    u, v, w = velocity
    size = sqrt(u * u + v * v + w * w)
    contact = friction, mobility, velocity, size
    path = _path_at_start(velocity)
    going = where & path.compresses
    pieces = 0
    while any_lane(going) and pieces < PIECE_ALARM:
        path, ended = _follow_piece(contact, ending, path, series, going)
        # a comparison with NaN is false, so a NaN ends the path
        going = going & logical_not(ended) & (path.impulse >= 0.0)
        pieces += 1
    normal = select(going, math.nan, path.impulse)
    axx, axy, axz, _, ayz, azz = mobility
    x, z = path.x - axy * normal, path.z - ayz * normal
    det = axx * azz - axz * axz
    return ((azz * x - axz * z) / det, normal, (axx * z - axz * x) / det), -path.work
