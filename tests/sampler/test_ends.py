"""Ends of ranges hold for their rounding to single precision, in Python and in compiled code.

A flow code in single precision computes a head-on angle as ``asinf(1)``, which is above pi/2.
An argument beyond an end by less than such a rounding counts as the end: no error and no flag.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import sampler
import sampler.numba
from sampler.errors import ANGLE, EXTRAPOLATED, GRAIN_NOT_KNOWN, NOT_APPROACHING, SPEED, SPIN
from sampler.formats.hdf5 import read_table

SPINNING = Path(__file__).resolve().parents[1] / "vectors" / "spin.h5"
UP, KEYS = (0.0, 1.0, 0.0), {"seed": 1, "index": 2, "hit": 0}

#: Factors within rounding to single precision, and beyond it.
WITHIN, BEYOND = 1.1e-7, 1.4e-7


@pytest.fixture
def strict():
    return sampler.load(SPINNING, outside="raise")


def draw(table, alpha1, speed, **given):
    """Code of a draw in compiled code."""
    out = np.empty(len(table.columns))
    return sampler.numba.sample(table.handle, float(alpha1), float(speed), **given, **KEYS, out=out)


def ends(table):
    """Ends of angles, rad, and of speeds, m/s, that lie apart from those that were measured."""
    (low, high), (slow, fast) = (
        np.radians(table.alpha_nodes_deg[[0, -1]]),
        table.speed_nodes[[0, -1]],
    )
    return low, high, slow, fast


def test_ends_in_single_precision_are_inside(strict):
    low, high, slow, fast = map(np.float32, ends(strict))
    for alpha1, speed in ((low, slow), (high, slow), (low, fast), (high, fast)):
        strict.sample(alpha1, speed, **KEYS)
        assert draw(strict, alpha1, speed) == 0
    assert not any(strict.counts.values())


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_ends_hold_for_a_rounding_and_no_more(strict, sign):
    low, high, slow, fast = ends(strict)
    alpha1, speed = (high, fast) if sign > 0.0 else (low, slow)
    expected = strict.sample(alpha1, speed, **KEYS)
    near = strict.sample(alpha1 * (1.0 + sign * WITHIN), speed * (1.0 + sign * WITHIN), **KEYS)
    np.testing.assert_array_equal(near, expected)
    assert draw(strict, alpha1 * (1.0 + sign * BEYOND), speed) == ANGLE
    code = draw(strict, alpha1, speed * (1.0 + sign * BEYOND))
    assert code & ~EXTRAPOLATED == SPEED


def test_measured_speeds_end_so_too(strict):
    least = strict.covered.measured[0]
    assert draw(strict, 0.7, least * (1.0 - WITHIN)) == 0
    assert draw(strict, 0.7, least * (1.0 - BEYOND)) & EXTRAPOLATED


def test_a_head_on_angle_of_single_precision(table):
    head_on = np.arcsin(np.float32(1.0))
    assert float(head_on) > 0.5 * math.pi
    expected = table.sample(0.5 * math.pi, 100.0, **KEYS)
    np.testing.assert_array_equal(table.sample(head_on, 100.0, **KEYS), expected)
    assert draw(table, head_on, 100.0) >= 0
    assert draw(table, 0.5 * math.pi * (1.0 + BEYOND), 100.0) == NOT_APPROACHING
    # in a block as well
    rows = np.full(32, head_on)
    given = {"seed": 1, "index": np.full(32, 2), "hit": np.zeros(32, int)}
    np.testing.assert_array_equal(table.sample(rows, 100.0, **given), np.tile(expected, (32, 1)))


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
def test_the_largest_spin(strict):
    (_, most), speed = strict.covered.spin, 1.01 * strict.speed_nodes[0]
    for count in (1, 32):  # singly and in a block
        given = KEYS | {"index": np.full(count, 2), "inertia": np.full(count, 0.3)}
        drawn = {}
        for factor in (1.0, 1.0 + WITHIN):
            table = sampler.load(SPINNING)
            spin = np.tile([0.0, 0.0, most * factor], (count, 1))
            drawn[factor] = table.sample(0.7, speed, spin=spin, **given)
            assert table.counts["spin"] == 0
        np.testing.assert_allclose(*drawn.values(), rtol=0, atol=1e-5)
    spin = (0.0, 0.0, most * (1.0 + BEYOND))
    assert draw(strict, 0.7, speed, spin=spin, inertia=0.3) & SPIN


def test_ratios_and_shapes(strict):
    spin = (0.0, 0.0, 1.0)
    (b_least, b_most), (c_least, c_most) = read_table(SPINNING)["spin/ratio_range"][0]
    rounded = (0.0, b_most * (1.0 + WITHIN), c_least * (1.0 - WITHIN))
    assert draw(strict, 0.7, 60.0, spin=spin, grain=rounded) == 0
    for b, c in (
        (b_least * (1.0 - BEYOND), c_most),
        (b_most * (1.0 + BEYOND), c_most),
        (b_most, c_least * (1.0 - BEYOND)),
        (b_most, c_most * (1.0 + BEYOND)),
    ):
        assert draw(strict, 0.7, 60.0, spin=spin, grain=(0.0, b, c)) == GRAIN_NOT_KNOWN
    given = {"spin": spin, **KEYS}
    for b, c in ((b_least, c_most), (b_most, c_least)):
        strict.sample(0.7, 60.0, grain=np.float32([0.0, b, c]), **given)
    refused("grain", strict.sample, 0.7, 60.0, grain=(0.0, b_least * (1.0 - BEYOND), 1.0), **given)
    assert sampler.sphericity(strict, rounded) == pytest.approx(
        sampler.sphericity(strict, (0.0, b_most, c_least))
    )
    refused("grain", sampler.sphericity, strict, (0.0, b_most * (1.0 + BEYOND), c_most))


def test_each_shape_and_each_ratio_has_its_own_range():
    ranges = [[[0.5, 0.7], [0.75, 1.0]], [[0.8, 1.0], [0.5, 0.6]]]
    contents = read_table(SPINNING)
    datasets = contents.datasets | {"spin/ratio_range": np.array(ranges)}
    table = sampler.Table(replace(contents, datasets=datasets), outside="raise")
    grains = [(shape, b, c) for shape in (0.0, 4.0) for b in (0.6, 0.9) for c in (0.55, 0.9)]
    codes = {g: draw(table, 0.7, 60.0, spin=(0.0, 0.0, 1.0), grain=g) for g in grains}
    assert [grain for grain in grains if codes[grain] == 0] == [(0.0, 0.6, 0.9), (4.0, 0.9, 0.55)]
    assert set(codes.values()) == {0, GRAIN_NOT_KNOWN}


def test_half_sizes_and_roughness(table):
    given = {"grain": "fresh", **KEYS}
    for half_size in (np.float32(1e-9), np.float32(100.0)):
        table.rebound((60.0, -80.0, 0.0), UP, half_size, **given)
    refused("half_size", table.rebound, (60.0, -80.0, 0.0), UP, 1e-9 * (1.0 - BEYOND), **given)
    table.rebound((60.0, -80.0, 0.0), UP, 1e-5, roughness=0.5 * (1.0 + WITHIN), **given)
