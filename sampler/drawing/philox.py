"""Counter-based random numbers: Philox4x32-10.

A block of four 32-bit words is a pure function of a 64-bit key and a 128-bit counter, so any
draw can be repeated from its keys alone, in any order, on any thread.

Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC'11.
"""

import numpy as np

from sampler.compilation.jit import inline_kernel

_M0, _M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_W0, _W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_LOW = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)

#: Width of one step of a 32-bit uniform number.
_STEP = 2.0**-32


#: Rounds of a block.
ROUNDS = 10


@inline_kernel
def philox_round(number, key0, key1, c0, c1, c2, c3):
    """One round of Philox4x32 on words in the lower halves of 64 bits.

    Products of such words need no conversion. What is in the upper halves of the counter does not
    matter, neither before nor after.

    Parameters
    ----------
    number : int
        Round, from 0 on.
    key0, key1 : uint64
        Low and high half of the key, each below 2**32.
    c0, c1, c2, c3 : uint64
        Counter, or what the round before returned.

    Returns
    -------
    tuple of four uint64
    """
    k = np.uint64(number)
    p0, p1 = (c0 & _LOW) * _M0, (c2 & _LOW) * _M1
    high0, high1 = p0 >> _HALF, p1 >> _HALF
    return high1 ^ c1 ^ (key0 + k * _W0), p1, high0 ^ c3 ^ (key1 + k * _W1), p0


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
    key, i = np.uint64(seed), np.uint64(index)
    key0, key1 = key & _LOW, key >> _HALF
    c0, c1, c2, c3 = i, i >> _HALF, np.uint64(np.uint32(hit)), np.uint64(block)
    for number in range(ROUNDS):
        c0, c1, c2, c3 = philox_round(number, key0, key1, c0, c1, c2, c3)
    return np.uint32(c0), np.uint32(c1), np.uint32(c2), np.uint32(c3)


@inline_kernel
def uniform(word):
    """Uniform number in the open interval (0, 1): (word + 1/2) 2**-32.

    The smallest value is 2**-33 and the largest 1 - 2**-33; neither end can come out.
    """
    return (np.float64(word) + 0.5) * _STEP
