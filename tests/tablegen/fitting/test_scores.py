"""Normal scores of samples and score maps of mixtures."""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import kstest, norm, rankdata

from tablegen.fitting.mixture import Mixture, sample_mixture
from tablegen.fitting.scores import normal_scores, score_maps

SCORE_MAX = 4.2
VARIATES = np.linspace(-5.5, 5.5, 129)
PLAIN = np.ones(2)


def mixture_of(weight, mean, deviation, mirror=None):
    """Mixture with diagonal covariances: means and deviations of shape (K, d)."""
    mean, deviation = np.atleast_2d(mean), np.atleast_2d(deviation)
    covariance = np.einsum("ki,ij->kij", deviation**2, np.eye(mean.shape[1]))
    signs = np.ones(mean.shape[1]) if mirror is None else np.array(mirror)
    return Mixture(np.array(weight), mean, covariance, signs)


#: One channel that is skewed and has two peaks, and one that is mirrored.
TWO_PEAKS = mixture_of([0.3, 0.7], [[-1.2, 0.9], [0.8, 0.2]], [[0.4, 0.5], [0.9, 1.1]], [1.0, -1.0])


class TestScoresOfASample:
    def test_are_those_of_the_ranks(self):
        channels = np.random.default_rng(1).gamma(2.0, size=(1001, 2))
        expected = ndtri((rankdata(channels, axis=0) - 0.5) / 1001)
        found = normal_scores(channels, PLAIN)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-13)
        # Any increasing function of a channel has the same scores.
        np.testing.assert_array_equal(normal_scores(np.log(channels), PLAIN), found)

    def test_ties_are_broken_by_position(self):
        scores = normal_scores(np.array([[1.0], [0.0], [1.0], [1.0]]), np.ones(1))[:, 0]
        np.testing.assert_allclose(scores, ndtri([0.375, 0.125, 0.625, 0.875]), atol=1e-14)

    def test_of_a_mirrored_channel_are_those_of_the_doubled_sample(self):
        column = np.random.default_rng(2).normal(0.4, 1.0, size=(800, 1))
        found = normal_scores(column, -np.ones(1))
        doubled = normal_scores(np.concatenate([column, -column]), np.ones(1))
        np.testing.assert_allclose(found, doubled[:800], rtol=0.0, atol=1e-12)
        # A sample that is not symmetric has other scores of its own.
        assert np.abs(found - normal_scores(column, np.ones(1))).max() > 0.3

    def test_of_the_reflected_sample_are_reflected(self):
        column = np.random.default_rng(3).normal(0.4, 1.0, size=(800, 1))
        np.testing.assert_array_equal(
            normal_scores(-column, -np.ones(1)), -normal_scores(column, -np.ones(1))
        )

    def test_are_finite_and_leave_the_sample_alone(self):
        channels = np.zeros((50, 2))
        assert np.isfinite(normal_scores(channels, np.array([1.0, -1.0]))).all()
        np.testing.assert_array_equal(channels, 0.0)


class TestScoreMaps:
    def test_standard_normal_component_needs_none(self):
        maps = score_maps(mixture_of([1.0], [0.0, 0.0], [1.0, 1.0]), VARIATES, SCORE_MAX)
        expected = np.clip(VARIATES, -SCORE_MAX, SCORE_MAX)
        np.testing.assert_allclose(maps, [expected, expected], rtol=0.0, atol=1e-12)

    def test_one_component_is_standardised(self):
        maps = score_maps(mixture_of([1.0], [0.7, -2.0], [0.5, 3.0]), VARIATES, SCORE_MAX)
        expected = np.array([(VARIATES - 0.7) / 0.5, (VARIATES + 2.0) / 3.0])
        np.testing.assert_allclose(
            maps, np.clip(expected, -SCORE_MAX, SCORE_MAX), rtol=0.0, atol=1e-12
        )

    def test_mixture_is_the_quantile_of_its_distribution_function(self):
        maps = score_maps(TWO_PEAKS, VARIATES, SCORE_MAX)
        below = 0.3 * norm.cdf(VARIATES, -1.2, 0.4) + 0.7 * norm.cdf(VARIATES, 0.8, 0.9)
        inner = np.abs(maps[0]) < 4.0
        np.testing.assert_allclose(maps[0][inner], norm.ppf(below[inner]), rtol=0.0, atol=1e-9)

    def test_tails_are_as_good_as_the_middle(self):
        """Far out the mixture is its widest component, to the last digit on either side."""
        maps = score_maps(mixture_of([0.5, 0.5], [[0.0], [0.0]], [[1.0], [0.1]]), VARIATES, 10.0)
        tail = VARIATES > 4.0
        expected = norm.isf(0.5 * norm.sf(VARIATES[tail]))
        np.testing.assert_allclose(maps[0][tail], expected, rtol=1e-12)
        np.testing.assert_allclose(maps[0], -maps[0][::-1], rtol=0.0, atol=1e-12)

    def test_rows_do_not_decrease_and_stay_within_the_knots(self):
        maps = score_maps(TWO_PEAKS, VARIATES, 2.0)
        assert (np.diff(maps, axis=1) >= 0.0).all()
        assert (maps[0, 0], maps[0, -1]) == (-2.0, 2.0)

    def test_mirrored_channel_is_exactly_odd(self):
        maps = score_maps(TWO_PEAKS, VARIATES, SCORE_MAX)
        np.testing.assert_array_equal(maps[1], -maps[1][::-1])
        # Without the mirror the same components are lopsided.
        plain = Mixture(TWO_PEAKS.weight, TWO_PEAKS.mean, TWO_PEAKS.covariance, PLAIN)
        maps = score_maps(plain, VARIATES, SCORE_MAX)
        assert np.abs(maps[1] + maps[1][::-1]).max() > 0.5

    @pytest.mark.parametrize("channel", [0, 1])
    def test_mapped_mixture_is_standard_normal(self, channel):
        """Kolmogorov-Smirnov; a right map fails with probability 1e-6 a channel."""
        count = 100_000
        variates = sample_mixture(TWO_PEAKS, count, np.random.default_rng(6))[:, channel]
        # As a draw reads the map: linear between knots, which costs the last 0.001.
        bound = np.sqrt(np.log(2.0 / 1e-6) / (2.0 * count)) + 0.001
        score = score_maps(TWO_PEAKS, VARIATES, SCORE_MAX)[channel]
        assert kstest(np.interp(variates, VARIATES, score), "norm").statistic < bound
        # Refused: the variates themselves, and the map of the other channel.
        assert kstest(variates, "norm").statistic > bound
        other = score_maps(TWO_PEAKS, VARIATES, SCORE_MAX)[1 - channel]
        assert kstest(np.interp(variates, VARIATES, other), "norm").statistic > bound
