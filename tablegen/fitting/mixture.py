"""Gaussian mixture fitted by expectation-maximisation.

The logarithm of a Gaussian density is linear in the 28 monomials 1, z_i, z_i z_j of a 6-vector.
Both steps of EM are then one matrix product each: log-densities = features @ weights, and
sufficient statistics = responsibilities^T @ features.

A law with a mirror symmetry M = diag(+1, +1, +1, -1, -1, -1) is fitted as

    p(z) = sum_k pi_k (N(z; mu_k, S_k) + N(M z; mu_k, S_k)) / 2,

which has the symmetry exactly and makes each stored component count twice. M only changes the
sign of some monomials, so the reflected half needs no features of its own.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: Rows of one block: its responsibilities stay in the cache.
_BLOCK = 1024

#: Added to every variance (normal scores have variance one). It keeps components that sit on a
#: lower-dimensional part of the law, such as near-spheres, from collapsing.
RIDGE = 1e-4


@dataclass(frozen=True)
class Mixture:
    """Gaussian mixture of K components in d dimensions.

    Attributes
    ----------
    weight : (K,) float64
    mean : (K, d) float64
    covariance : (K, d, d) float64
    mirror : (d,) float64
        Signs of the reflection that the law is symmetric under; all ones if there is none.
    """

    weight: FloatArray
    mean: FloatArray
    covariance: FloatArray
    mirror: FloatArray


def _monomials(z: FloatArray) -> FloatArray:
    """Features 1, z_i and z_i z_j (i <= j) of each row."""
    upper = np.triu_indices(z.shape[1])
    return np.hstack([np.ones((len(z), 1)), z, z[:, upper[0]] * z[:, upper[1]]])


def _log_density_weights(mixture: Mixture) -> FloatArray:
    """Coefficients, (features, K), of log(weight * density) on the monomials."""
    dimension = mixture.mean.shape[1]
    precision = np.linalg.inv(mixture.covariance)
    linear = np.einsum("kij,kj->ki", precision, mixture.mean)
    constant = np.log(mixture.weight) - 0.5 * dimension * np.log(2.0 * np.pi)
    constant += 0.5 * np.linalg.slogdet(precision)[1]
    constant -= 0.5 * np.einsum("ki,ki->k", linear, mixture.mean)
    i, j = np.triu_indices(dimension)
    quadratic = -precision[:, i, j] * np.where(i == j, 0.5, 1.0)
    return np.vstack([constant, linear.T, quadratic.T])


def _expectation(
    features: FloatArray, weights: FloatArray, signs: FloatArray | None
) -> tuple[FloatArray, float]:
    """Sufficient statistics (K, features) and mean log-likelihood."""
    count = weights.shape[1]
    if signs is not None:
        weights = (
            np.hstack([weights, weights * signs[:, None]])
            - np.log(2.0) * (np.arange(len(weights)) == 0)[:, None]
        )
    statistics = np.zeros((weights.shape[1], features.shape[1]))
    total = 0.0
    for start in range(0, len(features), _BLOCK):
        block = features[start : start + _BLOCK]
        table = block @ weights
        peak = table.max(axis=1, keepdims=True)
        table -= peak
        np.exp(table, out=table)
        mass = table.sum(axis=1, keepdims=True)
        table /= mass
        total += float(np.log(mass).sum() + peak.sum())
        statistics += table.T @ block
    if signs is not None:
        statistics = statistics[:count] + statistics[count:] * signs
    return statistics, total / len(features)


def _maximisation(statistics: FloatArray, mirror: FloatArray, dimension: int) -> Mixture:
    """Mixture that maximises the expected likelihood; empty components are dropped."""
    mass = statistics[:, 0]
    # a component needs more points than it has directions to have a covariance of its own
    alive = mass > dimension + 1.0
    statistics, mass = statistics[alive], mass[alive]
    mean = statistics[:, 1 : dimension + 1] / mass[:, None]
    i, j = np.triu_indices(dimension)
    second = np.empty((len(mass), dimension, dimension))
    second[:, i, j] = statistics[:, dimension + 1 :] / mass[:, None]
    second[:, j, i] = second[:, i, j]
    covariance = second - mean[:, :, None] * mean[:, None, :] + RIDGE * np.eye(dimension)
    return Mixture(mass / mass.sum(), mean, covariance, mirror)


def _start(z: FloatArray, components: int, mirror: FloatArray, rng: np.random.Generator) -> Mixture:
    """Components at random points, all with a shrunken covariance of the sample."""
    mean = z[rng.choice(len(z), components, replace=False)]
    covariance = 0.1 * np.cov(z.T) + RIDGE * np.eye(z.shape[1])
    return Mixture(
        np.full(components, 1.0 / components),
        mean,
        np.repeat(covariance[None], components, axis=0),
        mirror,
    )


def improve(mixture: Mixture, z: FloatArray, iterations: int, gain: float) -> tuple[Mixture, float]:
    """Run EM from a mixture until an iteration gains less than ``gain`` in mean log-likelihood.

    Parameters
    ----------
    mixture : Mixture
    z : (n, d) float64
    iterations : int
        Most iterations.
    gain : float

    Returns
    -------
    tuple (Mixture, mean log-likelihood before the last step)
    """
    dimension = z.shape[1]
    features = _monomials(z)
    reflected = bool((mixture.mirror < 0.0).any())
    signs = _monomials(mixture.mirror[None])[0] if reflected else None
    last = -np.inf
    for _ in range(iterations):
        statistics, likelihood = _expectation(features, _log_density_weights(mixture), signs)
        mixture = _maximisation(statistics, mixture.mirror, dimension)
        if likelihood - last < gain:
            break
        last = likelihood
    return mixture, likelihood


def fit_mixture(
    z: FloatArray,
    components: int,
    rng: np.random.Generator,
    mirror: FloatArray | None = None,
    iterations: int = 60,
) -> Mixture:
    """Fit a Gaussian mixture with full covariances.

    A part of the sample brings the components near their places cheaply; the whole sample then
    settles them.

    Parameters
    ----------
    z : (n, d) float64
        Normal scores.
    components : int
        Fewer are fitted if there are fewer than d + 1 points for each; those that lose their
        points are dropped.
    rng : numpy Generator
        Chooses the starting points.
    mirror : (d,) float64, optional
        Signs of a reflection to be symmetric under.
    iterations : int
        Most EM iterations on the whole sample.

    Returns
    -------
    Mixture
    """
    signs = np.ones(z.shape[1]) if mirror is None else np.asarray(mirror, dtype=np.float64)
    part = z[: max(100 * components, 2000)]
    # with more points than this on average, one component at least is always alive
    most = max((len(part) - 1) // (z.shape[1] + 1), 1)
    mixture = _start(part, min(components, most), signs, rng)
    mixture, _ = improve(mixture, part, 60, 1e-4)
    mixture, _ = improve(mixture, z, iterations, 2e-5)
    return mixture


def sample_mixture(mixture: Mixture, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw from a mixture; for tests and for judging a fit, not for tables."""
    component = rng.choice(len(mixture.weight), size=count, p=mixture.weight)
    factor = np.linalg.cholesky(mixture.covariance)
    z = mixture.mean[component]
    z = z + np.einsum("nij,nj->ni", factor[component], rng.standard_normal(z.shape))
    flip = rng.integers(0, 2, size=(count, 1)) == 1
    return np.where(flip, z * mixture.mirror, z)
