"""Cosine and sine with the same bits on every machine.

The C library's differ between processors in the last bit, where it is a close call which of two
numbers is nearer. These are summed in pairs of floats, of which the second holds what the first
rounds away, to 2^-100 of the value: the nearer number, but for one angle in 10^13 or so, and the
same one everywhere, because nothing but IEEE operations is used.
"""

from fractions import Fraction
from math import factorial

from tablegen.model.jit import inline_kernel, kernel
from tablegen.model.simd import fma, select

#: Terms of the series in pairs of floats; of later ones floats hold enough digits.
_PAIRS = 9

#: Terms of the series: the first one left out is 1e-34 of the value at pi / 4.
_TERMS = 15


def _pair(value: Fraction) -> tuple[float, float]:
    """Nearest float, and the nearest to what it leaves."""
    high = float(value)
    return high, float(value - Fraction(high))


#: Coefficients of the cosine, and of the sine over its angle, in powers of the square of the angle.
_COSINE = tuple(_pair(Fraction((-1) ** k, factorial(2 * k))) for k in range(_TERMS))
_SINE = tuple(_pair(Fraction((-1) ** k, factorial(2 * k + 1))) for k in range(_TERMS))

#: Half of pi as the sum of three floats.
_HALF_PI = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33)


@inline_kernel
def _sum(a, b):
    """Nearest float to the sum of two, and what is rounded away."""
    total = a + b
    from_b = total - a
    return total, (a - (total - from_b)) + (b - from_b)


@inline_kernel
def _product(a, b):
    """Product of two pairs."""
    high = a[0] * b[0]
    low = fma(a[0], b[1], fma(a[1], b[0], fma(a[0], b[0], -high)))
    total = high + low
    return total, low - (total - high)


@inline_kernel
def _plus(a, b):
    """Sum of two pairs, of which the second is not the larger one."""
    high, low = _sum(a[0], b[0])
    low += a[1] + b[1]
    total = high + low
    return total, low - (total - high)


@inline_kernel
def _polynomial(coefficients, square):
    """Series in a pair, for a pair."""
    tail = 0.0
    for k in range(_TERMS - 1, _PAIRS - 1, -1):
        tail = fma(tail, square[0], coefficients[k][0])
    value = tail, 0.0
    for k in range(_PAIRS - 1, -1, -1):
        value = _plus(coefficients[k], _product(square, value))
    return value


@kernel
def cosine_and_sine(angle):
    """Cosine and sine, rounded correctly, of one angle or of lanes (see `tablegen.model.simd`).

    Parameters
    ----------
    angle : float
        From 0 to pi / 2 [rad].

    Returns
    -------
    tuple of two floats
    """
    steep = angle > 0.5 * _HALF_PI[0]
    # the first difference is exact where the angle is steep
    high, low = _sum(_HALF_PI[0] - angle, _HALF_PI[1])
    high, low = _sum(high, low + _HALF_PI[2])
    t = select(steep, high, angle), select(steep, low, 0.0)
    square = _product(t, t)
    cosine = _polynomial(_COSINE, square)[0]
    sine = _product(t, _polynomial(_SINE, square))[0]
    return select(steep, sine, cosine), select(steep, cosine, sine)
