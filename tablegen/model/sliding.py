"""Pieces of a collision under Coulomb friction: a contact slides, sticks, or slides again.

While a contact slides with the tangential velocity u, it obeys

    du/ds = A_tn - mu_d A_tt u / |u|,    dv/ds = A_nn - mu_d A_tn . u / |u|,    dw/ds = v

in the normal impulse s, with the mobility A, the normal velocity v and the work w of the normal
impulse. `tablegen.model.coulomb` explains rest, and why the path is unique and ends.

On a piece of the path u, s, v and w are polynomials of one variable. Where u keeps its direction
the variable is s, and the piece is a straight line. Where u turns, the variable is t with
ds = |u| dt. Then the equations have no quotients,

    u' = A_tn |u| - mu A_tt u,   s' = |u|,   v' = A_nn |u| - mu A_tn . u,   w' = |u| v,

and each Taylor coefficient follows from those of lower order by one convolution.

Units: velocities in the impact speed V, mass one, so that impulses are changes of velocity. Vectors
are in wall axes; t stands for x and z, n for y. A mobility is the six numbers A_xx, A_xy, A_xz,
A_yy, A_yz, A_zz of dV_c = A dV_p. Sources are those of `tablegen.model.coulomb`.
"""

from typing import NamedTuple

from tablegen.model.elementary import exponential, logarithm
from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.rotation import ORDER, TINY, last_terms
from tablegen.model.simd import (
    any_lane,
    fma,
    load,
    logical_not,
    maximum,
    minimum,
    select,
    sqrt,
    store,
)

#: Over the contact speed: the change of direction below which a slide counts as straight, and the
#: sliding velocity below which a contact rests. Errors of the pieces add up, and do not grow.
PATH_TOLERANCE = 1e-13

#: Normal impulse over the contact speed that no collision reaches. The largest is 2, because the
#: energy cannot grow and the mobility is at least one.
REACH = 3.0

#: Relative Newton step that is no more than rounding.
ROUNDING = 1e-14

#: Rate of turning over the largest rate of the sliding velocity that is no more than rounding.
ACROSS_ROUNDING = 1e-15

#: Rows of the coefficients: the tangential velocity, its modulus, the normal impulse, the normal
#: velocity, the work of the normal impulse.
SLIDE_X, SLIDE_Z, SLIDE, IMPULSE, NORMAL_VELOCITY, WORK = range(6)


class Friction(NamedTuple):
    """Coefficients of friction: static, which holds a contact at rest, and dynamic."""

    static: float
    dynamic: float


class Line(NamedTuple):
    """Straight piece of a path: rates of (u, v, w) in s, length in s, whether it leads to rest."""

    rates: tuple[float, float, float]
    length: float
    stops: bool


@inline_kernel
def static_pull(mobility):
    """Compute A_tt^-1 A_tn: minus the tangential over the normal impulse that holds a contact."""
    axx, axy, axz, _, ayz, azz = mobility
    det = axx * azz - axz * axz
    return (azz * axy - axz * ayz) / det, (axx * ayz - axz * axy) / det


@no_refcount_kernel
def slip_direction(friction, mobility, where):
    """Find the direction in which a contact at rest begins to slide and keeps sliding.

    It is p with (mu A_tt + f) p = A_tn and |p| = 1, where f > 0 is the rate of |u|. The length of p
    falls with f, from |A_tt^-1 A_tn| / mu > 1, so there is one solution. Newton's method for
    1 / |p|, which is concave in f, climbs to it from below. ``friction`` is mu_d; ``where`` are the
    lanes in which |A_tt^-1 A_tn| > mu_d.
    """
    axx, axy, axz, _, ayz, azz = mobility
    # this start is below the root, and positive without friction
    pull = sqrt(axy * axy + ayz * ayz)
    rate = maximum(pull - friction * (axx + azz), 0.0)
    x, z = axy, ayz
    while any_lane(where):
        mxx, mzz, mxz = friction * axx + rate, friction * azz + rate, friction * axz
        det = mxx * mzz - mxz * mxz
        px, pz = (mzz * axy - mxz * ayz) / det, (mxx * ayz - mxz * axy) / det
        qx, qz = (mzz * px - mxz * pz) / det, (mxx * pz - mxz * px) / det
        square = px * px + pz * pz
        length = sqrt(square)
        step = (length - 1.0) * square / (px * qx + pz * qz)
        x, z = select(where, px, x), select(where, pz, z)
        rate = select(where, rate + step, rate)
        # a comparison with NaN is false, so a NaN ends the search
        where = where & (step > ROUNDING * rate)
    length = sqrt(x * x + z * z)
    return x / length, z / length


