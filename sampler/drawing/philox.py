"""Counter-based random numbers: Philox4x32-10.

A block of four 32-bit words is a pure function of a 64-bit key and a 128-bit counter, so any
draw can be repeated from its keys alone, in any order, on any thread.

Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC'11.
"""

import numpy as np

from sampler.compilation.jit import inline_kernel

_M0 = np.uint64(0xD2511F53)
_M1 = np.uint64(0xCD9E8D57)
_W0 = np.uint32(0x9E3779B9)
_W1 = np.uint32(0xBB67AE85)
_LOW = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)

#: Width of one step of a 32-bit uniform number.
_STEP = 2.0**-32


@inline_kernel
def philox4x32(key0, key1, c0, c1, c2, c3):
    """Ten rounds of Philox4x32.

    Parameters
    ----------
    key0, key1 : uint32
        Low and high half of the key.
    c0, c1, c2, c3 : uint32
        Counter words.

    Returns
    -------
    tuple of four uint32
    """
    for _ in range(10):
        p0 = _M0 * np.uint64(c0)
        p1 = _M1 * np.uint64(c2)
        hi0, lo0 = np.uint32(p0 >> _HALF), np.uint32(p0 & _LOW)
        hi1, lo1 = np.uint32(p1 >> _HALF), np.uint32(p1 & _LOW)
        c0 = np.uint32(hi1 ^ c1 ^ key0)
        c1 = lo1
        c2 = np.uint32(hi0 ^ c3 ^ key1)
        c3 = lo0
        key0 = np.uint32(key0 + _W0)
        key1 = np.uint32(key1 + _W1)
    return c0, c1, c2, c3


@inline_kernel
def philox_block(seed, index, hit, block):
    """Block of four words for the keys of a rebound.

    The key is the seed; the counter is (index low, index high, hit, block).

    Parameters
    ----------
    seed, index : uint64
    hit, block : uint32

    Returns
    -------
    tuple of four uint32
    """
    s = np.uint64(seed)
    i = np.uint64(index)
    return philox4x32(
        np.uint32(s & _LOW),
        np.uint32(s >> _HALF),
        np.uint32(i & _LOW),
        np.uint32(i >> _HALF),
        np.uint32(hit),
        np.uint32(block),
    )


@inline_kernel
def uniform(word):
    """Uniform number in the open interval (0, 1): (word + 1/2) 2**-32.

    The smallest value is 2**-33 and the largest 1 - 2**-33; neither end can come out.
    """
    return (np.float64(word) + 0.5) * _STEP
