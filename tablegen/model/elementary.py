"""Exponential, logarithm, power, sine and cosine, for floats and lanes alike.

The library functions of C come one number at a time and differ between machines in the last bit;
these are polynomials, with the same bits everywhere. Errors are a few units in the last place,
far below those of the model.
"""

from tablegen.model.float_bits import power_of_two, split_exponent
from tablegen.model.jit import inline_kernel, kernel
from tablegen.model.simd import fma, maximum, select

_LOG2_E = 1.4426950408889634
#: log 2 in two parts: the first has 32 bits, so its product with an exponent is exact.
_LOG_2_HIGH = 0.6931471803691238
_LOG_2_LOW = 1.9082149292705877e-10
#: Adding and subtracting it rounds to an integer.
_ROUNDER = 6755399441055744.0
#: Logarithm of the least normal number; below it, numbers lose their digits.
_LEAST_LOGARITHM = -708.0
_ROOT_HALF = 0.7071067811865476


@inline_kernel
def nearest_integer(x):
    """Nearest integer, for |x| < 2^51."""
    return (x + _ROUNDER) - _ROUNDER


@kernel
def exponential(x):
    """e^x for x <= 709; below -708, where floats lose their digits, e^-708."""
    x = maximum(x, _LEAST_LOGARITHM)
    k = nearest_integer(x * _LOG2_E)
    r = fma(k, -_LOG_2_LOW, fma(k, -_LOG_2_HIGH, x))
    # Taylor's series: |r| <= log(2) / 2, the first term left out is 4e-18
    p = fma(r, 1.0 / 6227020800.0, 1.0 / 479001600.0)
    p = fma(p, r, 1.0 / 39916800.0)
    p = fma(p, r, 1.0 / 3628800.0)
    p = fma(p, r, 1.0 / 362880.0)
    p = fma(p, r, 1.0 / 40320.0)
    p = fma(p, r, 1.0 / 5040.0)
    p = fma(p, r, 1.0 / 720.0)
    p = fma(p, r, 1.0 / 120.0)
    p = fma(p, r, 1.0 / 24.0)
    p = fma(p, r, 1.0 / 6.0)
    p = fma(p, r, 0.5)
    p = fma(p * r, r, r)
    return (1.0 + p) * power_of_two(k)


@kernel
def logarithm(x):
    """Natural logarithm of a positive normal number."""
    m, e = split_exponent(x)
    low = m < _ROOT_HALF
    m = select(low, m + m, m)
    e = select(low, e - 1.0, e)
    # log m = 2 artanh f, |f| <= 0.172
    f = (m - 1.0) / (m + 1.0)
    s = f * f
    p = fma(s, 1.0 / 23.0, 1.0 / 21.0)
    p = fma(p, s, 1.0 / 19.0)
    p = fma(p, s, 1.0 / 17.0)
    p = fma(p, s, 1.0 / 15.0)
    p = fma(p, s, 1.0 / 13.0)
    p = fma(p, s, 1.0 / 11.0)
    p = fma(p, s, 1.0 / 9.0)
    p = fma(p, s, 1.0 / 7.0)
    p = fma(p, s, 0.2)
    p = fma(p, s, 1.0 / 3.0)
    tail = fma(f + f, p * s, e * _LOG_2_LOW)
    return fma(e, _LOG_2_HIGH, (f + f) + tail)


@inline_kernel
def power(x, y):
    """x^y for x positive and normal; its relative error is that of y log x."""
    return exponential(y * logarithm(x))


@kernel
def sine_and_cosine(turns):
    """Sine and cosine of 2 pi ``turns``, for 0 <= turns <= 1."""
    quarter = nearest_integer(4.0 * turns)
    t = 6.283185307179586 * fma(quarter, -0.25, turns)
    s = t * t
    # Taylor's series: |t| <= pi / 4, the first terms left out are 5e-17
    p = fma(s, -1.0 / 1307674368000.0, 1.0 / 6227020800.0)
    p = fma(p, s, -1.0 / 39916800.0)
    p = fma(p, s, 1.0 / 362880.0)
    p = fma(p, s, -1.0 / 5040.0)
    p = fma(p, s, 1.0 / 120.0)
    p = fma(p, s, -1.0 / 6.0)
    sine = fma(p * s, t, t)
    q = fma(s, 1.0 / 20922789888000.0, -1.0 / 87178291200.0)
    q = fma(q, s, 1.0 / 479001600.0)
    q = fma(q, s, -1.0 / 3628800.0)
    q = fma(q, s, 1.0 / 40320.0)
    q = fma(q, s, -1.0 / 720.0)
    q = fma(q, s, 1.0 / 24.0)
    cosine = fma(q * s, s, fma(s, -0.5, 1.0))
    odd = (quarter == 1.0) | (quarter == 3.0)
    first, second = select(odd, cosine, sine), select(odd, sine, cosine)
    falls = (quarter == 2.0) | (quarter == 3.0)
    left = (quarter == 1.0) | (quarter == 2.0)
    return select(falls, -first, first), select(left, -second, second)
