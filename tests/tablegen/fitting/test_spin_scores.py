"""Scores of the slowest rebounds have the law of a normal tail."""

import numpy as np
from scipy.special import ndtr, ndtri
from scipy.stats import kstest

from sampler.formats.bounds import SLOW_TAIL
from tablegen.fitting.spin_scores import _slowest_normals

#: Share of the rebounds that are slowest.
SHARE = 0.01

#: Quantiles of a normal law at equal steps.
NORMALS = ndtri((np.arange(200_000) + 0.5) / 200_000).astype(np.float32)


def tail(x):
    """Distribution function of the normal numbers below their quantile 0.01, standardised."""
    below = ndtri(SHARE * (np.arange(200_000) + 0.5) / 200_000)
    return np.minimum(ndtr(below.mean() + below.std() * x) / SHARE, 1.0)


def test_normal_numbers_of_the_slowest_rebounds_are_a_normal_tail():
    slowest = _slowest_normals(NORMALS).astype(np.float64)
    assert abs(slowest.mean()) < 1e-3
    assert abs(slowest.std() - 1.0) < 2e-3
    assert kstest(slowest, tail).statistic < 0.01
    assert kstest(NORMALS, tail).statistic > 0.1
    # v / V goes as the root of these probabilities
    for probability in (0.01, 1e-3, 1e-4):
        assert 0.9 < tail(np.quantile(slowest, probability)) / probability < 1.1
        # with normal numbers as they are, so slow rebounds would be several times too rare
        assert tail(np.quantile(NORMALS, probability)) > 2.0 * probability


def test_no_normal_number_is_too_large_for_single_precision():
    """The square roots lose no digits that matter, up to the largest normal number of a draw."""
    shift, square, factor, core = SLOW_TAIL
    x = np.linspace(-7.0, 7.0, 1001) - 1.0
    exact = shift - np.sqrt(square + factor * (np.sqrt(x * x + core) - x) ** 2)
    single = _slowest_normals((x + 1.0).astype(np.float32))
    np.testing.assert_allclose(single, exact, atol=1e-5)
