"""Sliding of a contact under Coulomb friction, as a Taylor series.

While a contact slides with the tangential velocity u, the impulse grows along n - mu u / |u|, with
the wall normal n. With the mobility A of the contact and the normal impulse s,

    du/ds = A_tn - mu A_tt u / |u|,    dv/ds = A_nn - mu A_tn . u / |u|,    dw/ds = v,

where v is the normal velocity and w the work of the normal impulse. The direction of u turns, and
these equations have a closed form only up to a quadrature. In the variable t with ds = |u| dt they
lose the quotients,

    u' = A_tn |u| - mu A_tt u,   s' = |u|,   v' = A_nn |u| - mu A_tn . u,   w' = |u| v,

and every Taylor coefficient follows from those before it by one convolution an order. As in
`tablegen.model.rotation` the series is its own dense output.

A piece of the path of an impulse is the polynomials of u, s, v and w in one variable: this series,
or a straight line in s. Every kernel takes the arrays of one particle or of lanes (see
`tablegen.model.simd`).
"""

from tablegen.model.elementary import exponential, logarithm
from tablegen.model.jit import no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.rotation import ORDER, TINY
from tablegen.model.simd import fma, load, maximum, minimum, select, sqrt, store

#: Rows of the coefficients: the tangential velocity, its modulus, the normal impulse, the normal
#: velocity, the work of the normal impulse.
SLIDE_X, SLIDE_Z, SLIDE, IMPULSE, NORMAL_VELOCITY, WORK = range(6)


@no_refcount_kernel
def expand_sliding(friction, mobility, velocity, series):
    """Taylor coefficients of a sliding contact in t; those of order 0 of s and w are not written.

    Parameters
    ----------
    friction : float
        Dynamic coefficient mu.
    mobility : tuple of six floats
        A_xx, A_xy, A_xz, A_yy, A_yz, A_zz of dV_c = A dV_p.
    velocity : tuple of three floats
        Of the contact, (u, v, w) in wall axes; (u, w) not zero.
    series : (9, ORDER + 1) float64
        Rows 0 to 5 are written.
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
    """Length in t over which the truncated series stays within the tolerance.

    Parameters
    ----------
    series : (9, ORDER + 1) float64
    rate : float
        A bound on |u'| / |u|, positive; in units of it neighbouring coefficients are alike.
    tolerance : float
        Of the velocities.
    """
    last = maximum(abs(load(series, (SLIDE_X, ORDER))), abs(load(series, (SLIDE_Z, ORDER))))
    last = maximum(last, abs(load(series, (SLIDE, ORDER))))
    before = maximum(
        abs(load(series, (SLIDE_X, ORDER - 1))), abs(load(series, (SLIDE_Z, ORDER - 1)))
    )
    before = maximum(before, abs(load(series, (SLIDE, ORDER - 1))))
    size = maximum(last, before * rate)
    measured = size > TINY
    share = tolerance / select(measured, size, 1.0)
    # one over the rate keeps the bound honest where these terms happen to be small
    span = exponential(logarithm(maximum(share, TINY)) * (1.0 / ORDER))
    return select(measured, minimum(1.0 / rate, span), 1.0 / rate)


@no_refcount_kernel
def put_line(series, velocity, rates, turns):
    """Write a straight piece in s, but in lanes that turn.

    Parameters
    ----------
    series : (9, ORDER + 1) float64
    velocity : tuple of three floats
    rates : tuple of three floats
        Of u, v, w in s, which are constant.
    turns : bool
        Lanes that keep the series that they have.
    """
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
def gained(series, row, t):
    """Change of a row from the start of the piece to t."""
    value = load(series, (row, ORDER))
    for k in range(ORDER - 1, 0, -1):
        value = fma(value, t, load(series, (row, k)))
    return value * t


@no_refcount_inline_kernel
def slope(series, row, t):
    """Differentiate a row by the variable of the piece."""
    value = load(series, (row, ORDER)) * ORDER
    for k in range(ORDER - 1, 0, -1):
        value = fma(value, t, load(series, (row, k)) * k)
    return value
