"""Elementary functions with the same bits on every machine, for floats and lanes.

Nobody needs this file to change the physics.

The functions of the C library take one number at a time, and their last bit differs between
machines. `exponential`, `logarithm`, `power` and `sine_and_cosine` are polynomials with errors of a
few units in the last place. `cosine_and_sine`, for impact angles, is rounded correctly: its series
is summed in pairs of floats, a value and its rounding error, to 2^-100 of the value.
"""

from fractions import Fraction
from math import factorial

from llvmlite import ir
from numba import types

from tablegen.model.jit import inline_kernel, kernel, operation
from tablegen.model.simd import WIDTH, elementwise, fma, maximum, number_type, select

#: Integers with the bits of lanes.
_WORDS = ir.VectorType(ir.IntType(64), WIDTH)

#: Bits of the float 2^52.
_TWO_52 = 0x4330_0000_0000_0000


def _word_type(number):
    """Return the type of integers with the size and number of the given floats."""
    return _WORDS if isinstance(number.type, ir.VectorType) else ir.IntType(64)


def _constant(kind, value):
    """Make a constant of a type, in every lane."""
    return kind([value] * WIDTH) if isinstance(kind, ir.VectorType) else kind(value)


@operation
def split_exponent(typingctx, x):
    """Return m in [1/2, 1) and e, both numbers, with x = m 2^e, for x positive and normal."""
    kind = number_type(x)

    def generate(context, builder, sig, args):
        number = context.cast(builder, args[0], x, kind)
        word = _word_type(number)
        bits = builder.bitcast(number, word)
        # the bits of the exponent, put into the mantissa of 2^52, are a float without a conversion
        exponent = builder.or_(builder.lshr(bits, _constant(word, 52)), _constant(word, _TWO_52))
        exponent = builder.bitcast(exponent, number.type)
        exponent = builder.fsub(exponent, _constant(number.type, 2.0**52 + 1022.0))
        fraction = builder.and_(bits, _constant(word, (1 << 52) - 1))
        fraction = builder.or_(fraction, _constant(word, 1022 << 52))
        return context.make_tuple(
            builder, sig.return_type, (builder.bitcast(fraction, number.type), exponent)
        )

    return types.UniTuple(kind, 2)(x), generate


@operation
def power_of_two(typingctx, k):
    """Compute 2^k for an integer k from -1022 to 1023."""

    def emit(builder, number):
        word = _word_type(number)
        shifted = builder.fadd(number, _constant(number.type, 2.0**52 + 1023.0))
        bits = builder.shl(builder.bitcast(shifted, word), _constant(word, 52))
        return builder.bitcast(bits, number.type)

    return elementwise(emit, k)


_LOG2_E = 1.4426950408889634
#: log 2 in two parts. The first has 32 bits, so that its product with an exponent is exact.
_LOG_2_HIGH = 0.6931471803691238
_LOG_2_LOW = 1.9082149292705877e-10
#: Adding and subtracting this number rounds to an integer.
_ROUNDER = 6755399441055744.0
#: Logarithm of the least normal number; smaller numbers have fewer digits.
_LEAST_LOGARITHM = -708.0
_ROOT_HALF = 0.7071067811865476


