"""Python gives the states of the known-answer vectors, from the table and from its image."""

from pathlib import Path

import numpy as np
import pytest
from small_tables import SMALL_TABLES

from sampler.arrange import table_arrays
from sampler.frames import rebound
from sampler.image import read_image
from sampler.kernel import draw
from sampler.schema import read_table

VECTORS = Path(__file__).resolve().parents[1] / "vectors"


def read_cases(name):
    """Cases of a file: kind, given numbers, keys, code, expected numbers."""
    for line in (VECTORS / f"{name}.txt").read_text(encoding="ascii").splitlines():
        kind, *words = line.split()
        n = 2 if kind == "draw" else 10
        given = [float.fromhex(word) for word in words[:n]]
        seed, index, hit, code = (int(word) for word in words[n : n + 4])
        keys = np.uint64(seed), np.uint64(index), np.uint32(hit)
        yield kind, given, keys, code, [float.fromhex(word) for word in words[n + 4 :]]


def result_of(arrays, kind, given, keys):
    if kind == "draw":
        out = np.zeros(8)
        return draw(arrays, *given, *keys, out), out
    out = np.zeros(6)
    v, n, a, wall = tuple(given[:3]), tuple(given[3:6]), given[6], tuple(given[7:])
    code = rebound(arrays, v, n, a, wall, *keys, out)
    return code, out if code >= 0 else np.zeros(6)


def check(arrays, name, tolerance):
    codes = set()
    for kind, given, keys, code, expected in read_cases(name):
        got, values = result_of(arrays, kind, given, keys)
        codes.add(code)
        assert got == code
        # rebounds call atan2, cos and sin of the C library, which differ in the last digits
        allowed = max(tolerance, 1e-13 if kind == "rebound" else 0.0)
        np.testing.assert_allclose(
            values[:3], expected[:3], rtol=0, atol=allowed * size(expected[:3])
        )
        np.testing.assert_allclose(
            values[3:], expected[3:], rtol=0, atol=allowed * size(expected[3:])
        )
    assert codes == {0, 1, -1, -2, -3, -4, -5}


def size(values):
    return max(1.0, *np.abs(values))


@pytest.mark.parametrize("name", SMALL_TABLES)
def test_same_bits_from_the_image(name):
    check(read_image(VECTORS / f"{name}.rbt").arrays, name, 0.0)


@pytest.mark.parametrize("name", SMALL_TABLES)
def test_states_from_the_table(name):
    # its normal numbers are computed on this machine, and may differ in the last digit
    check(table_arrays(read_table(VECTORS / f"{name}.h5")), name, 1e-12)


def test_a_wrong_table_gives_other_states():
    with pytest.raises(AssertionError):
        check(read_image(VECTORS / "plane.rbt").arrays, "full", 1e-2)


@pytest.mark.parametrize("name", SMALL_TABLES)
def test_tables_are_those_of_the_script(name):
    assert read_table(VECTORS / f"{name}.h5").content_sha256 == SMALL_TABLES[name]().content_sha256
