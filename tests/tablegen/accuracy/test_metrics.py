"""Metrics agree with closed forms; in repetitions, samples of one law hold and others do not.

Seeds are fixed. Where a bound is statistical, its false-alarm rate for a random seed is stated.
"""

import math

import numpy as np
import pytest
from scipy.stats import norm, wasserstein_distance

from sampler.formats.layout import DATASETS
from tablegen.accuracy.metrics import (
    ESTIMATES,
    Settings,
    auc,
    classifier_scores,
    correlations,
    ks_distances,
    ratio,
    sliced_wasserstein,
    unit_directions,
)
from tablegen.config.metric_table import METRICS, PRESETS

#: Metrics without a classifier.
CHEAP = [name for name, metric in METRICS.items() if not metric.learned]

#: Shift of the first variable of a wrong sample, or its additional correlation.
SHIFT, EXTRA = 0.2, 0.15

#: Distances of the laws of the shifted and of the more correlated sample.
TRUTH = {
    "ks": 2.0 * norm.cdf(SHIFT / 2.0) - 1.0,
    "sliced_wasserstein": SHIFT * np.abs(unit_directions(16, 6, 0)[:, 0]).mean(),
    "correlation_error": EXTRA,
}


def normal(seed, count, shift=0.0, correlation=0.3):
    """Draw normal vectors of six variables: two are correlated, and the first is shifted."""
    states = np.random.default_rng(seed).standard_normal((count, 6))
    states[:, 1] = correlation * states[:, 0] + np.sqrt(1.0 - correlation**2) * states[:, 1]
    states[:, 0] += shift
    return states


@pytest.mark.parametrize("name", CHEAP)
class TestRepeated:
    """Thirty pairs of samples. A number within its limit misses it at most once in 700."""

    COUNT, PAIRS = 10_000, 30

    def certain(self, name, **error):
        def one(k):
            pair = normal(2 * k, self.COUNT, **error), normal(2 * k + 1, self.COUNT)
            return ESTIMATES[name](*pair, Settings(directions=16)).certain

        return np.array([one(k) for k in range(self.PAIRS)])

    def test_samples_of_one_law_hold_at_any_limit(self, name):
        assert (self.certain(name) <= 0.0).sum() >= self.PAIRS - 1

    def test_a_wrong_law_holds_at_its_distance_and_not_at_a_fifth(self, name):
        """If the limit is the true distance, one sample in 700 misses it."""
        wrong = {"correlation": 0.3 + EXTRA} if name == "correlation_error" else {"shift": SHIFT}
        certain, truth = self.certain(name, **wrong), TRUTH[name]
        assert (certain <= truth).sum() >= self.PAIRS - 1
        assert (certain > 0.2 * truth).all()


@pytest.mark.study  # a minute
@pytest.mark.parametrize("preset", PRESETS)
def test_one_law_holds_at_every_preset(preset):
    """With samples of the usual size no limit is missed, and noise is below a third of it."""
    count = max(100_000, int(40.0 / PRESETS[preset]["ks"] ** 2))
    for seed in range(5):
        pair = normal(2 * seed, count), normal(2 * seed + 1, count)
        for name, limit in PRESETS[preset].items():
            least, estimate = METRICS[name].least, ESTIMATES[name](*pair, Settings(seed))
            assert estimate.value - least < (limit - least) / 3.0
            assert estimate.certain <= least


@pytest.mark.parametrize(
    ("name", "least"),
    [("ks", -1.0), ("sliced_wasserstein", 0.02), ("correlation_error", 0.5), ("auc", 0.6)],
)
def test_every_metric_but_ks_sees_lost_dependence(name, least):
    sample, reference = (normal(k, 20_000) for k in (1, 2))
    for states in (sample, reference):
        states += 1.5 * states[:, :1]
    rng = np.random.default_rng(3)
    independent = np.column_stack([rng.permutation(column) for column in sample.T])
    certain = ESTIMATES[name](independent, reference, Settings()).certain
    assert certain > least
    assert name != "ks" or certain < 0.0


def test_constant_variables_do_no_harm():
    pair = normal(1, 3000, shift=0.02), normal(2, 2500)
    for name in CHEAP:
        widened = (np.column_stack((x, np.ones(len(x)))) for x in pair)
        with_constants, plain = (ESTIMATES[name](*x, Settings()) for x in (tuple(widened), pair))
        assert np.isfinite([with_constants.value, with_constants.error]).all()
        assert with_constants.value == pytest.approx(plain.value, abs=0.01)


