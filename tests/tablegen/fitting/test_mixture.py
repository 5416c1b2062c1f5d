"""Gaussian mixtures: the density, the ascent of EM, and laws that are found again."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from tablegen.fitting.mixture import RIDGE, Mixture, fit_mixture, iterate, monomials

MIRROR = np.array([1.0, 1.0, -1.0])
PLAIN = np.ones(3)

#: Signs of the channels under reflection, and probabilities of four components to be reflected.
REFLECTIONS = {
    "plain": (PLAIN, 0.0),
    "partly reflected": (MIRROR, [0.2, 0.4, 0.9, 0.7]),
}

#: Three components that hardly overlap.
TRUTH = Mixture(
    np.array([0.5, 0.3, 0.2]),
    np.array([[-2.0, 0.0, 1.5], [2.0, 1.0, 1.0], [0.5, -2.5, 2.5]]),
    np.array([np.diag([0.5, 0.8, 0.3]), np.diag([0.6, 0.6, 0.2]), np.diag([0.3, 0.4, 0.2])]),
    np.array([0.05, 0.5, 0.8]),
    MIRROR,
)
COUNT = 20_000


def random_mixture(seed, components, dimension=3, reflection="plain"):
    """Make a mixture with weights, means and covariances that are not degenerate."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((components, dimension, dimension))
    covariance = root @ root.transpose(0, 2, 1) / dimension + 0.1 * np.eye(dimension)
    weight = rng.dirichlet(np.full(components, 5.0))
    mean = 1.5 * rng.standard_normal((components, dimension))
    signs, share = REFLECTIONS[reflection]
    signs = signs if dimension == 3 else np.ones(dimension)
    return Mixture(
        weight, mean, covariance, np.broadcast_to(share, components).astype(float), signs
    )


def without_mirror(mixture):
    """Make the same law without a mirror: every component and its reflection."""
    flip, share = np.diag(mixture.signs), mixture.reflection
    return Mixture(
        np.concatenate([mixture.weight * (1.0 - share), mixture.weight * share]),
        np.concatenate([mixture.mean, mixture.mean @ flip]),
        np.concatenate([mixture.covariance, flip @ mixture.covariance @ flip]),
        np.zeros(2 * len(share)),
        np.ones(len(flip)),
    )


def log_density(mixture, z):
    """Compute the mean log-density by scipy, component by component."""
    plain = without_mirror(mixture)
    terms = [
        np.log(weight) + multivariate_normal(mean, covariance).logpdf(z)
        for weight, mean, covariance in zip(plain.weight, plain.mean, plain.covariance, strict=True)
        if weight > 0.0
    ]
    return logsumexp(terms, axis=0).mean()


def sample_mixture(mixture, count, rng):
    component = rng.choice(len(mixture.weight), size=count, p=mixture.weight)
    factor = np.linalg.cholesky(mixture.covariance)
    z = mixture.mean[component]
    z = z + np.einsum("nij,nj->ni", factor[component], rng.standard_normal(z.shape))
    flip = rng.random((count, 1)) < mixture.reflection[component][:, None]
    return np.where(flip, z * mixture.signs, z)


def improve(mixture, z, steps=1):
    """Take steps of EM; the mixture and the log-likelihood before each."""
    features, likelihoods = monomials(z), []
    for _ in range(steps):
        mixture, likelihood = iterate(mixture, features)
        likelihoods.append(likelihood)
    return mixture, likelihoods


@pytest.fixture(scope="module")
def sample():
    return sample_mixture(random_mixture(1, 4), 5000, np.random.default_rng(2))


@pytest.mark.parametrize("reflection", REFLECTIONS)
def test_likelihood_is_that_of_scipy_and_never_falls(sample, reflection):
    mixture = random_mixture(3, 4, reflection=reflection)
    _, likelihoods = improve(mixture, sample, 40)
    assert likelihoods[0] == pytest.approx(log_density(mixture, sample), abs=1e-5)
    far = 60.0 + sample[:50]
    assert improve(mixture, far)[1][0] == pytest.approx(log_density(mixture, far), rel=1e-4)
    # the ridge gives up less than its own size
    assert (np.diff(likelihoods) > -1e-2 * RIDGE).all()
    assert likelihoods[-1] - likelihoods[0] > 0.1


@pytest.mark.parametrize("n", [40, 400])
def test_points_on_a_line_and_few_points_keep_the_ridge(n):
    line = np.random.default_rng(8).standard_normal((n, 1)) * np.array([1.0, 1.0, -2.0])
    mixture = fit_mixture(line, 100, np.random.default_rng(9), PLAIN)
    assert 1 <= len(mixture.weight) <= n // 4
    assert (np.linalg.eigvalsh(mixture.covariance)[:, 0] > 0.99 * RIDGE).all()


def test_components_and_reflections_are_found():
    """Six standard errors, at most sqrt(2 / (0.2 COUNT)) each, and 0.01 for overlaps."""
    tolerance = 6.0 * np.sqrt(2.0 / (0.2 * COUNT)) * 0.8 + 0.01
    z = sample_mixture(TRUTH, COUNT, np.random.default_rng(12))
    start = replace(TRUTH, mean=TRUTH.mean + 0.3, reflection=np.array([0.4, 0.4, 0.6]))
    fitted, _ = improve(start, z, 100)
    for name in ("weight", "mean", "covariance", "reflection"):
        assert np.abs(getattr(fitted, name) - getattr(TRUTH, name)).max() < tolerance, name
    # refused: the start, components in another order, equal probabilities of reflection
    assert np.abs(start.mean - TRUTH.mean).max() > tolerance
    assert np.abs(fitted.mean[::-1] - TRUTH.mean).max() > tolerance
    symmetric = replace(fitted, reflection=np.full(3, 0.5))
    fresh = sample_mixture(TRUTH, COUNT, np.random.default_rng(32))
    assert log_density(fitted, fresh) - log_density(symmetric, fresh) > 0.05


def test_fit_is_as_likely_as_the_truth_on_fresh_points():
    """Difference of mean log-densities; noise and the cost of 100 parameters are 0.01.

    Two passes of stepwise EM leave as much again.
    """
    truth = random_mixture(13, 3, dimension=6)
    z = sample_mixture(truth, COUNT, np.random.default_rng(14))
    fresh = sample_mixture(truth, COUNT, np.random.default_rng(15))
    best = log_density(truth, fresh)
    fitted, single = (fit_mixture(z, k, np.random.default_rng(16), np.ones(6)) for k in (8, 1))
    assert best - log_density(fitted, fresh) < 0.025
    # refused: a single Gaussian, and independent channels
    assert best - log_density(single, fresh) > 0.2
    diagonal = np.einsum("kij,ij->kij", fitted.covariance, np.eye(6))
    assert best - log_density(replace(fitted, covariance=diagonal), fresh) > 0.2
