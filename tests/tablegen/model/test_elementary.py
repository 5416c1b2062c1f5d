"""Elementary functions agree with the library or exact values, and are the same in lanes."""

import math
from decimal import Decimal, localcontext

import numba
import numpy as np
import pytest

from tablegen.model.elementary import (
    cosine_and_sine,
    exponential,
    logarithm,
    power,
    sine_and_cosine,
)
from tablegen.model.simd import WIDTH, load, store

pytestmark = pytest.mark.processor

#: Units in the last place.
ULP = np.finfo(np.float64).eps


@numba.njit
def by_floats(x, y, out):
    for i in range(x.size):
        out[0, i] = exponential(x[i])
        out[1, i] = logarithm(y[i])
        out[2, i] = power(y[i], 0.61)
        out[3, i], out[4, i] = sine_and_cosine(abs(x[i]) / 1000.0)


@numba.njit
def by_lanes(x, y, turns, out):
    for i in range(x.shape[0]):
        store(out, (0, i), exponential(load(x, i)))
        store(out, (1, i), logarithm(load(y, i)))
        store(out, (2, i), power(load(y, i), 0.61))
        sine, cosine = sine_and_cosine(load(turns, i))
        store(out, (3, i), sine)
        store(out, (4, i), cosine)


@pytest.fixture(scope="module")
def values():
    rng = np.random.default_rng(1)
    x = rng.uniform(-700.0, 700.0, 40_000)
    x[:8] = [0.0, -0.0, 1e-300, -1e-17, 0.5, -0.5, 708.0, -708.0]
    x[20_000:] *= 1e-3
    y = np.exp(rng.uniform(-690.0, 690.0, 40_000))
    y[:20_000] = rng.uniform(0.5, 2.0, 20_000)
    y[:4] = [1.0, np.nextafter(1.0, 2.0), np.nextafter(1.0, 0.0), np.sqrt(0.5)]
    out = np.empty((5, x.size))
    by_floats(x, y, out)
    return x, y, out


def test_exponential(values):
    x, _, out = values
    assert np.max(np.abs(out[0] / np.exp(x) - 1.0)) <= 2.0 * ULP


def test_logarithm(values):
    _, y, out = values
    expected = np.log(y)
    assert np.all(np.abs(out[1] - expected) <= 2.0 * ULP * np.maximum(np.abs(expected), ULP))
    assert logarithm(1.0) == 0.0


def test_sine_and_cosine(values):
    x, _, out = values
    # the angle given to the library is itself rounded
    angle = 2.0 * np.pi * np.abs(x) / 1000.0
    assert np.max(np.abs(out[3] - np.sin(angle))) <= 8.0 * ULP
    assert np.max(np.abs(out[4] - np.cos(angle))) <= 8.0 * ULP
    assert np.max(np.abs(out[3] ** 2 + out[4] ** 2 - 1.0)) <= 4.0 * ULP


def test_lanes_have_the_bits_of_floats(values):
    x, y, out = values
    wide = np.empty((5, x.size // WIDTH, WIDTH))
    by_lanes(x.reshape(-1, WIDTH), y.reshape(-1, WIDTH), np.abs(x).reshape(-1, WIDTH) / 1e3, wide)
    np.testing.assert_array_equal(wide.reshape(5, -1), out)


def exact(x, first):
    """Series of the cosine (first = 0) or sine (1), to 60 digits."""
    with localcontext() as context:
        context.prec = 60
        x = Decimal(x)
        term = total = x if first else Decimal(1)
        n = first
        while abs(term) > Decimal(10) ** -58:
            term *= -x * x / ((n + 1) * (n + 2))
            total += term
            n += 2
        return total


def test_cosine_and_sine_are_rounded_correctly():
    random = np.random.default_rng(1).uniform(1e-3, np.pi / 2, 500)
    tiny = [5e-324, 1e-300, 1e-20, 1e-9, 2.0**-27, 1e-4]
    angles = [*tiny, *np.radians([0.5, 20.0, 30.0, 45.0, 60.0, 90.0]), *random]
    for angle in map(float, angles):
        for computed, first in zip(cosine_and_sine(angle), (0, 1), strict=True):
            true = exact(angle, first)
            miss = abs(Decimal(computed) - true)
            for other in (math.nextafter(computed, -2.0), math.nextafter(computed, 2.0)):
                assert miss <= abs(Decimal(other) - true), angle