def test_ratio_of_means():
    rng = np.random.default_rng(1)
    estimates = [
        ratio(1.1 * rng.exponential(size=4000), rng.exponential(size=4000)) for _ in range(200)
    ]
    values, errors = np.array([(one.value, one.error) for one in estimates]).T
    # standard errors: 0.0017 of the mean, 5 % of the deviation
    assert values.mean() == pytest.approx(0.1, abs=0.006)
    assert errors.mean() == pytest.approx(np.sqrt(2.0 / 4000), rel=0.05)
    assert values.std() == pytest.approx(1.1 * errors.mean(), rel=0.2)


def test_correlation_variance_of_a_pair_that_is_not_normal():
    """The variance agrees with that of 400 repetitions within 20 % (2.8 standard errors)."""
    rng = np.random.default_rng(6)

    def heavy(count):
        x = rng.exponential(size=(count, 2)) ** 1.5
        return np.column_stack((x[:, 0], x[:, 0] + x[:, 1]))

    repeated = np.var([np.corrcoef(heavy(2000).T)[0, 1] for _ in range(400)]) * 2000
    variance = correlations(heavy(200_000))[1][0, 1]
    assert variance == pytest.approx(repeated, rel=0.2)
    assert variance != pytest.approx((1.0 - 0.5) ** 2, rel=0.2)  # as normality would give


def test_auc_and_its_error_are_those_of_the_pairs():
    """The error agrees with DeLong's definition, by all pairs of states of two different laws."""
    a, b = normal(8, 400, shift=0.8), normal(9, 400)
    x, y = classifier_scores(a, b, 1)
    won = (x[:, None] > y[None, :]) + 0.5 * (x[:, None] == y[None, :])
    variance = won.mean(axis=1).var() / 200 + won.mean(axis=0).var() / 200
    estimate = auc(a, b, Settings(1))
    assert estimate.value == pytest.approx(won.mean())
    assert estimate.value > 0.6
    assert estimate.error == pytest.approx(np.sqrt(variance))


def test_kolmogorov_smirnov_of_shifted_uniforms():
    grid = (np.arange(1000) + 0.5) / 1000.0
    reference = np.column_stack([grid] * 6)
    shifts = np.array([0.0, 0.1, -0.1, 0.25, 0.5, 2.0])
    expected = np.minimum(np.abs(shifts), 1.0)
    np.testing.assert_allclose(ks_distances(reference + shifts, reference), expected, atol=2e-3)
    # F_a jumps by 1/2 at 0 and 1; F_b by 1/4, 1/4, 1/2 at 0, 1, 2: largest gap 1/2 at 1
    two, four = np.array([[0.0, 1.0]]).T, np.array([[0.0, 1.0, 2.0, 2.0]]).T
    assert ks_distances(two, four)[0] == 0.5
    # shifts that do not count
    assert (ks_distances(reference + shifts, reference, np.abs(shifts).max() + 1e-9) < 0.02).all()


class TestSlicedWasserstein:
    @pytest.mark.parametrize("variable", [0, 4])
    def test_shift_of_one_variable(self, variable):
        # Every projection moves by shift * |theta_k| standard deviations, and the mean of
        # |theta_k| over the unit sphere of R^6 is Gamma(3) / (sqrt(pi) Gamma(7/2)). The spread of
        # |theta_k| is 0.23, so 4,000 directions give it to 0.0036; the bound is 5 times that
        # (false alarm 6e-7).
        reference = 3.0 * normal(1, 50) + 7.0
        shifted = reference.copy()
        shifted[:, variable] += 0.5 * reference[:, variable].std()
        expected = 0.5 * math.gamma(3.0) / (math.sqrt(math.pi) * math.gamma(3.5))
        measured = sliced_wasserstein(shifted, reference, Settings(0, 4_000)).value
        assert measured == pytest.approx(expected, abs=0.5 * 5 * 0.0036)

    def test_unequal_sizes_against_scipy_on_the_line(self):
        rng = np.random.default_rng(5)
        a, b = rng.standard_normal((70, 1)), 0.3 + 2.0 * rng.standard_normal((45, 1))
        expected = wasserstein_distance(a[:, 0], b[:, 0]) / b.std()
        assert sliced_wasserstein(a, b, Settings()).value == pytest.approx(expected, rel=1e-3)


def test_every_metric_has_its_function_and_the_file_stores_metrics_only():
    assert list(ESTIMATES) == list(METRICS)
    stored = {d.path: len(d.dims) for d in DATASETS if d.path.startswith("accuracy/")}
    known = {f"accuracy/{n}": 1 + (n == "ks") for n in METRICS}
    assert stored == known | {"accuracy/alpha_deg": 1, "accuracy/speed": 1}
