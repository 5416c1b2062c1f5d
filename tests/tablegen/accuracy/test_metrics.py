"""Metrics against closed forms, and proof that each rejects a wrong sample.

Seeds are fixed. Where a bound is statistical, its false-alarm rate for a random seed is stated.
"""

import json
import math

import numpy as np
import pytest
from scipy.stats import wasserstein_distance

from sampler.formats.layout import DATASETS
from tablegen.accuracy.comparison import compare
from tablegen.accuracy.descriptive import modes, profile, scattering_angles, translational_energy
from tablegen.accuracy.metrics import (
    DISTANCES,
    RESOLUTION,
    at_resolution,
    correlation_error,
    ks_distances,
    sliced_wasserstein,
)
from tablegen.accuracy.noise_corrected import ESTIMATES, Settings
from tablegen.config.metric_table import METRICS

COUNT = 20_000


def correlated(seed, count=COUNT, correlation=0.6):
    """Standard normal 6-vectors with the same correlation between any two components."""
    factor = np.linalg.cholesky(np.full((6, 6), correlation) + (1.0 - correlation) * np.eye(6))
    return np.random.default_rng(seed).standard_normal((count, 6)) @ factor.T


def independent_marginals(sample, seed):
    """The same marginals to the last bit, every dependence destroyed."""
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.permutation(column) for column in sample.T])


#: Most that two samples of one law may differ, and least that one differs from another with the
#: same marginals and no dependence, by metric.
#:
#: ks: P(D sqrt(n/2) > 2.9) = 2 exp(-2 * 2.9^2) = 1e-7 a variable; it is blind to dependence.
#: sliced_wasserstein: noise is largest along the main axis, of variance 4: a mean off by 7 standard
#: errors of 2 sqrt(2/n) there, at a mean cosine of 0.34, makes 0.05; false alarm below 1e-11.
#: correlation_error: the difference of two correlations of 0.6 has standard error 0.64 sqrt(2/n) =
#: 0.0064; six of them for any of 15 pairs: 3e-8.
#: auc: for two times m held-out rows of one law its standard deviation is 1/sqrt(6 m); five: 6e-7.
POWER = {
    "ks": (2.9 * math.sqrt(2.0 / COUNT), 0.0),
    "sliced_wasserstein": (0.05, 0.1),
    "correlation_error": (6 * 0.0064, 0.55),
    "auc": (0.5 + 5.0 / math.sqrt(6.0 * COUNT / 2), 0.8),
}


@pytest.mark.parametrize("name", METRICS)
def test_one_law_passes_and_independent_marginals_do_not(name):
    sample, reference = correlated(1), correlated(2)
    same, other = POWER[name]
    assert np.max(DISTANCES[name](sample, reference, 64, 0)) < same
    assert np.max(DISTANCES[name](independent_marginals(sample, 3), reference, 64, 0)) > other


def test_kolmogorov_smirnov_of_shifted_uniforms():
    grid = (np.arange(1000) + 0.5) / 1000.0
    reference = np.column_stack([grid] * 6)
    shifts = np.array([0.0, 0.1, -0.1, 0.25, 0.5, 2.0])
    expected = np.minimum(np.abs(shifts), 1.0)
    np.testing.assert_allclose(ks_distances(reference + shifts, reference), expected, atol=2e-3)
    # F_a jumps by 1/2 at 0 and 1; F_b by 1/4, 1/4, 1/2 at 0, 1, 2: largest gap 1/2 at 1
    two, four = np.array([[0.0, 1.0]]).T, np.array([[0.0, 1.0, 2.0, 2.0]]).T
    assert ks_distances(two, four)[0] == 0.5


class TestSlicedWasserstein:
    @pytest.mark.parametrize("component", [0, 4])
    def test_shift_of_one_component(self, component):
        # Every projection moves by shift * |theta_k| standard deviations, and the mean of
        # |theta_k| over the unit sphere of R^6 is Gamma(3) / (sqrt(pi) Gamma(7/2)). The spread of
        # |theta_k| is 0.23, so 20,000 directions give it to 0.0016; the bound is 5 times that
        # (false alarm 6e-7).
        reference = 3.0 * correlated(1, count=50) + 7.0
        shifted = reference.copy()
        shifted[:, component] += 0.5 * reference[:, component].std()
        expected = 0.5 * math.gamma(3.0) / (math.sqrt(math.pi) * math.gamma(3.5))
        measured = sliced_wasserstein(shifted, reference, directions=20_000)
        assert measured == pytest.approx(expected, abs=0.5 * 5 * 0.0016)

    def test_unequal_sizes_against_scipy_on_the_line(self):
        rng = np.random.default_rng(5)
        a, b = rng.standard_normal((70, 1)), 0.3 + 2.0 * rng.standard_normal((45, 1))
        expected = wasserstein_distance(a[:, 0], b[:, 0]) / b.std()
        assert sliced_wasserstein(a, b) == pytest.approx(expected, rel=1e-12)


