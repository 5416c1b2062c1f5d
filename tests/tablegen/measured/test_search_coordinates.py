"""Coordinates: there and back, and what they promise between any bounds."""

import numpy as np
import pytest

from tablegen.measured.search_coordinates import Bernstein, Descending, Logarithm, Plain, Shares

RNG = np.random.default_rng(4)


@pytest.mark.parametrize(
    ("scale", "values"),
    [
        (Plain(), [0.3, -2.0]),
        (Logarithm(), [1e-3, 40.0]),
        (Bernstein(4, np.pi / 2), [0.993, -1.76, 1.56, -0.49]),
        (Shares(), [0.2, 0.5, 0.1]),
        (Shares(), [0.2, 0.8, 0.0]),
        (Shares(), [1.0, 0.0, 0.0]),
        (Descending(), [0.4, 0.1]),
        (Descending(), [0.0, 0.0]),
    ],
)
def test_there_and_back(scale, values):
    given = np.array(values)
    np.testing.assert_allclose(scale.values(scale.coordinates(given)), given, atol=1e-12)


def test_bernstein_coefficients_from_0_to_1_give_polynomials_that_stay_there():
    scale, grid = Bernstein(5, np.pi / 2), np.linspace(0.0, np.pi / 2, 400)
    for _ in range(50):
        coefficients = RNG.uniform(0.0, 1.0, 5)
        polynomial = np.polynomial.Polynomial(scale.values(coefficients))
        values = polynomial(grid)
        assert values.min() > -1e-12
        assert values.max() < 1.0 + 1e-12
        # the ends are the first and the last coefficient
        np.testing.assert_allclose(values[[0, -1]], coefficients[[0, -1]], atol=1e-12)


def test_shares_never_add_up_to_more_than_one():
    for _ in range(50):
        shares = Shares().values(RNG.uniform(0.0, 1.0, 4))
        assert shares.min() >= 0.0
        assert shares.sum() <= 1.0 + 1e-15
    assert Shares().values(np.array([0.5, 1.0, 0.7])).tolist() == [0.5, 0.5, 0.0]