@no_refcount_kernel
def straight_piece(friction, mobility, velocity, size):
    """Make the straight piece that begins at a contact velocity; tell whether the slide turns.

    A slide counts as straight if its rate of turning |du_perp/ds| cannot carry it farther from the
    line than the tolerance. If it turns, the piece is not the path. ``size`` is the contact speed
    before the collision.
    """
    axx, axy, axz, ayy, ayz, azz = mobility
    u, _, w = velocity
    slide = sqrt(u * u + w * w)
    rests = slide == 0.0
    slide = select(rests, 1.0, slide)
    e_x, e_z = u / slide, w / slide
    pull_x, pull_z = friction.dynamic * e_x, friction.dynamic * e_z
    holds = rests & logical_not(rests)
    if any_lane(rests):
        b_x, b_z = static_pull(mobility)
        holds = rests & (b_x * b_x + b_z * b_z <= friction.static * friction.static)
        slips = rests & logical_not(holds)
        if any_lane(slips):
            x, z = slip_direction(friction.dynamic, mobility, slips)
            e_x, e_z = select(slips, x, e_x), select(slips, z, e_z)
            pull_x = select(slips, friction.dynamic * x, pull_x)
            pull_z = select(slips, friction.dynamic * z, pull_z)
        pull_x, pull_z = select(holds, b_x, pull_x), select(holds, b_z, pull_z)
    q_x = axy - (axx * pull_x + axz * pull_z)
    q_z = ayz - (axz * pull_x + azz * pull_z)
    rate_v = ayy - (axy * pull_x + ayz * pull_z)
    along = select(holds, 0.0, q_x * e_x + q_z * e_z)
    across = q_z * e_x - q_x * e_z
    stops = (along < 0.0) & logical_not(rests)
    length = REACH * size
    to_rest = slide / select(stops, -along, 1.0)
    stops = stops & (to_rest < length)
    length = select(stops, to_rest, length)
    rate = abs(axy) + abs(ayz) + friction.dynamic * (axx + azz)
    least = maximum(PATH_TOLERANCE * size, ACROSS_ROUNDING * rate * length)
    turns = logical_not(rests) & (abs(across) * length > least)
    return Line((along * e_x, rate_v, along * e_z), length, stops), turns


@no_refcount_kernel
def expand_sliding(friction, mobility, velocity, series):
    """Write the Taylor coefficients of a sliding contact in t to rows 0 to 5 of ``series``.

    Those of order 0 of the impulse and the work are left out, because only their changes count.
    ``friction`` is mu_d; ``velocity`` is that of the contact, (u, v, w) with (u, w) not zero;
    ``series`` is (9, ORDER + 1).
    """
    axx, axy, axz, ayy, ayz, azz = mobility
    mxx, mxz, mzz = friction * axx, friction * axz, friction * azz
    mxy, myz = friction * axy, friction * ayz
    u, v, w = velocity
    slide = sqrt(u * u + w * w)
    store(series, (SLIDE_X, 0), u)
    store(series, (SLIDE_Z, 0), w)
    store(series, (SLIDE, 0), slide)
    store(series, (NORMAL_VELOCITY, 0), v)
    half = 0.5 / slide
    for k in range(ORDER):
        x, z = load(series, (SLIDE_X, k)), load(series, (SLIDE_Z, k))
        r = load(series, (SLIDE, k))
        scale = 1.0 / (k + 1)
        x = fma(axy, r, -fma(mxx, x, mxz * z)) * scale
        z = fma(ayz, r, -fma(mxz, load(series, (SLIDE_X, k)), mzz * z)) * scale
        normal = fma(mxy, load(series, (SLIDE_X, k)), myz * load(series, (SLIDE_Z, k)))
        store(series, (SLIDE_X, k + 1), x)
        store(series, (SLIDE_Z, k + 1), z)
        store(series, (IMPULSE, k + 1), r * scale)
        store(series, (NORMAL_VELOCITY, k + 1), fma(ayy, r, -normal) * scale)
        square = 2.0 * fma(u, x, w * z)
        work = r * v
        for j in range(1, k + 1):
            one = load(series, (SLIDE, j))
            work = fma(load(series, (SLIDE, k - j)), load(series, (NORMAL_VELOCITY, j)), work)
            square = fma(load(series, (SLIDE_X, j)), load(series, (SLIDE_X, k + 1 - j)), square)
            square = fma(load(series, (SLIDE_Z, j)), load(series, (SLIDE_Z, k + 1 - j)), square)
            square = fma(-one, load(series, (SLIDE, k + 1 - j)), square)
        store(series, (WORK, k + 1), work * scale)
        store(series, (SLIDE, k + 1), square * half)


@no_refcount_kernel
def sliding_span(series, rate, tolerance):
    """Compute the length in t over which the truncated series stays within a tolerance.

    ``tolerance`` is that of the velocities. ``rate``, positive, bounds |u'| / |u|: if time is
    measured in units of 1 / rate, neighbouring coefficients are of similar size.
    """
    last, before = last_terms(series, SLIDE_X)
    size = maximum(last, before * rate)
    measured = size > TINY
    share = tolerance / select(measured, size, 1.0)
    # a length of at most 1 / rate keeps the bound valid where both terms happen to be small
    span = exponential(logarithm(maximum(share, TINY)) * (1.0 / ORDER))
    return select(measured, minimum(1.0 / rate, span), 1.0 / rate)


@no_refcount_kernel
def store_line(series, velocity, rates, turns):
    """Write a straight piece with the rates of u, v, w in s; lanes ``turns`` are not changed."""
    for row in range(6):
        for k in range(1, ORDER + 1):
            store(series, (row, k), select(turns, load(series, (row, k)), 0.0))
    none = 0.0 * rates[1]
    first = rates[0], rates[2], none, none + 1.0, rates[1], velocity[1]
    for row in range(6):
        store(series, (row, 1), select(turns, load(series, (row, 1)), first[row]))
    half = select(turns, load(series, (WORK, 2)), 0.5 * rates[1])
    store(series, (WORK, 2), half)


@no_refcount_inline_kernel
def change_on_piece(series, row, t):
    """Compute the change of a row from the start of the piece to t."""
    value = load(series, (row, ORDER))
    for k in range(ORDER - 1, 0, -1):
        value = fma(value, t, load(series, (row, k)))
    return value * t


@no_refcount_inline_kernel
def slope_on_piece(series, row, t):
    """Differentiate a row by the variable of the piece."""
    value = load(series, (row, ORDER)) * ORDER
    for k in range(ORDER - 1, 0, -1):
        value = fma(value, t, load(series, (row, k)) * k)
    return value