def test_correlation_error_of_known_correlations():
    line = np.linspace(-1.0, 1.0, 201)
    rising = np.column_stack((line, line, line**2))
    falling = np.column_stack((line, -line, line**2))
    assert correlation_error(rising, falling) == pytest.approx(2.0, abs=1e-12)
    assert correlation_error(rising, 5.0 * rising - 2.0) == pytest.approx(0.0, abs=1e-12)
    # a constant correlates with nothing
    constant = np.column_stack((line, np.full(201, 0.1)))
    assert correlation_error(constant, np.column_stack((line, line))) == pytest.approx(1.0)


class TestModes:
    def test_peaks_of_known_densities(self):
        # Columns: normal (mode 1, mean 1), gamma of shape 3 (mode 2, mean 3), exponential (mode at
        # its edge 0, mean 1), 60 % narrow and 40 % broad normal (mode -1, mean 0.2). Bounds are
        # twice the largest error over 20 seeds or more, and far below the distance to the mean.
        rng = np.random.default_rng(11)
        narrow = rng.random(100_000) < 0.6
        sample = np.column_stack(
            (
                rng.normal(1.0, 1.0, 100_000),
                rng.gamma(3.0, 1.0, 100_000),
                rng.exponential(1.0, 100_000),
                np.where(narrow, rng.normal(-1, 0.2, 100_000), rng.normal(2, 0.6, 100_000)),
            )
        )
        error = np.abs(modes(sample) - [1.0, 2.0, 0.0, -1.0])
        assert (error < [0.1, 0.25, 0.05, 0.05]).all()
        assert np.abs(sample.mean(axis=0) - [1.0, 2.0, 0.0, -1.0])[1:].min() > 0.9

    def test_shared_value_constant_and_far_outlier(self):
        sample = np.column_stack((np.r_[np.full(60, 0.7), np.linspace(0, 9, 40)], np.full(100, -2)))
        np.testing.assert_array_equal(modes(sample), [0.7, -2.0])
        sample = np.random.default_rng(13).normal(size=(10_000, 1))
        sample[0] = 1e3
        assert abs(modes(sample)[0]) < 0.5


def test_scattering_angles_and_energy():
    state = np.array([[0.5, 0.5, 0.0], [-0.3, 0.3, 0.0], [0.0, 0.6, 0.6], [0.3, 0.4, -0.5]])
    state = np.hstack((state, np.full((4, 3), 9.0)))
    alpha2, beta2 = scattering_angles(state)
    pi = math.pi
    np.testing.assert_allclose(alpha2, [pi / 4, 3 * pi / 4, pi / 2, math.atan2(0.4, 0.3)])
    np.testing.assert_allclose(beta2, [0.0, 0.0, pi / 4, -pi / 4], atol=1e-15)
    np.testing.assert_allclose(translational_energy(state), [0.5, 0.18, 0.72, 0.5])


def test_comparison_holds_the_numbers_of_its_functions():
    table, direct = 0.1 * correlated(31, count=2000), 0.1 * correlated(41, count=1500)
    result = compare(table, direct, alpha_deg=42.5, speed=140.0, seed=3)
    settings, blurred = Settings(seed=3), (at_resolution(table, 0), at_resolution(direct, 1))
    assert result.estimates == {n: of(*blurred, settings) for n, of in ESTIMATES.items()}
    assert result.distances()["ks"] == ks_distances(*blurred).tolist()
    assert (result.table, result.direct, result.states) == (profile(table), profile(direct), 1500)
    angles = np.degrees(scattering_angles(table))
    np.testing.assert_allclose(result.table.scattering_mean_deg, angles.mean(axis=1))
    assert json.loads(json.dumps(result.to_dict(), allow_nan=False))["states"] == 1500


def test_less_than_the_resolution_counts_as_nothing():
    """Rounding dust, both of one sign and of two, looks like zero; ten resolutions do not."""
    direct = 0.1 * correlated(51, count=20_000)
    direct[:, 0], direct[:, 1] = 6e-17, 1e-17 * np.sign(direct[:, 2])
    table = 0.1 * correlated(52, count=20_000)
    table[:, :2] = 0.0
    found = compare(table, direct, 90.0, 97.0).estimates
    # the first depends on the noise alone; the others fail for one seed in a thousand
    assert max(found["ks"].by_variable[:2]) < 0.02
    assert found["correlation_error"].value < 0.05
    assert found["auc"].value < 0.53
    table[:, 0] = 10.0 * RESOLUTION
    found = compare(table, direct, 90.0, 97.0).estimates
    assert min(found["ks"].by_variable[0], found["auc"].value) > 0.99


def test_every_metric_has_its_functions_and_the_file_stores_metrics_only():
    assert list(DISTANCES) == list(ESTIMATES) == list(METRICS)
    stored = {d.path: len(d.dims) for d in DATASETS if d.path.startswith("accuracy/")}
    known = {f"accuracy/{n}": 1 + (n == "ks") for n in METRICS}
    conditions = {"accuracy/alpha_deg": 1, "accuracy/speed": 1}
    assert stored.items() <= (known | conditions).items()
    assert len(stored) > len(conditions)
