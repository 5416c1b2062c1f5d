"""Coulomb friction at an instant of a collision: how a contact slides, rests and slides anew.

While a contact slides with the tangential velocity u, it follows in the normal impulse s

    du/ds = A_tn - mu_d A_tt u / |u| = -A_tt grad(mu_d |u| - b . u),    b = A_tt^-1 A_tn,

with the mobility A. The bracket is convex, so two solutions never part in the metric of A_tt^-1:
the path is unique, and errors made on the way do not grow. From rest the contact

- sticks where the impulse that holds it lies within the static cone, |b| <= mu_s: dS_t/ds = -b,
  which does not change any more;
- else slides anew, along the one direction e in which sliding from rest keeps its direction,
  A_tn - mu_d A_tt e = f e with f > 0.

Every kernel takes the numbers of one particle or of lanes (see `tablegen.model.simd`).
"""

from typing import NamedTuple

from tablegen.model.jit import inline_kernel, no_refcount_kernel
from tablegen.model.simd import any_lane, logical_not, maximum, select, sqrt

#: Turning of a slide that counts as none, and slide that counts as rest, over the contact speed.
#: Errors of the pieces of a path add up and do not grow.
PATH_TOLERANCE = 1e-13

#: Normal impulse over the contact speed that no collision reaches: energy cannot grow, and the
#: mobility is at least one, so that 2 is the most.
REACH = 3.0

#: Relative Newton step that is rounding.
ROUNDING = 1e-14


class Friction(NamedTuple):
    """Coefficients of friction: static, which holds a contact at rest, and dynamic."""

    static: float
    dynamic: float


class Line(NamedTuple):
    """Straight piece of a path: rates in s, of (u, v, w); its length; whether it leads to rest."""

    rates: tuple[float, float, float]
    length: float
    stops: bool


@inline_kernel
def static_pull(mobility):
    """Tangential impulse over the normal one, less its sign, that holds a contact: A_tt^-1 A_tn."""
    axx, axy, axz, _, ayz, azz = mobility
    det = axx * azz - axz * axz
    return (azz * axy - axz * ayz) / det, (axx * ayz - axz * axy) / det


@no_refcount_kernel
def slip_direction(friction, mobility, where):
    """Direction in which a contact at rest begins to slide, and keeps sliding.

    It is e = p / |p| with (mu A_tt + f) p = A_tn and |p| = 1, whose f > 0 is the rate of |u|. The
    length of p falls with f from |A_tt^-1 A_tn| / mu > 1, so there is one; Newton's method for
    1 / |p|, which is concave in f, climbs to it from below.

    Parameters
    ----------
    friction : float
        Dynamic coefficient mu.
    mobility : tuple of six floats
    where : bool
        Lanes in which |A_tt^-1 A_tn| > mu.
    """
    axx, axy, axz, _, ayz, azz = mobility
    # below the root, and above zero without friction
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
        # in this form a NaN ends the search
        where = where & (step > ROUNDING * rate)
    length = sqrt(x * x + z * z)
    return x / length, z / length


@no_refcount_kernel
def straight_piece(friction, mobility, velocity, size):
    """Straight piece from the present contact velocity, and whether the contact turns instead.

    A slide is straight where its turning, at most the rate |du_perp/ds|, cannot carry it further
    than the tolerance from the line: solutions do not part.

    Returns
    -------
    tuple (Line, bool)
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
    turns = logical_not(rests) & (abs(across) * length > PATH_TOLERANCE * size)
    return Line((along * e_x, rate_v, along * e_z), length, stops), turns
