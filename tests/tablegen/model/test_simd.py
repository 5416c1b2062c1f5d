"""Lanes: every operation gives the same as floats, lane by lane."""

import math

import numba
import numpy as np
import pytest

from tablegen.model.elementary import power_of_two, split_exponent
from tablegen.model.simd import (
    WIDTH,
    any_lane,
    fma,
    load,
    logical_not,
    maximum,
    minimum,
    select,
    sqrt,
    store,
)

pytestmark = pytest.mark.processor


@numba.njit(error_model="numpy")
def operations(a, b, out):
    """Twenty results of two numbers, floats or lanes."""
    x, y = load(a, 0), load(b, 0)
    store(out, 0, x + y)
    store(out, 1, x - y)
    store(out, 2, x * y)
    store(out, 3, x / y)
    store(out, 4, -x)
    store(out, 5, fma(x, y, 3.0))
    store(out, 6, sqrt(x))
    store(out, 7, abs(x))
    store(out, 8, minimum(x, y))
    store(out, 9, maximum(x, y))
    store(out, 10, select(x < y, x, 7.0))
    store(out, 11, select(x <= y, 1.0, y))
    store(out, 12, select((x > y) | (x >= 2.0), x, 0.0))
    store(out, 13, select((x == y) & logical_not(x < 0.0), 1.0, 2.0))
    store(out, 14, 2.0 * x + 1)
    store(out, 15, 1.0 / x)
    mantissa, exponent = split_exponent(abs(x) + 1e-3)
    store(out, 16, mantissa)
    store(out, 17, exponent)
    store(out, 18, power_of_two(exponent))
    total = 0.0
    for _ in range(3):
        total += x
    store(out, 19, total)


SPECIAL = [0.0, -0.0, 1.0, -2.5, math.inf, -math.inf, math.nan, 1e-310, 5.0, 5.0]


@pytest.fixture(scope="module")
def pairs():
    rng = np.random.default_rng(2)
    a = np.concatenate([np.repeat(SPECIAL, len(SPECIAL)), rng.normal(size=300)])
    b = np.concatenate([np.tile(SPECIAL, len(SPECIAL)), rng.normal(size=300)])
    return a, b


def test_operations_on_lanes_are_those_on_floats(pairs):
    a, b = pairs
    for start in range(0, len(a) - WIDTH, WIDTH):
        part = slice(start, start + WIDTH)
        wide = np.empty((20, WIDTH))
        operations(a[None, part].copy(), b[None, part].copy(), wide)
        for i in range(WIDTH):
            alone = np.empty(20)
            operations(a[start + i : start + i + 1], b[start + i : start + i + 1], alone)
            np.testing.assert_array_equal(wide[:, i], alone)


def test_a_sum_is_fused_where_it_says_so_and_nowhere_else():
    @numba.njit
    def both(x, y, z):
        return fma(x, y, z), x * y + z

    x = 1.0 + 2.0**-30
    fused, apart = both(x, x, -1.0)
    assert apart == 2.0**-29
    assert fused == 2.0**-29 + 2.0**-60


def test_comparisons_with_no_number_are_false():
    @numba.njit
    def compare(x):
        return (
            any_lane(x < 1.0),
            any_lane(x >= 1.0),
            any_lane(x == x),
            any_lane(logical_not(x < 1.0)),
        )

    assert compare(math.nan) == (False, False, False, True)
