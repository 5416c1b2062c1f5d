"""Metrics against closed forms, and proof that each rejects what it must.

Seeds are fixed. Where a bound is statistical its false-alarm rate, had the seed been random, is
stated beside it.
"""

import json
import math

import numpy as np
import pytest
from scipy.stats import wasserstein_distance

from sampler.errors import InputError
from sampler.formats.layout import DATASETS
from tablegen.accuracy.comparison import compare
from tablegen.accuracy.descriptive import (
    modes,
    profile,
    scattering_angles,
    translational_energy,
)
from tablegen.accuracy.metrics import (
    DISTANCES,
    Reference,
    classifier_auc,
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


def states(seed, count=COUNT):
    """States that leave the wall, with an energy below 1."""
    u, v, w = np.random.default_rng(seed).uniform(-0.5, 0.5, (3, count))
    spin = np.random.default_rng(seed + 1).standard_normal((count, 3))
    return np.column_stack((u, v + 0.5, w, spin))


#: Of each metric: the most that two samples of one law may differ, and the least that one differs
#: from another with the same marginals, every dependence destroyed.
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
    if name == "ks":
        assert ks_distances(independent_marginals(sample, 2), sample).max() == 0.0


class TestKolmogorovSmirnov:
    def test_shifted_uniforms(self):
        grid = (np.arange(1000) + 0.5) / 1000.0
        reference = np.column_stack([grid] * 6)
        shifts = np.array([0.0, 0.1, -0.1, 0.25, 0.5, 2.0])
        expected = np.minimum(np.abs(shifts), 1.0)
        np.testing.assert_allclose(ks_distances(reference + shifts, reference), expected, atol=2e-3)

    def test_unequal_sizes_and_ties(self):
        # F_a jumps by 1/2 at 0 and 1; F_b by 1/4, 1/4, 1/2 at 0, 1, 2: largest gap 1/2 at 1.
        assert ks_distances([[0.0], [1.0]], [[0.0], [1.0], [2.0], [2.0]])[0] == 0.5

    def test_sees_a_shifted_marginal_in_its_component_only(self):
        shifted = correlated(1)
        shifted[:, 3] += 0.1
        distances = ks_distances(shifted, correlated(2))
        bound = 2.9 * math.sqrt(2.0 / COUNT)
        # A shift by d moves a standard normal by 2 Phi(d/2) - 1, here 0.0399.
        assert distances[3] > bound
        assert np.delete(distances, 3).max() < bound


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

    def test_identical_samples(self):
        sample = correlated(1, count=500)
        assert sliced_wasserstein(sample[::-1], sample) == 0.0

    def test_directions_follow_the_seed(self):
        a, b = correlated(1, count=500), correlated(2, count=500)
        assert sliced_wasserstein(a, b, seed=3) == sliced_wasserstein(a, b, seed=3)
        assert sliced_wasserstein(a, b, seed=3) != sliced_wasserstein(a, b, seed=4)

    def test_constant_component_is_not_scaled(self):
        reference = np.column_stack((correlated(1, count=100)[:, 0], np.full(100, 0.3)))
        shifted = reference + np.array([0.0, 0.25])
        # In the plane the mean of |cos| is 2/pi, spread 0.31; 5 sigma of 20,000 directions.
        measured = sliced_wasserstein(shifted, reference, directions=20_000)
        assert measured == pytest.approx(0.25 * 2.0 / math.pi, abs=0.25 * 5 * 0.31 / 141.0)


class TestCorrelationError:
    def test_known_correlations(self):
        line = np.linspace(-1.0, 1.0, 201)
        rising = np.column_stack((line, line, line**2))
        falling = np.column_stack((line, -line, line**2))
        assert correlation_error(rising, falling) == pytest.approx(2.0, abs=1e-12)
        assert correlation_error(rising, 5.0 * rising - 2.0) == pytest.approx(0.0, abs=1e-12)

    def test_constant_component_correlates_with_nothing(self):
        line = np.linspace(-1.0, 1.0, 201)
        constant = np.column_stack((line, np.full(201, 0.1)))
        assert correlation_error(constant, constant) == 0.0
        assert correlation_error(constant, np.column_stack((line, line))) == pytest.approx(1.0)


class TestClassifier:
    def test_separated_samples(self):
        sample = correlated(1, count=400)
        assert classifier_auc(sample + 20.0, sample) == 1.0

    def test_repeats_with_its_seed(self):
        a, b = correlated(1, count=400), correlated(2, count=300)
        assert classifier_auc(a, b, seed=7) == classifier_auc(a, b, seed=7)
        assert classifier_auc(a, b, seed=7) != classifier_auc(a, b, seed=8)


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

    def test_one_of_two_equal_peaks(self):
        rng = np.random.default_rng(12)
        half = rng.normal(0.16, 0.04, 50_000)
        peak = modes(np.concatenate((half, -half))[:, np.newaxis])[0]
        assert abs(peak) == pytest.approx(0.16, abs=0.02)

    def test_shared_value_and_constant(self):
        sample = np.column_stack((np.r_[np.full(60, 0.7), np.linspace(0, 9, 40)], np.full(100, -2)))
        np.testing.assert_array_equal(modes(sample), [0.7, -2.0])

    def test_far_outlier(self):
        sample = np.random.default_rng(13).normal(size=(10_000, 1))
        sample[0] = 1e3
        assert abs(modes(sample)[0]) < 0.5


class TestStateFunctions:
    STATE = np.array(
        [
            [0.5, 0.5, 0.0, 9.0, 9.0, 9.0],
            [-0.3, 0.3, 0.0, 9.0, 9.0, 9.0],
            [0.0, 0.6, 0.6, 9.0, 9.0, 9.0],
            [0.3, 0.4, -0.5, 9.0, 9.0, 9.0],
        ]
    )

    def test_scattering_angles(self):
        alpha2, beta2 = scattering_angles(self.STATE)
        pi = math.pi
        np.testing.assert_allclose(alpha2, [pi / 4, 3 * pi / 4, pi / 2, math.atan2(0.4, 0.3)])
        np.testing.assert_allclose(beta2, [0.0, 0.0, pi / 4, -pi / 4], atol=1e-15)

    def test_angles_rebuild_the_direction(self):
        state = states(21, count=1000)
        alpha2, beta2 = scattering_angles(state)
        assert alpha2.min() > 0.0
        assert alpha2.max() < math.pi
        speed = np.sqrt(translational_energy(state))
        direction = np.column_stack(
            (np.cos(beta2) * np.cos(alpha2), np.cos(beta2) * np.sin(alpha2), np.sin(beta2))
        )
        np.testing.assert_allclose(speed[:, np.newaxis] * direction, state[:, :3], atol=1e-14)

    def test_energy_has_no_part_of_the_spin(self):
        np.testing.assert_allclose(translational_energy(self.STATE), [0.5, 0.18, 0.72, 0.5])


class TestComparison:
    def test_holds_what_the_functions_say(self):
        table, direct = states(31, count=2000), states(41, count=1500)
        result = compare(table, direct, alpha_deg=42.5, speed=140.0, seed=3)
        assert (result.alpha_deg, result.speed, result.states) == (42.5, 140.0, 1500)
        settings = Settings(seed=3)
        assert result.estimates == {n: of(table, direct, settings) for n, of in ESTIMATES.items()}
        assert result.distances()["ks"] == ks_distances(table, direct).tolist()
        assert (result.table, result.direct) == (profile(table), profile(direct))

    def test_profile(self):
        table = states(31, count=2000)
        numbers = profile(table)
        assert numbers.count == 2000
        np.testing.assert_array_equal(numbers.mean, table.mean(axis=0))
        np.testing.assert_array_equal(numbers.standard_deviation, table.std(axis=0))
        np.testing.assert_array_equal(numbers.mode, modes(table))
        assert numbers.translational_energy == translational_energy(table).mean()
        angles = np.degrees(scattering_angles(table))
        np.testing.assert_allclose(numbers.scattering_mean_deg, angles.mean(axis=1))
        np.testing.assert_allclose(numbers.scattering_standard_deviation_deg, angles.std(axis=1))

    def test_dictionary_survives_json(self):
        result = compare(states(31, count=200), states(41, count=200), 42.5, 140.0).to_dict()
        assert json.loads(json.dumps(result, allow_nan=False)) == result
        assert result["components"] == ["u", "v", "w", "omega_x", "omega_y", "omega_z"]
        assert len(result["ks"]) == len(result["table"]["mode"]) == 6


class TestReference:
    """One reference for many samples gives what its states give."""

    @pytest.mark.parametrize("name", DISTANCES)
    def test_distances_are_the_same(self, name):
        states_, distance = correlated(1, count=3000), DISTANCES[name]
        reference = Reference(states_)
        # the second sample repeats a few states, as a store drawn from with replacement does
        few = correlated(3, count=20)[np.random.default_rng(4).integers(20, size=1000)]
        for sample in (correlated(2, count=700) + 0.3, few):
            expected = distance(sample, states_, 32, 5)
            np.testing.assert_array_equal(distance(sample, reference, 32, 5), expected)


def test_every_metric_has_its_functions():
    assert list(DISTANCES) == list(ESTIMATES) == list(METRICS)


def test_what_the_file_format_stores_is_a_metric():
    """`sampler` cannot import the table of metrics; the format has a list of its own."""
    stored = {d.path: len(d.dims) for d in DATASETS if d.path.startswith("accuracy/")}
    known = {f"accuracy/{n}": 1 + m.per_variable for n, m in METRICS.items()}
    conditions = {"accuracy/alpha_deg": 1, "accuracy/speed": 1}
    assert stored.items() <= (known | conditions).items()
    assert len(stored) > len(conditions)


@pytest.mark.parametrize("name", DISTANCES)
class TestBadSamples:
    @pytest.fixture
    def metric(self, name):
        return lambda sample, reference: DISTANCES[name](sample, reference, 64, 0)

    def test_not_finite(self, metric):
        sample = correlated(1, count=100)
        broken = sample.copy()
        broken[17, 2] = np.nan
        with pytest.raises(InputError, match=r"^reference: got nan at \[17, 2\], allowed: finite"):
            metric(sample, broken)

    def test_shapes(self, metric):
        sample = correlated(1, count=100)
        with pytest.raises(InputError, match=r"^sample: got 5 columns, allowed: 6"):
            metric(sample[:, :5], sample)
        with pytest.raises(InputError, match=r"^sample: got shape \(1, 6\), allowed: \(n, d\)"):
            metric(sample[:1], sample)
        with pytest.raises(InputError, match=r"^sample: got shape \(100,\), allowed: \(n, d\)"):
            metric(sample[:, 0], sample)


def test_state_functions_want_six_components():
    with pytest.raises(InputError, match=r"^state: got shape \(10, 5\), allowed: \(n, 6\)$"):
        translational_energy(np.zeros((10, 5)))
    with pytest.raises(InputError, match=r"^directions: got 0, allowed: at least 1$"):
        sliced_wasserstein(np.eye(6), np.eye(6), directions=0)
