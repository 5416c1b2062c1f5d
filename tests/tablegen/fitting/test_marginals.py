"""Quantile knots against laws whose quantile functions are known."""

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from tablegen.fitting.marginals import VARIATE_MAX, quantile_knots, variate_knots

N = 200_001
#: Levels of the order statistics of N numbers.
LEVELS = (np.arange(N) + 0.5) / N
#: A perfectly regular standard normal sample: no statistics enter.
NORMAL = ndtri(LEVELS)
KNOTS = variate_knots(65)
PROBABILITY = ndtr(KNOTS)


def knots_of(channels, mirror):
    """Quantiles of each channel at the knots of a standard normal law."""
    probabilities = np.broadcast_to(PROBABILITY, (channels.shape[1], len(KNOTS)))
    return quantile_knots(channels, probabilities, mirror)


#: Knots that lie within the sample.
INNER = np.abs(KNOTS) < NORMAL[-1]


@pytest.mark.parametrize("count", [17, 65, 257, 1025])
def test_knots_are_equally_spaced_and_exactly_symmetric(count):
    knots = variate_knots(count)
    assert knots.shape == (count,)
    assert (knots[0], knots[count // 2], knots[-1]) == (-VARIATE_MAX, 0.0, VARIATE_MAX)
    np.testing.assert_array_equal(knots, -knots[::-1])
    np.testing.assert_allclose(np.diff(knots), 2.0 * VARIATE_MAX / (count - 1), rtol=1e-12)


def test_normal_law_is_a_straight_line():
    channels = np.column_stack([NORMAL, 0.3 + 0.02 * NORMAL, -5.0 + 3.0 * NORMAL])
    quantiles = knots_of(channels, np.ones(3))
    assert quantiles.shape == (3, 65)
    # Between order statistics the sample's quantile function is a chord of the true one; its
    # error grows towards the ends to about the last gap.
    central = np.abs(KNOTS) < 3.0
    np.testing.assert_allclose(quantiles[0][central], KNOTS[central], rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(quantiles[0][INNER], KNOTS[INNER], rtol=0.0, atol=0.02)
    np.testing.assert_allclose(quantiles[1], 0.3 + 0.02 * quantiles[0], rtol=1e-9)
    np.testing.assert_allclose(quantiles[2], -5.0 + 3.0 * quantiles[0], rtol=1e-9)


def test_uniform_law():
    quantiles = knots_of(LEVELS[:, None], np.ones(1))[0]
    # Linear interpolation between the order statistics is exact; outside them they end.
    expected = np.clip(ndtr(KNOTS), LEVELS[0], LEVELS[-1])
    np.testing.assert_allclose(quantiles, expected, rtol=0.0, atol=1e-12)


def test_ends_are_the_extremes_of_a_small_sample():
    sample = np.random.default_rng(1).exponential(size=(500, 1))
    quantiles = knots_of(sample, np.ones(1))[0]
    assert (quantiles[0], quantiles[-1]) == (sample.min(), sample.max())


def test_rows_do_not_decrease():
    rng = np.random.default_rng(2)
    tied = rng.integers(0, 4, size=3000) / 7.0
    channels = np.column_stack([rng.standard_cauchy(3000), tied, tied, np.full(3000, 0.25)])
    quantiles = knots_of(channels, np.array([1.0, 1.0, -1.0, 1.0]))
    assert (np.diff(quantiles, axis=1) >= 0.0).all()
    assert (np.diff(quantiles.astype(np.float32), axis=1) >= 0.0).all()
    np.testing.assert_array_equal(quantiles[3], 0.25)


def test_mirrored_channels_are_exactly_odd_and_see_the_size_only():
    skewed = np.random.default_rng(3).gamma(2.0, size=(4000, 1)) - 1.0
    mirrored = knots_of(skewed, np.array([-1.0]))
    np.testing.assert_array_equal(mirrored, -mirrored[:, ::-1])
    flips = np.random.default_rng(4).choice([-1.0, 1.0], size=skewed.shape)
    again = knots_of(flips * skewed, np.array([-1.0]))
    np.testing.assert_allclose(again, mirrored, rtol=0.0, atol=1e-12)
    # It is the law of the sample together with its reflection ...
    doubled = knots_of(np.concatenate([skewed, -skewed]), np.ones(1))
    np.testing.assert_allclose(mirrored, doubled, rtol=0.0, atol=1e-12)
    # ... and not that of the sample, which is skewed.
    plain = knots_of(skewed, np.ones(1))
    assert np.abs(plain - mirrored).max() > 0.5
