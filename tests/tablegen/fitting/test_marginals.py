"""Marginals: normal scores, distribution functions of mixtures, quantile knots, their rounding."""

import numpy as np
from scipy.special import ndtr, ndtri
from scipy.stats import norm, rankdata

from tablegen.fitting.marginals import (
    STEPS,
    VARIATE_MAX,
    mixture_probabilities,
    normal_scores,
    quantile_knots,
    round_quantiles,
    variate_knots,
)
from tablegen.fitting.mixture import Mixture

#: Probabilities of the order statistics of 200,001 numbers, and a sample without chance.
LEVELS = (np.arange(200_001) + 0.5) / 200_001
NORMAL = ndtri(LEVELS)
KNOTS = variate_knots(65)

#: One channel that is skewed and has two peaks, and one that reflection reverses.
TWO_PEAKS = Mixture(
    np.array([0.3, 0.7]),
    np.array([[-1.2, 0.9], [0.8, 0.2]]),
    np.array([np.diag([0.16, 0.25]), np.diag([0.81, 1.21])]),
    np.array([0.5, 0.25]),
    np.array([1.0, -1.0]),
)


def normal_quantiles(channels):
    """Quantiles of each channel at the knots of a standard normal law."""
    probabilities = np.broadcast_to(ndtr(KNOTS), (channels.shape[1], len(KNOTS)))
    return quantile_knots(channels, probabilities)


class TestScores:
    def test_are_those_of_the_ranks(self):
        channels = np.random.default_rng(1).gamma(2.0, size=(1001, 2))
        channels[7] = channels[5]  # a tie, broken by position
        order = channels.copy()
        order[7] += 1e-12
        expected = ndtri((rankdata(order, axis=0) - 0.5) / 1001)
        computed = normal_scores(channels)
        np.testing.assert_allclose(computed, expected, rtol=0.0, atol=1e-13)


def test_probabilities_are_the_sum_over_components_and_their_reflections():
    variates = np.linspace(-5.5, 5.5, 129)
    computed = mixture_probabilities(TWO_PEAKS, variates)
    first = 0.3 * norm.cdf(variates, -1.2, 0.4) + 0.7 * norm.cdf(variates, 0.8, 0.9)
    np.testing.assert_allclose(computed[0], first, rtol=1e-12, atol=1e-15)
    low, high = norm.cdf(variates, 0.9, 0.5), norm.cdf(variates, -0.9, 0.5)
    second = 0.3 * (0.5 * low + 0.5 * high)
    low, high = norm.cdf(variates, 0.2, 1.1), norm.cdf(variates, -0.2, 1.1)
    second += 0.7 * (0.75 * low + 0.25 * high)
    np.testing.assert_allclose(computed[1], second, rtol=1e-12, atol=1e-15)
    assert (np.diff(computed, axis=1) >= 0.0).all()


class TestQuantiles:
    def test_knots_are_equally_spaced_and_exactly_symmetric(self):
        assert (KNOTS[0], KNOTS[32], KNOTS[-1]) == (-VARIATE_MAX, 0.0, VARIATE_MAX)
        np.testing.assert_array_equal(KNOTS, -KNOTS[::-1])
        np.testing.assert_allclose(np.diff(KNOTS), VARIATE_MAX / 32, rtol=1e-12)

    def test_of_known_laws(self):
        channels = np.column_stack([NORMAL, -5.0 + 3.0 * NORMAL, LEVELS])
        normal, wide, uniform = normal_quantiles(channels)
        # between order statistics, the quantile function of the sample is a chord of the true one
        inner = np.abs(KNOTS) < 3.0
        np.testing.assert_allclose(normal[inner], KNOTS[inner], rtol=0.0, atol=1e-5)
        np.testing.assert_allclose(wide, -5.0 + 3.0 * normal, rtol=1e-9)
        expected = np.clip(ndtr(KNOTS), LEVELS[0], LEVELS[-1])
        np.testing.assert_allclose(uniform, expected, rtol=0.0, atol=1e-12)

    def test_do_not_decrease_and_end_at_the_extremes_of_the_sample(self):
        rng = np.random.default_rng(2)
        tied = rng.integers(0, 4, size=3000) / 7.0
        channels = np.column_stack([rng.standard_cauchy(3000), tied, np.full(3000, 0.25)])
        quantiles = normal_quantiles(channels)
        assert (np.diff(quantiles.astype(np.float32), axis=1) >= 0.0).all()
        small = channels[:500, :1]
        assert normal_quantiles(small)[0, [0, -1]].tolist() == [small.min(), small.max()]


class TestRounding:
    KNOTS = variate_knots(129)
    #: A wide law, a narrow one far from zero, one next to zero and one with an atom.
    BEFORE = np.array(
        [KNOTS, 0.9 + 1e-3 * KNOTS, np.exp(2.0 * KNOTS - 9.0), np.maximum(KNOTS, 0.25)]
    ).astype(np.float32)

    def test_changes_probabilities_little_and_keeps_order_ends_and_atoms(self):
        after = round_quantiles(self.BEFORE)
        for old, new in zip(self.BEFORE.astype(float), after.astype(float), strict=True):
            rising = np.append(np.diff(old) > 0.0, True)
            probabilities = norm.cdf(self.KNOTS)[rising]
            moved = np.interp(new[rising], old[rising], probabilities) - probabilities
            assert np.abs(moved).max() < 0.027 / (2 * STEPS)
        np.testing.assert_array_equal(np.diff(after) > 0.0, np.diff(self.BEFORE) > 0.0)
        np.testing.assert_array_equal(after[:, [0, -1]], self.BEFORE[:, [0, -1]])
        assert (after[3, self.KNOTS <= 0.25] == 0.25).all()
