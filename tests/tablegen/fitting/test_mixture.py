"""Gaussian mixtures: the density, the ascent of EM, the mirror, and laws that are found again."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from tablegen.fitting.mixture import RIDGE, Mixture, fit_mixture, improve, sample_mixture

MIRROR = np.array([1.0, 1.0, -1.0])
PLAIN = np.ones(3)

#: Signs of the channels under reflection, and probabilities of four components to be reflected.
REFLECTIONS = [(PLAIN, 0.0), (MIRROR, 0.5), (MIRROR, [0.2, 0.4, 0.9, 0.7])]
REFLECTION_IDS = ["plain", "mirrored", "partly reflected"]


def random_mixture(seed, components, dimension=3, mirror=None, reflection=0.5):
    """Mixture with weights, means and covariances of every kind, none of them degenerate."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((components, dimension, dimension))
    covariance = root @ root.transpose(0, 2, 1) / dimension + 0.1 * np.eye(dimension)
    weight = rng.dirichlet(np.full(components, 5.0))
    mean = 1.5 * rng.standard_normal((components, dimension))
    signs = np.ones(dimension) if mirror is None else mirror
    share = np.broadcast_to(reflection if (signs < 0.0).any() else 0.0, components)
    return Mixture(weight, mean, covariance, share.astype(float), signs)


def plainly(mixture, signs=None):
    """The same components, never reflected, or each with probability 1/2 by some signs."""
    none = signs is None or (signs > 0.0).all()
    return replace(
        mixture,
        signs=PLAIN if signs is None else signs,
        reflection=np.full(len(mixture.weight), 0.0 if none else 0.5),
    )


def expanded(mixture):
    """The mixture without a mirror: every component and its reflection."""
    flip = np.diag(mixture.signs)
    share = mixture.reflection
    return Mixture(
        np.concatenate([mixture.weight * (1.0 - share), mixture.weight * share]),
        np.concatenate([mixture.mean, mixture.mean @ flip]),
        np.concatenate([mixture.covariance, flip @ mixture.covariance @ flip]),
        np.zeros(2 * len(share)),
        np.ones(len(flip)),
    )


def log_density(mixture, z):
    """Log-density of each row by scipy, component by component."""
    plain = expanded(mixture)
    terms = [
        np.log(weight) + multivariate_normal(mean, covariance).logpdf(z)
        for weight, mean, covariance in zip(plain.weight, plain.mean, plain.covariance, strict=True)
        if weight > 0.0
    ]
    return logsumexp(terms, axis=0)


def assert_same(a, b, tolerance=1e-10):
    for name in ("weight", "mean", "covariance"):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=0, atol=tolerance)


@pytest.fixture(scope="module")
def sample():
    return sample_mixture(random_mixture(1, 4), 5000, np.random.default_rng(2))


class TestDensity:
    """`improve` reports the mean log-density under the mixture that it was given."""

    @pytest.mark.parametrize(("mirror", "share"), REFLECTIONS, ids=REFLECTION_IDS)
    def test_is_that_of_scipy(self, sample, mirror, share):
        mixture = random_mixture(3, 4, mirror=mirror, reflection=share)
        _, likelihood = improve(mixture, sample, 1, 0.0)
        assert likelihood == pytest.approx(log_density(mixture, sample).mean(), abs=1e-10)
        other = random_mixture(4, 4, mirror=mirror, reflection=share)
        assert likelihood != pytest.approx(log_density(other, sample).mean(), abs=1e-3)

    def test_does_not_underflow_far_from_every_component(self):
        mixture = random_mixture(3, 5)
        far = 60.0 + np.random.default_rng(5).standard_normal((50, 3))
        _, likelihood = improve(mixture, far, 1, 0.0)
        assert likelihood < -500.0
        assert likelihood == pytest.approx(log_density(mixture, far).mean(), rel=1e-10)

    def test_mirrored_law_has_the_symmetry_exactly(self, sample):
        mixture = random_mixture(3, 5, mirror=MIRROR)
        _, here = improve(mixture, sample, 1, 0.0)
        _, there = improve(mixture, sample * MIRROR, 1, 0.0)
        assert here == pytest.approx(there, abs=1e-13)
        plain = random_mixture(3, 5)
        _, here = improve(plain, sample, 1, 0.0)
        _, there = improve(plain, sample * MIRROR, 1, 0.0)
        assert abs(here - there) > 1e-3


