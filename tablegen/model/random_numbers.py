"""Random words of 32 bits by keys, and uniform numbers from them.

The words are those of Philox4x32-10 (Salmon et al., SC11, 2011), which the draw in
`sampler/c/src/words.h` has too: grains and facets of rough walls are drawn there, phases of a
tumbling grain here.
"""

import numpy as np

from tablegen.model.jit import inline_kernel

_M0, _M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_W0, _W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
_ROUNDS = 10


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