#: Coefficients of Taylor's series, the highest order first: of e^r after r, |r| <= log(2) / 2, of
#: 2 artanh(f) over 2 f after 1, |f| <= 0.172, of the sine over t after 1 and of the cosine after
#: 1 - t^2 / 2, |t| <= pi / 4. The first terms left out are below 1e-16.
_EXPONENTIAL = tuple(1 / factorial(k) for k in range(13, 1, -1))
_LOGARITHM = tuple(1 / k for k in range(23, 1, -2))
_SINE_TURNS = tuple((-1) ** (k // 2) / factorial(k) for k in range(15, 1, -2))
_COSINE_TURNS = tuple((-1) ** (k // 2) / factorial(k) for k in range(16, 2, -2))


@inline_kernel
def _horner(coefficients, x):
    """Evaluate a polynomial in x, the coefficient of the highest power first."""
    value = fma(x, coefficients[0], coefficients[1])
    for k in range(2, len(coefficients)):
        value = fma(value, x, coefficients[k])
    return value


@inline_kernel
def nearest_integer(x):
    """Round to the nearest integer, for |x| < 2^51."""
    return (x + _ROUNDER) - _ROUNDER


@kernel
def exponential(x):
    """Compute e^x for x <= 709; for x below -708, where floats lose their digits, e^-708."""
    x = maximum(x, _LEAST_LOGARITHM)
    k = nearest_integer(x * _LOG2_E)
    r = fma(k, -_LOG_2_LOW, fma(k, -_LOG_2_HIGH, x))
    p = _horner(_EXPONENTIAL, r)
    p = fma(p * r, r, r)
    return (1.0 + p) * power_of_two(k)


@kernel
def logarithm(x):
    """Compute the natural logarithm of a positive normal number."""
    m, e = split_exponent(x)
    low = m < _ROOT_HALF
    m = select(low, m + m, m)
    e = select(low, e - 1.0, e)
    # log m = 2 artanh f, |f| <= 0.172
    f = (m - 1.0) / (m + 1.0)
    s = f * f
    p = _horner(_LOGARITHM, s)
    tail = fma(f + f, p * s, e * _LOG_2_LOW)
    return fma(e, _LOG_2_HIGH, (f + f) + tail)


@inline_kernel
def power(x, y):
    """Compute x^y for x positive and normal; the relative error is the error of y log x."""
    return exponential(y * logarithm(x))


@kernel
def sine_and_cosine(turns):
    """Compute sine and cosine of 2 pi ``turns``, for 0 <= turns <= 1."""
    quarter = nearest_integer(4.0 * turns)
    t = 6.283185307179586 * fma(quarter, -0.25, turns)
    s = t * t
    sine = fma(_horner(_SINE_TURNS, s) * s, t, t)
    cosine = fma(_horner(_COSINE_TURNS, s) * s, s, fma(s, -0.5, 1.0))
    odd = (quarter == 1.0) | (quarter == 3.0)
    first, second = select(odd, cosine, sine), select(odd, sine, cosine)
    falls = (quarter == 2.0) | (quarter == 3.0)
    left = (quarter == 1.0) | (quarter == 2.0)
    return select(falls, -first, first), select(left, -second, second)


#: Number of terms of the series in pairs of floats; for later terms floats have enough digits.
_PAIRS = 9

#: Number of terms of the series. The first term left out is 1e-34 of the value at pi / 4.
_TERMS = 15


def _pair(value: Fraction) -> tuple[float, float]:
    """Split a number into the nearest float and the float nearest to the difference."""
    high = float(value)
    return high, float(value - Fraction(high))


#: Coefficients of the cosine, and of the sine over its angle, in powers of the square of the angle.
_COSINE = tuple(_pair(Fraction((-1) ** k, factorial(2 * k))) for k in range(_TERMS))
_SINE = tuple(_pair(Fraction((-1) ** k, factorial(2 * k + 1))) for k in range(_TERMS))

#: pi / 2 as the sum of three floats.
_HALF_PI = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33)


@inline_kernel
def _exact_sum(a, b):
    """Add two floats; return the nearest float to the sum, and the rounding error."""
    total = a + b
    from_b = total - a
    return total, (a - (total - from_b)) + (b - from_b)


@inline_kernel
def _product_of_pairs(a, b):
    """Multiply two pairs."""
    high = a[0] * b[0]
    low = fma(a[0], b[1], fma(a[1], b[0], fma(a[0], b[0], -high)))
    total = high + low
    return total, low - (total - high)


@inline_kernel
def _sum_of_pairs(a, b):
    """Add two pairs, the second not larger than the first."""
    high, low = _exact_sum(a[0], b[0])
    low += a[1] + b[1]
    total = high + low
    return total, low - (total - high)


@inline_kernel
def _series_of_pairs(coefficients, square):
    """Evaluate a series in a pair."""
    tail = 0.0
    for k in range(_TERMS - 1, _PAIRS - 1, -1):
        tail = fma(tail, square[0], coefficients[k][0])
    value = tail, 0.0
    for k in range(_PAIRS - 1, -1, -1):
        value = _sum_of_pairs(coefficients[k], _product_of_pairs(square, value))
    return value


@kernel
def cosine_and_sine(angle):
    """Compute cosine and sine of an angle from 0 to pi / 2 [rad], rounded correctly."""
    steep = angle > 0.5 * _HALF_PI[0]
    # the first difference is exact where the angle is steep
    high, low = _exact_sum(_HALF_PI[0] - angle, _HALF_PI[1])
    high, low = _exact_sum(high, low + _HALF_PI[2])
    t = select(steep, high, angle), select(steep, low, 0.0)
    square = _product_of_pairs(t, t)
    cosine = _series_of_pairs(_COSINE, square)[0]
    sine = _product_of_pairs(t, _series_of_pairs(_SINE, square))[0]
    return select(steep, sine, cosine), select(steep, cosine, sine)