class TestExpectationMaximisation:
    @pytest.mark.parametrize(("mirror", "share"), REFLECTIONS, ids=REFLECTION_IDS)
    def test_every_step_raises_the_likelihood(self, sample, mirror, share):
        mixture = random_mixture(6, 4, mirror=mirror, reflection=share)
        likelihoods = []
        for _ in range(40):
            mixture, likelihood = improve(mixture, sample, 1, 0.0)
            likelihoods.append(likelihood)
        # The ridge gives up less than it; EM itself never falls.
        assert (np.diff(likelihoods) > -1e-2 * RIDGE).all()
        assert likelihoods[-1] - likelihoods[0] > 0.1

    def test_steps_add_up(self, sample):
        start = random_mixture(6, 4)
        single = start
        for _ in range(5):
            single, likelihood = improve(single, sample, 1, -np.inf)
        together, last = improve(start, sample, 5, -np.inf)
        assert_same(single, together)
        assert likelihood == pytest.approx(last, abs=1e-12)

    def test_one_component_is_the_moments(self, sample):
        mixture, _ = improve(random_mixture(7, 1), sample, 1, 0.0)
        np.testing.assert_allclose(mixture.weight, [1.0], rtol=1e-14)
        np.testing.assert_allclose(mixture.mean[0], sample.mean(axis=0), rtol=0, atol=1e-12)
        expected = np.cov(sample.T, bias=True) + RIDGE * np.eye(3)
        np.testing.assert_allclose(mixture.covariance[0], expected, rtol=0, atol=1e-12)

    def test_stops_when_it_gains_little(self, sample):
        start = random_mixture(6, 4)
        stopped, likelihood = improve(start, sample, 1000, 1e-3)
        before, _ = improve(start, sample, 1, 0.0)
        count = 1
        while True:
            count += 1
            before, here = improve(start, sample, count, -np.inf)
            if here - improve(start, sample, count - 1, -np.inf)[1] < 1e-3:
                break
        assert 2 < count < 100
        assert_same(stopped, before)
        assert likelihood == here

    def test_components_without_points_are_dropped(self, sample):
        mixture = random_mixture(6, 4)
        lost = Mixture(
            np.full(5, 0.2),
            np.concatenate([mixture.mean, [[500.0, 0.0, 0.0]]]),
            np.concatenate([mixture.covariance, [np.eye(3)]]),
            np.zeros(5),
            PLAIN,
        )
        found, _ = improve(lost, sample, 1, 0.0)
        kept = Mixture(np.full(4, 0.25), mixture.mean, mixture.covariance, np.zeros(4), PLAIN)
        assert found.weight.shape == (4,)
        assert_same(found, improve(kept, sample, 1, 0.0)[0])
        assert found.weight.sum() == pytest.approx(1.0, abs=1e-14)

    def test_degenerate_points_keep_the_ridge(self):
        """A sample on a line leaves covariances that can be factored."""
        line = np.random.default_rng(8).standard_normal((400, 1)) * np.array([1.0, 1.0, -2.0])
        mixture = fit_mixture(line, 6, np.random.default_rng(9))
        smallest = np.linalg.eigvalsh(mixture.covariance)[:, 0]
        assert (smallest > 0.99 * RIDGE).all()


class TestMirror:
    def test_is_the_fit_of_the_doubled_sample(self, sample):
        start = random_mixture(10, 3, mirror=MIRROR)
        doubled = np.concatenate([sample, sample * MIRROR])
        mirrored, likelihood = improve(start, sample, 10, -np.inf)
        plain, of_doubled = improve(expanded(start), doubled, 10, -np.inf)
        assert_same(expanded(mirrored), plain)
        assert likelihood == pytest.approx(of_doubled, abs=1e-12)
        # The sample alone, which is not symmetric, has another fit.
        alone, _ = improve(expanded(start), sample, 10, -np.inf)
        assert np.abs(alone.mean - plain.mean).max() > 0.05

    def test_sees_no_difference_between_a_point_and_its_reflection(self, sample):
        flips = np.random.default_rng(11).integers(0, 2, size=(len(sample), 1)) == 1
        start = random_mixture(10, 3, mirror=MIRROR)
        here, _ = improve(start, sample, 10, -np.inf)
        there, _ = improve(start, np.where(flips, sample * MIRROR, sample), 10, -np.inf)
        assert_same(here, there)


class TestRecovery:
    """Known laws; standard errors are those of the n weight points of a component."""

    TRUTH = Mixture(
        np.array([0.5, 0.3, 0.2]),
        np.array([[-2.0, 0.0, 1.5], [2.0, 1.0, 1.0], [0.5, -2.5, 2.5]]),
        np.array(
            [
                np.diag([0.5, 0.8, 0.3]),
                [[0.6, 0.4, 0.0], [0.4, 0.6, 0.1], [0.0, 0.1, 0.2]],
                [[0.3, -0.1, 0.0], [-0.1, 0.4, 0.0], [0.0, 0.0, 0.2]],
            ]
        ),
        np.zeros(3),
        PLAIN,
    )
    COUNT = 20_000
    #: Six standard errors of about sqrt(2 / (n weight)) at worst, variance one or below, and the
    #: little that the components overlap: 27 numbers leave it with probability below 1e-6.
    TOLERANCE = 6.0 * np.sqrt(2.0 / (0.2 * COUNT)) * 0.8 + 0.01

    @pytest.mark.parametrize("mirror", [PLAIN, MIRROR], ids=["plain", "mirrored"])
    def test_components_are_found_from_a_rough_start(self, mirror):
        truth = plainly(self.TRUTH, mirror)
        z = sample_mixture(truth, self.COUNT, np.random.default_rng(12))
        start = replace(
            truth,
            weight=np.full(3, 1.0 / 3.0),
            mean=truth.mean + 0.4,
            covariance=np.repeat(np.eye(3)[None], 3, axis=0),
        )
        found, _ = improve(start, z, 200, 1e-7)
        for name in ("weight", "mean", "covariance"):
            off = np.abs(getattr(found, name) - getattr(truth, name)).max()
            assert off < self.TOLERANCE, name
        # Refused: the start, and the components in another order.
        assert np.abs(start.mean - truth.mean).max() > self.TOLERANCE
        assert np.abs(found.mean[::-1] - truth.mean).max() > self.TOLERANCE

    def test_fit_is_as_likely_as_the_truth_on_fresh_points(self):
        """Difference of mean log-densities; noise and the cost of 100 parameters are 0.01."""
        truth = random_mixture(13, 3, dimension=6)
        z = sample_mixture(truth, self.COUNT, np.random.default_rng(14))
        fresh = sample_mixture(truth, self.COUNT, np.random.default_rng(15))
        best = log_density(truth, fresh).mean()
        fitted = fit_mixture(z, 8, np.random.default_rng(16))
        assert best - log_density(fitted, fresh).mean() < 0.02
        # Refused: a single Gaussian, and independent components.
        single = fit_mixture(z, 1, np.random.default_rng(16))
        assert best - log_density(single, fresh).mean() > 0.2
        diagonal = np.einsum("kij,ij->kij", fitted.covariance, np.eye(6))
        blind = replace(fitted, covariance=diagonal)
        assert best - log_density(blind, fresh).mean() > 0.2


