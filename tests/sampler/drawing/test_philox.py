"""Philox4x32-10 against the known-answer vectors that were published with it (Random123)."""

import numpy as np
import pytest
from reference_draw import philox
from sampler.compilation.jit import kernel
from sampler.drawing.philox import philox_block, uniform

# called from Python here
philox_block = kernel(philox_block)
uniform = kernel(uniform)

VECTORS = [
    ("00000000 00000000", "00000000 " * 4, "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff", "ffffffff " * 4, "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    (
        "a4093822 299f31d0",
        "243f6a88 85a308d3 13198a2e 03707344",
        "d16cfe09 94fdcceb 5001e420 24126ea1",
    ),
]


def _words(text):
    return [int(word, 16) for word in text.split()]


@pytest.mark.parametrize(("key", "counter", "answer"), VECTORS)
def test_known_answers(key, counter, answer):
    """The key is the seed; the counter is (index low, index high, hit, block)."""
    key, counter, answer = _words(key), _words(counter), _words(answer)
    seed, index = np.uint64(key[0] | key[1] << 32), np.uint64(counter[0] | counter[1] << 32)
    words = philox_block(seed, index, np.uint32(counter[2]), np.uint32(counter[3]))
    assert [int(word) for word in words] == answer
    # the specification must pass as well, or it proves nothing elsewhere
    assert philox(key, counter) == answer


def test_python_integers_serve_as_keys():
    typed = philox_block(np.uint64(7), np.uint64(2**40), np.uint32(3), np.uint32(0))
    assert philox_block(7, 2**40, 3, 0) == typed


@pytest.mark.parametrize(
    ("word", "value"),
    [(0, 2.0**-33), (1, 1.5 * 2.0**-32), (2**31, 0.5 + 2.0**-33), (2**32 - 1, 1.0 - 2.0**-33)],
)
def test_uniform_never_reaches_its_ends(word, value):
    assert uniform(np.uint32(word)) == value
    assert 0.0 < uniform(np.uint32(word)) < 1.0
