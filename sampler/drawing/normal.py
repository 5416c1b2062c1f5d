"""Standard normal quantile function: exact, and as cubics for the draw.

`normal_quantile` is algorithm AS 241 (routine PPND16), relative error about 1e-16.
Source: Wichura, "The percentage points of the normal distribution", Appl. Statist. 37 (1988).

A draw takes six normals, so it uses cubics through that function instead, in single precision: on
every octave of the distance from the nearer end of (0, 1), eight pieces. They are within 1e-6 of
it, a two-hundredth of the rounding of the stored factors, need no logarithm and give the same bits
in every language.
"""

import math

import numpy as np

from sampler.compilation.jit import inline_kernel, kernel, no_refcount_inline_kernel
from sampler.drawing.intrinsics import single_bits, single_of_bits
from sampler.formats.image import PIECES

#: Exponent and first three bits of a float32, the number of its piece; that of 1/2.
_PIECE_SHIFT = np.uint32(20)
_FIRST_PIECE = np.int32(126 * PIECES)
_PIECE_BITS = np.uint32(3)
_MANTISSA = np.uint32(0x7FFFFF)
_ONE_BITS = np.uint32(0x3F800000)
#: Distance of a probability from 1/2 up to which `central_ratio` gives its quantile.
MIDDLE = 0.425

_ONE, _HALF, _TWO = np.float32(1.0), np.float32(0.5), np.float32(2.0)
_SIGN_SHIFT = np.uint32(31)
_DISTANCE = np.uint32(0x7FFFFFFF)


@inline_kernel
def central_ratio(r):
    """Numerator over denominator for |p - 1/2| <= 0.425, in r = 0.180625 - (p - 1/2)^2."""
    num = 2.5090809287301226727e3
    num = num * r + 3.3430575583588128105e4
    num = num * r + 6.7265770927008700853e4
    num = num * r + 4.5921953931549871457e4
    num = num * r + 1.3731693765509461125e4
    num = num * r + 1.9715909503065514427e3
    num = num * r + 1.3314166789178437745e2
    num = num * r + 3.3871328727963666080e0
    den = 5.2264952788528545610e3
    den = den * r + 2.8729085735721942674e4
    den = den * r + 3.9307895800092710610e4
    den = den * r + 2.1213794301586595867e4
    den = den * r + 5.3941960214247511077e3
    den = den * r + 6.8718700749205790830e2
    den = den * r + 4.2313330701600911252e1
    den = den * r + 1.0
    return num / den


@kernel
def _tail(r):
    """Quantile in the tail, in r = sqrt(-log(min(p, 1 - p)))."""
    if r <= 5.0:
        r -= 1.6
        num = 7.74545014278341407640e-4
        num = num * r + 2.27238449892691845833e-2
        num = num * r + 2.41780725177450611770e-1
        num = num * r + 1.27045825245236838258e0
        num = num * r + 3.64784832476320460504e0
        num = num * r + 5.76949722146069140550e0
        num = num * r + 4.63033784615654529590e0
        num = num * r + 1.42343711074968357734e0
        den = 1.05075007164441684324e-9
        den = den * r + 5.47593808499534494600e-4
        den = den * r + 1.51986665636164571966e-2
        den = den * r + 1.48103976427480074590e-1
        den = den * r + 6.89767334985100004550e-1
        den = den * r + 1.67638483018380384940e0
        den = den * r + 2.05319162663775882187e0
        den = den * r + 1.0
        return num / den
    r -= 5.0
    num = 2.01033439929228813265e-7
    num = num * r + 2.71155556874348757815e-5
    num = num * r + 1.24266094738807843860e-3
    num = num * r + 2.65321895265761230930e-2
    num = num * r + 2.96560571828504891230e-1
    num = num * r + 1.78482653991729133580e0
    num = num * r + 5.46378491116411436990e0
    num = num * r + 6.65790464350110377720e0
    den = 2.04426310338993978564e-15
    den = den * r + 1.42151175831644588870e-7
    den = den * r + 1.84631831751005468180e-5
    den = den * r + 7.86869131145613259100e-4
    den = den * r + 1.48753612908506148525e-2
    den = den * r + 1.36929880922735805310e-1
    den = den * r + 5.99832206555887937690e-1
    den = den * r + 1.0
    return num / den


@inline_kernel
def normal_quantile(p):
    """Return the standard normal quantile of p in the open interval (0, 1)."""
    q = p - 0.5
    if abs(q) <= MIDDLE:
        return q * central_ratio(0.180625 - q * q)
    if q < 0.0:
        return -_tail(math.sqrt(-math.log(p)))
    return _tail(math.sqrt(-math.log(1.0 - p)))


@kernel
def normal_cdf(x):
    """Evaluate the standard normal distribution function."""
    return 0.5 * math.erfc(-x * 0.7071067811865476)


@no_refcount_inline_kernel
def piece_of_word(word):
    """Row of the cubic of a random word, place in its piece, and sign.

    The octave is the exponent of a floating-point number, which unlike a count of leading zeros
    can be had for many words at a time. The number is rounded to 24 bits, which moves its quantile
    by less than 1e-7.
    """
    upper = np.int32(word >> _SIGN_SHIFT)
    mask = np.uint32(-upper)
    half = np.float32(np.int32((word ^ mask) & _DISTANCE)) + _HALF
    bits = single_bits(half)
    row = np.int32(bits >> _PIECE_SHIFT) - _FIRST_PIECE
    t = single_of_bits(np.uint32(((bits << _PIECE_BITS) & _MANTISSA) | _ONE_BITS)) - _ONE
    return row, t, _ONE - _TWO * np.float32(upper)


@no_refcount_inline_kernel
def normal_of_word(table, word):
    """Give the standard normal number of a random word, the quantile of (word + 1/2) 2**-32.

    Parameters
    ----------
    table : float32 array, shape (257, 4)
        From `sampler.formats.image.normal_table`.
    word : uint32

    Returns
    -------
    float32
        Odd in the word: w and 2**32 - 1 - w give opposite numbers.
    """
    row, t, sign = piece_of_word(word)
    k = np.uint64(row)
    return sign * (table[k, 0] + t * (table[k, 1] + t * (table[k, 2] + t * table[k, 3])))
