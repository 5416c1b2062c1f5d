"""Random numbers from keys: Philox4x32-10 and the standard normal quantile.

A block of four 32-bit words is a pure function of a 64-bit key and a 128-bit counter. So any number
can be computed again from its keys, in any order and on any thread.

Sources: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC'11.
Wichura, "The percentage points of the normal distribution", Appl. Statist. 37 (1988): algorithm
AS 241, routine PPND16, relative error about 1e-16.
"""

import math

import numpy as np

from tablegen.model.jit import inline_kernel, kernel

_M0, _M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_W0, _W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
_ROUNDS = 10

#: Distance of a probability from 1/2 up to which `central_ratio` gives the quantile.
MIDDLE = 0.425


@inline_kernel
def philox_block(seed, index, hit, block):
    """Compute a block of four words, uint32, for the keys of a rebound.

    The key is the seed; the counter is (index low, index high, hit, block).
    """
    key, i = np.uint64(seed), np.uint64(index)
    key0, key1 = key & _LOW, key >> _HALF
    # the words are in the lower halves of 64 bits; the upper halves do not matter
    c0, c1, c2, c3 = i, i >> _HALF, np.uint64(np.uint32(hit)), np.uint64(block)
    for number in range(_ROUNDS):
        k = np.uint64(number)
        p0, p1 = (c0 & _LOW) * _M0, (c2 & _LOW) * _M1
        c0, c1, c2, c3 = (
            (p1 >> _HALF) ^ c1 ^ (key0 + k * _W0),
            p1,
            (p0 >> _HALF) ^ c3 ^ (key1 + k * _W1),
            p0,
        )
    return np.uint32(c0), np.uint32(c1), np.uint32(c2), np.uint32(c3)


@inline_kernel
def uniform(word):
    """Convert a word to a uniform number in the open interval (0, 1): (word + 1/2) 2**-32."""
    return (np.float64(word) + 0.5) * 2.0**-32


@inline_kernel
def central_ratio(r):
    """Compute the quantile over p - 1/2, in r = 0.180625 - (p - 1/2)^2.

    It holds for |p - 1/2| up to `MIDDLE`.
    """
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
    """Compute the size of the quantile in a tail, in r = sqrt(-log(min(p, 1 - p)))."""
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
    """Compute the standard normal quantile of p in the open interval (0, 1)."""
    q = p - 0.5
    if abs(q) <= MIDDLE:
        return q * central_ratio(0.180625 - q * q)
    if q < 0.0:
        return -_tail(math.sqrt(-math.log(p)))
    return _tail(math.sqrt(-math.log(1.0 - p)))


@kernel
def normal_cdf(x):
    """Compute the standard normal distribution function."""
    return 0.5 * math.erfc(-x * 0.7071067811865476)
