"""Normal scores of samples and distribution functions of mixtures."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import kstest, norm, rankdata

from tablegen.fitting.mixture import Mixture, sample_mixture
from tablegen.fitting.scores import mixture_probabilities, normal_scores

VARIATES = np.linspace(-5.5, 5.5, 129)
PLAIN = np.ones(2)


def mixture_of(weight, mean, deviation, signs=None, reflection=0.0):
    """Mixture with diagonal covariances: means and deviations of shape (K, d)."""
    mean, deviation = np.atleast_2d(mean), np.atleast_2d(deviation)
    covariance = np.einsum("ki,ij->kij", deviation**2, np.eye(mean.shape[1]))
    signs = np.ones(mean.shape[1]) if signs is None else np.array(signs)
    reflections = np.broadcast_to(reflection, len(mean)).astype(float)
    return Mixture(np.array(weight), mean, covariance, reflections, signs)


#: One channel that is skewed and has two peaks, and one that reflection reverses.
TWO_PEAKS = mixture_of(
    [0.3, 0.7], [[-1.2, 0.9], [0.8, 0.2]], [[0.4, 0.5], [0.9, 1.1]], [1.0, -1.0], [0.5, 0.25]
)


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


class TestProbabilities:
    def test_standard_normal_component(self):
        found = mixture_probabilities(mixture_of([1.0], [0.0, 0.0], [1.0, 1.0]), VARIATES)
        np.testing.assert_allclose(found, [norm.cdf(VARIATES)] * 2, rtol=1e-12, atol=1e-15)

    def test_components_add_up(self):
        found = mixture_probabilities(TWO_PEAKS, VARIATES)[0]
        below = 0.3 * norm.cdf(VARIATES, -1.2, 0.4) + 0.7 * norm.cdf(VARIATES, 0.8, 0.9)
        np.testing.assert_allclose(found, below, rtol=1e-12, atol=1e-15)

    def test_reflection_counts_in_the_mirrored_channel(self):
        found = mixture_probabilities(TWO_PEAKS, VARIATES)[1]
        plain = 0.3 * norm.cdf(VARIATES, 0.9, 0.5), 0.7 * norm.cdf(VARIATES, 0.2, 1.1)
        other = 0.3 * norm.cdf(VARIATES, -0.9, 0.5), 0.7 * norm.cdf(VARIATES, -0.2, 1.1)
        expected = 0.5 * plain[0] + 0.5 * other[0] + 0.75 * plain[1] + 0.25 * other[1]
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)

    def test_rows_do_not_decrease(self):
        found = mixture_probabilities(TWO_PEAKS, VARIATES)
        assert (np.diff(found, axis=1) >= 0.0).all()
        assert found.min() >= 0.0
        assert found.max() <= 1.0

    @pytest.mark.parametrize("channel", [0, 1])
    def test_are_those_of_its_draws(self, channel):
        """Kolmogorov-Smirnov; right probabilities fail with probability 1e-6 a channel."""
        count = 100_000
        variates = sample_mixture(TWO_PEAKS, count, np.random.default_rng(6))[:, channel]
        # linear between knots, which costs the last 0.001
        bound = np.sqrt(np.log(2.0 / 1e-6) / (2.0 * count)) + 0.001
        probabilities = mixture_probabilities(TWO_PEAKS, VARIATES)
        uniform = np.interp(variates, VARIATES, probabilities[channel])
        assert kstest(uniform, "uniform").statistic < bound
        # Refused: those of the other channel, and of the same components without reflection.
        other = np.interp(variates, VARIATES, probabilities[1 - channel])
        assert kstest(other, "uniform").statistic > bound
        if channel == 1:
            plain = replace(TWO_PEAKS, reflection=np.zeros(2))
            other = np.interp(variates, VARIATES, mixture_probabilities(plain, VARIATES)[1])
            assert kstest(other, "uniform").statistic > bound
