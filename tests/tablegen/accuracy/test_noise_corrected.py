"""Bounds on the distance between two laws, against closed forms; seeds are fixed."""

import numpy as np
import pytest
from scipy.stats import norm
from sklearn.metrics import roc_auc_score

from tablegen.accuracy.metrics import (
    classifier_scores,
    correlation_error,
    ks_distances,
    sliced_wasserstein,
    unit_directions,
)
from tablegen.accuracy.noise_corrected import ESTIMATES, Settings, correlation_variances
from tablegen.config.metric_table import METRICS

#: Metrics without a classifier.
NAMES = [name for name, metric in METRICS.items() if not metric.learned]


def estimate(name, a, b, **settings):
    return ESTIMATES[name](a, b, Settings(**settings))


#: Shift of the first component of one sample, or its additional correlation.
SHIFT, EXTRA = 0.1, 0.15


def normal(seed, count, shift=0.0, correlation=0.3):
    """Standard normal triples with one correlated pair, the first component shifted."""
    states = np.random.default_rng(seed).standard_normal((count, 3))
    states[:, 1] = correlation * states[:, 0] + np.sqrt(1.0 - correlation**2) * states[:, 1]
    states[:, 0] += shift
    return states


#: Distances of the laws of the shifted and of the more correlated sample.
TRUTH = {
    "ks": 2.0 * norm.cdf(SHIFT / 2.0) - 1.0,
    "sliced_wasserstein": SHIFT * np.abs(unit_directions(64, 3, 0)[:, 0]).mean(),
    "correlation_error": EXTRA,
}


def wrong(name, seed, count):
    """A sample with the error in `TRUTH`."""
    if name == "correlation_error":
        return normal(seed, count, correlation=0.3 + EXTRA)
    return normal(seed, count, shift=SHIFT)


SAMPLES = normal(1, 3000, shift=0.02), normal(2, 2500)


def test_distances_are_those_of_the_metrics():
    found = estimate("ks", *SAMPLES)
    np.testing.assert_array_equal(found.by_variable, ks_distances(*SAMPLES))
    assert found.value == max(found.distance)
    exact = sliced_wasserstein(*SAMPLES, seed=3)
    assert estimate("sliced_wasserstein", *SAMPLES, seed=3).value == pytest.approx(exact, rel=1e-3)
    assert estimate("correlation_error", *SAMPLES).value == correlation_error(*SAMPLES)
    # as many states of each sample
    scores = classifier_scores(SAMPLES[0][:2500], SAMPLES[1], 4, 1000)
    found = estimate("auc", *SAMPLES, seed=4, trained=1000)
    expected = roc_auc_score(np.repeat([1, 0], 1500), np.concatenate(scores))
    assert found.value == pytest.approx(expected)
    # Mann-Whitney statistic without a difference
    null = np.sqrt((1500 + 1500 + 1) / (12 * 1500 * 1500))
    assert found.standard_error == pytest.approx(null, rel=0.05)


@pytest.mark.parametrize("name", NAMES)
def test_constant_variables_do_no_harm(name):
    found = estimate(name, *(np.column_stack((x, np.ones(len(x)))) for x in SAMPLES))
    assert np.isfinite([found.value, found.standard_error, found.noise]).all()
    assert found.value == pytest.approx(estimate(name, *SAMPLES).value, abs=0.01)


def test_correlation_variance_of_a_pair_that_is_not_normal():
    """Against repetition: 400 samples give the variance within 20 % (2.8 standard errors)."""
    rng = np.random.default_rng(6)

    def heavy(count):
        x = rng.exponential(size=(count, 2)) ** 1.5
        return np.column_stack((x[:, 0], x[:, 0] + x[:, 1]))

    repeated = np.var([np.corrcoef(heavy(2000).T)[0, 1] for _ in range(400)]) * 2000
    found = correlation_variances(heavy(200_000))[0, 1]
    assert found == pytest.approx(repeated, rel=0.2)
    assert found != pytest.approx((1.0 - 0.5) ** 2, rel=0.2)  # as normality would give


@pytest.mark.parametrize("name", NAMES)
class TestRepeated:
    """Sixty pairs of samples; each statement would be wrong by chance less than once in 1000."""

    COUNT, PAIRS = 8000, 60

    def repeated(self, name, make):
        """Values with their errors, held-out differences with theirs, and the mean noise."""
        found = [
            estimate(name, make(2 * k), normal(2 * k + 1, self.COUNT)) for k in range(self.PAIRS)
        ]
        rows = [(e.value, e.standard_error, e.held_out, e.held_out_error) for e in found]
        return *np.array(rows).T, np.mean([e.noise for e in found])

    def test_equal_laws(self, name):
        values, _, held, held_errors, noise = self.repeated(name, lambda s: normal(s, self.COUNT))
        # components and pairs are not quite independent, which makes the noise a little too large
        assert np.mean(values) == pytest.approx(noise, rel=0.15)
        scores = held / held_errors
        assert abs(scores.mean()) < 3.3 / np.sqrt(self.PAIRS)
        assert scores.max() < 4.2  # 60 normal numbers: 1e-3 would be above

    def test_brackets_the_error(self, name):
        values, errors, held, held_errors, _ = self.repeated(
            name, lambda s: wrong(name, s, self.COUNT)
        )
        mean_error = 3.3 / np.sqrt(self.PAIRS)
        assert values.mean() > TRUTH[name] - mean_error * errors.mean()
        assert held.mean() < TRUTH[name] + mean_error * held_errors.mean()
        assert (values + 4.2 * errors > TRUTH[name]).all()
        assert (held - 4.2 * held_errors < TRUTH[name]).all()
        # ... and narrowly: half and twice the distance are told apart
        assert held.mean() > 0.7 * TRUTH[name]
        assert values.mean() < 1.4 * TRUTH[name]


def test_auc_error_is_that_of_the_pairs():
    """DeLong's variance by its definition, over all pairs of states, where the laws differ."""
    a, b = normal(8, 300, shift=0.8), normal(9, 300)
    x, y = classifier_scores(a, b, 1, 100)
    won = (x[:, None] > y[None, :]) + 0.5 * (x[:, None] == y[None, :])
    variance = won.mean(axis=1).var() / 200 + won.mean(axis=0).var() / 200
    found = estimate("auc", a, b, seed=1, trained=100)
    assert found.value == pytest.approx(won.mean())
    assert found.value > 0.6
    assert found.standard_error == pytest.approx(np.sqrt(variance))
