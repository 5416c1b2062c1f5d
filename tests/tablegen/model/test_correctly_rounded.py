"""Cosine and sine, against the library's and against exact values."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest

from tablegen.model.correctly_rounded import cosine_and_sine

pytestmark = pytest.mark.processor


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


@pytest.fixture(scope="module")
def angles():
    random = np.random.default_rng(1).uniform(1e-3, np.pi / 2, 500)
    return [1e-9, 2.0**-27, 1e-4, *np.radians([0.5, 20.0, 30.0, 45.0, 60.0, 90.0]), *random]


def test_no_number_is_nearer(angles):
    for angle in map(float, angles):
        for found, first in zip(cosine_and_sine(angle), (0, 1), strict=True):
            true = exact(angle, first)
            miss = abs(Decimal(found) - true)
            for other in (math.nextafter(found, -2.0), math.nextafter(found, 2.0)):
                assert miss <= abs(Decimal(other) - true), angle


def test_within_one_unit_of_the_library(angles):
    found = np.array([cosine_and_sine(float(angle)) for angle in angles])
    ours = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    assert np.all(np.abs(found - ours) <= np.spacing(np.abs(ours)))


@pytest.mark.parametrize("angle", [5e-324, 1e-300, 1e-20])
def test_of_the_smallest_angles(angle):
    assert cosine_and_sine(angle) == (1.0, angle)