class TestReflection:
    """Components that are reflected with probabilities of their own."""

    SHARES = np.array([0.05, 0.5, 0.8])

    def test_probabilities_are_found(self):
        """Binomial, of 0.2 COUNT points at least: six standard errors are 0.05."""
        truth = replace(TestRecovery.TRUTH, signs=MIRROR, reflection=self.SHARES)
        z = sample_mixture(truth, TestRecovery.COUNT, np.random.default_rng(31))
        start = replace(truth, reflection=np.array([0.4, 0.4, 0.6]), mean=truth.mean + 0.2)
        found, _ = improve(start, z, 300, 1e-8)
        assert np.abs(found.reflection - self.SHARES).max() < 0.05
        # Refused: equal probabilities, which a symmetric fit has by its making.
        symmetric, _ = improve(replace(start, reflection=np.full(3, 0.5)), z, 300, 1e-8)
        np.testing.assert_array_equal(symmetric.reflection, 0.5)
        fresh = sample_mixture(truth, TestRecovery.COUNT, np.random.default_rng(32))
        loss = log_density(found, fresh).mean() - log_density(symmetric, fresh).mean()
        assert loss > 0.05

    def test_a_symmetric_law_needs_half_the_components(self):
        truth = plainly(TestRecovery.TRUTH, MIRROR)
        z = sample_mixture(truth, TestRecovery.COUNT, np.random.default_rng(33))
        fresh = sample_mixture(truth, TestRecovery.COUNT, np.random.default_rng(34))
        best = log_density(truth, fresh).mean()
        with_reflection = fit_mixture(z, 4, np.random.default_rng(35), MIRROR)
        without = fit_mixture(z, 4, np.random.default_rng(35))
        loss = best - log_density(with_reflection, fresh).mean()
        assert loss < 0.5 * (best - log_density(without, fresh).mean())


class TestFit:
    def test_is_deterministic(self, sample):
        first = fit_mixture(sample, 8, np.random.default_rng(17), MIRROR, iterations=5)
        again = fit_mixture(sample, 8, np.random.default_rng(17), MIRROR, iterations=5)
        other = fit_mixture(sample, 8, np.random.default_rng(18), MIRROR, iterations=5)
        for name in ("weight", "mean", "covariance"):
            np.testing.assert_array_equal(getattr(first, name), getattr(again, name))
        assert first.mean.shape != other.mean.shape or not np.allclose(first.mean, other.mean)

    def test_more_components_than_points(self):
        z = np.random.default_rng(19).standard_normal((40, 3))
        fitted = fit_mixture(z, 100, np.random.default_rng(20))
        assert 1 <= len(fitted.weight) <= 40
        np.linalg.cholesky(fitted.covariance)

    def test_sample_has_the_moments_of_the_mixture(self):
        """Standard errors below 2 / sqrt(n); six of them fail with probability below 1e-7."""
        mixture = random_mixture(21, 4, mirror=MIRROR)
        count = 100_000
        z = sample_mixture(mixture, count, np.random.default_rng(22))
        plain = expanded(mixture)
        mean = plain.weight @ plain.mean
        spread = plain.mean - mean
        covariance = np.einsum("k,kij->ij", plain.weight, plain.covariance)
        covariance += np.einsum("k,ki,kj->ij", plain.weight, spread, spread)
        bound = 6.0 / np.sqrt(count) * covariance.max()
        assert np.abs(z.mean(axis=0) - mean).max() < bound
        assert np.abs(np.cov(z.T) - covariance).max() < 1.5 * bound
        # Refused: the same without the mirror.
        alone = sample_mixture(plainly(mixture), count, np.random.default_rng(22))
        assert np.abs(alone.mean(axis=0) - mean).max() > bound
