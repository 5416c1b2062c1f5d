"""The normal quantile against scipy's, an independent implementation (Cephes)."""

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from sampler.normal import normal_cdf, normal_quantile

_STEP = 2.0**-32
ENDS = (0.5 * _STEP, 1.5 * _STEP, 1.0 - 1.5 * _STEP, 1.0 - 0.5 * _STEP)


@pytest.mark.parametrize(
    "p",
    [1e-300, 1e-12, 1e-5, 0.075, 0.0750001, 0.2, 0.5, 0.925, 0.9999, *ENDS],
)
def test_quantile_at_chosen_points(p):
    assert normal_quantile(p) == pytest.approx(ndtri(p), rel=2e-14, abs=1e-15)


def test_quantile_on_a_grid_of_words():
    p = (np.arange(0, 2**32, 2**18 + 1) + 0.5) * _STEP
    ours = np.array([normal_quantile(x) for x in p])
    np.testing.assert_allclose(ours, ndtri(p), rtol=2e-14, atol=1e-14)
    assert np.all(np.diff(ours) > 0.0)


def test_quantile_continues_across_its_pieces():
    # 0.075 and 0.925 part centre from tail, exp(-25) near from far tail.
    for edge in (0.075, 0.925, np.exp(-25.0)):
        below, above = normal_quantile(edge * (1 - 1e-13)), normal_quantile(edge * (1 + 1e-13))
        assert abs(above - below) < 1e-11


def test_cdf_over_the_whole_range():
    x = np.linspace(-37.0, 8.0, 1001)
    ours = np.array([normal_cdf(value) for value in x])
    np.testing.assert_allclose(ours, ndtr(x), rtol=1e-12)
