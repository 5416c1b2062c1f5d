"""Words of different (seed, index, hit) against a battery of statistical tests, dieharder.

A flow code asks for words in orders that a sequential generator never sees: neighbouring particles,
successive hits of one particle, neighbouring seeds. Each order is written as one stream and tested.
dieharder is a package of most systems (apt-get install dieharder); without it the study is skipped.

A right generator gives p-values that are uniform. One below 1e-7 or above 1 - 1e-7 is refused: with
some 400 of them, false alarms have a probability below 1e-4.
"""

import re
import shutil
import subprocess

import numba
import numpy as np
import pytest
from sampler.compilation.jit import kernel
from sampler.drawing.philox import philox_block

# called from Python here
philox_block = kernel(philox_block)

#: Tests that dieharder calls good, by number.
BATTERY = (0, 1, 2, 3, 4, 8, 9, 10, 11, 12, 13, 15, 16, 100, 101, 102, 202, 205, 206, 207, 209)
LIMIT = 1e-7

#: Draws written at once.
_CHUNK = 1 << 18

needs_dieharder = pytest.mark.skipif(
    shutil.which("dieharder") is None, reason="needs dieharder (apt-get install dieharder)"
)


@numba.njit
def _fill(words, start, step_seed, step_index, step_hit, wrong):
    """Write blocks 0 and 1 of draws start, start + 1, ... along one of the keys."""
    for k in range(words.shape[0]):
        n = start + k
        index = np.uint64(12345 + step_index * n)
        if wrong:  # a counter that lost its carry: it repeats after 2^16 particles
            index &= np.uint64(0xFFFF)
        for block in range(2):
            found = philox_block(
                np.uint64(7 + step_seed * n), index, np.uint32(step_hit * n), np.uint32(block)
            )
            for j in range(4):
                words[k, 4 * block + j] = found[j]


ORDERS = {
    "neighbouring particles": (0, 1, 0),
    "successive hits": (0, 0, 1),
    "neighbouring seeds": (1, 0, 0),
    "particles far apart": (0, 1 << 32, 0),
    "all three": (1, 1, 1),
}


def _p_values(test, steps, wrong=False):
    """P-values of one test of the battery on one stream."""
    command = ["dieharder", "-g", "200", "-d", str(test), "-D", "pvalues", "-D", "test_name"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as process:
        words = np.empty((_CHUNK, 8), dtype=np.uint32)
        start = 0
        try:
            while process.poll() is None:
                _fill(words, start, *steps, wrong)
                process.stdin.write(words.tobytes())
                start += _CHUNK
        except BrokenPipeError:
            pass  # it has enough
        text = process.stdout.read().decode()
    return [float(p) for p in re.findall(r"\|\s*([01]\.\d+)\s*(?:\||$)", text, re.MULTILINE)]


@pytest.mark.study
@needs_dieharder
@pytest.mark.parametrize("order", ORDERS)
def test_battery(order):
    found = {test: _p_values(test, ORDERS[order]) for test in BATTERY}
    assert all(found.values())
    refused = {test: p for test, p in found.items() if min(p) < LIMIT or max(p) > 1.0 - LIMIT}
    assert not refused


@pytest.mark.study
@needs_dieharder
def test_battery_refuses_a_lost_carry():
    p = _p_values(207, ORDERS["neighbouring particles"], wrong=True)
    p += _p_values(100, ORDERS["neighbouring particles"], wrong=True)
    assert min(p) < LIMIT or max(p) > 1.0 - LIMIT
