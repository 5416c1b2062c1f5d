"""Fit a Gaussian mixture to normal scores by expectation-maximisation (EM).

The density of the mixture at the scores z of a rebound is

    p(z) = sum_k pi_k ((1 - q_k) N(z; mu_k, S_k) + q_k N(M z; mu_k, S_k)).

M is the reflection in the impact plane: it changes the signs of some channels. Most particles have
mirror images among the other particles, so most of a law is symmetric under M. A component that may
be reflected counts twice where the law is symmetric. A law need not be symmetric, so the
probability q_k of each component is fitted.

The logarithm of a Gaussian density is linear in the monomials 1, z_i and z_i z_j; there are 28 of
them for six channels. So each step of EM is one matrix product: log-densities are features @
weights, and sufficient statistics are responsibilities^T @ features. M only changes the signs of
some monomials, so the reflected parts need no features of their own.

A fit begins with stepwise EM (Cappe and Moulines, J. R. Stat. Soc. B 71 (2009) 593-613): the
statistics are a running average over blocks of the sample, and each block moves the components. A
few passes over a large sample then do what dozens of whole iterations do.
"""

from dataclasses import dataclass

import numpy as np

from tablegen.fitting.expectation import Single, softmax
from tablegen.model.float_array import FloatArray

#: Rows of one block: its responsibilities fit into the cache.
_BLOCK = 256

#: Stepwise EM: points of a block for each component, and least points of a block.
_POINTS_PER_COMPONENT = 40
_LEAST_BLOCK = 4000
#: Passes over the sample.
_PASSES = 2
#: Block k has the weight (k + _DELAY)^-_DECAY in the running average.
_DELAY = 2.0
_DECAY = 0.6

#: During a fit, the probability that a component is reflected stays this far from 0 and from 1.
_LEAST_PART = 1e-3

#: Added to each variance (normal scores have variance one). Without it, components of a law that
#: has fewer dimensions than channels would collapse, as that of nearly round grains.
RIDGE = 1e-4


@dataclass(frozen=True)
class Mixture:
    """Gaussian mixture of K components in d dimensions."""

    #: (K,): weights, which add up to one.
    weight: FloatArray
    #: (K, d)
    mean: FloatArray
    #: (K, d, d)
    covariance: FloatArray
    #: (K,): probability that each component is reflected.
    reflection: FloatArray
    #: (d,): signs of the channels under reflection; all ones if the law has no reflection.
    signs: FloatArray


def monomials(z: FloatArray) -> Single:
    """Compute the features 1, z_i and z_i z_j (i <= j) of each row."""
    z = z.astype(np.float32)
    upper = np.triu_indices(z.shape[1])
    return np.hstack([np.ones_like(z[:, :1]), z, z[:, upper[0]] * z[:, upper[1]]])


def _log_density_weights(mixture: Mixture) -> FloatArray:
    """Compute the coefficients, (features, K), of log(weight * density) on the monomials."""
    dimension = mixture.mean.shape[1]
    precision = np.linalg.inv(mixture.covariance)
    linear = np.einsum("kij,kj->ki", precision, mixture.mean)
    constant = np.log(mixture.weight) - 0.5 * dimension * np.log(2.0 * np.pi)
    constant += 0.5 * np.linalg.slogdet(precision)[1]
    constant -= 0.5 * np.einsum("ki,ki->k", linear, mixture.mean)
    i, j = np.triu_indices(dimension)
    quadratic = -precision[:, i, j] * np.where(i == j, 0.5, 1.0)
    return np.vstack([constant, linear.T, quadratic.T])


def _expectation(features: Single, mixture: Mixture) -> tuple[FloatArray, float]:
    """Compute the sufficient statistics (K, features + 1) and the mean log-likelihood.

    The first column is the mass of each component, and the last column is the part of the mass that
    is reflected.
    """
    weights, signs = _log_density_weights(mixture), _mirror_signs(mixture.signs)
    count = weights.shape[1]
    if signs is not None:
        reflected = weights * signs[:, None]
        reflected[0] += np.log(mixture.reflection)
        weights[0] += np.log1p(-mixture.reflection)
        weights = np.hstack([weights, reflected])
    coefficients = np.ascontiguousarray(weights.T, dtype=np.float32)
    statistics = np.zeros((len(coefficients), features.shape[1]))
    total = 0.0
    for start in range(0, len(features), _BLOCK):
        block = features[start : start + _BLOCK]
        responsibility = coefficients @ block.T
        total += float(softmax(responsibility).sum(dtype=np.float64))
        statistics += responsibility @ block
    part = np.zeros(count) if signs is None else statistics[count:, 0].copy()
    if signs is not None:
        statistics = statistics[:count] + statistics[count:] * signs
    return np.column_stack([statistics, part]), total / len(features)


def _maximisation(
    statistics: FloatArray, mixture: Mixture, points: int
) -> tuple[Mixture, FloatArray]:
    """Find the mixture that maximises the expected likelihood.

    The statistics may be averages over ``points`` points. Components with too few points are
    dropped. Also returns the statistics of the components that stay.
    """
    dimension = mixture.mean.shape[1]
    # a component has a covariance of its own only if it has more points than dimensions
    alive = statistics[:, 0] * (points / statistics[:, 0].sum()) > dimension + 1.0
    statistics = statistics[alive]
    mass = statistics[:, 0]
    mean = statistics[:, 1 : dimension + 1] / mass[:, None]
    i, j = np.triu_indices(dimension)
    second = np.empty((len(mass), dimension, dimension))
    second[:, i, j] = statistics[:, dimension + 1 : -1] / mass[:, None]
    second[:, j, i] = second[:, i, j]
    covariance = second - mean[:, :, None] * mean[:, None, :] + RIDGE * np.eye(dimension)
    reflection = mixture.reflection[alive]
    if bool((mixture.signs < 0.0).any()):
        reflection = np.clip(statistics[:, -1] / mass, _LEAST_PART, 1.0 - _LEAST_PART)
    maximal = Mixture(mass / mass.sum(), mean, covariance, reflection, mixture.signs)
    return maximal, statistics


def _initial_mixture(
    z: FloatArray, components: int, signs: FloatArray, rng: np.random.Generator
) -> Mixture:
    """Make components at random points, each with a tenth of the covariance of the sample."""
    mean = z[rng.choice(len(z), components, replace=False)]
    covariance = 0.1 * np.cov(z.T).reshape(z.shape[1], -1) + RIDGE * np.eye(z.shape[1])
    reflected = 0.5 if bool((signs < 0.0).any()) else 0.0
    return Mixture(
        np.full(components, 1.0 / components),
        mean,
        np.repeat(covariance[None], components, axis=0),
        np.full(components, reflected),
        signs,
    )


def _mirror_signs(signs: FloatArray) -> FloatArray | None:
    """Find the signs of the monomials under the reflection, or None if there is no reflection."""
    return monomials(signs[None])[0] if bool((signs < 0.0).any()) else None


def iterate(mixture: Mixture, features: Single) -> tuple[Mixture, float]:
    """Take one iteration of EM over the `monomials` of a sample.

    Returns the new mixture, and the mean log-likelihood of the old one.
    """
    statistics, likelihood = _expectation(features, mixture)
    return _maximisation(statistics, mixture, len(features))[0], likelihood


def _stepwise(mixture: Mixture, features: Single) -> Mixture:
    """Improve a mixture by stepwise EM, block by block."""
    size = max(_POINTS_PER_COMPONENT * len(mixture.weight), _LEAST_BLOCK)
    blocks = max(len(features) // size, 1)
    average = None
    for k in range(_PASSES * blocks):
        first = (k % blocks) * len(features) // blocks
        last = (k % blocks + 1) * len(features) // blocks
        block = features[first:last]
        statistics, _ = _expectation(block, mixture)
        statistics /= len(block)
        if average is not None:
            step = (k + _DELAY) ** -_DECAY
            statistics = (1.0 - step) * average + step * statistics
        mixture, average = _maximisation(statistics, mixture, len(features))
    return mixture


def fit_mixture(
    z: FloatArray,
    components: int,
    rng: np.random.Generator,
    signs: FloatArray,
) -> Mixture:
    """Fit a Gaussian mixture with full covariances to normal scores.

    Parameters
    ----------
    z : (n, d) float64
        Normal scores, in random order.
    components : int
        Number of components. Fewer are fitted if there are at most d + 1 points for each.
        Components that lose their points in the fit are dropped.
    rng : numpy.random.Generator
        Chooses the points at which components begin.
    signs : (d,) float64
        Signs of the channels under reflection; all ones if the law has no reflection.

    Returns
    -------
    Mixture
    """
    # with more than d + 1 points for each component on average, at least one component stays
    most = max((len(z) - 1) // (z.shape[1] + 1), 1)
    mixture = _initial_mixture(z, min(components, most), signs, rng)
    features = monomials(z)
    mixture = _stepwise(mixture, features)
    # one iteration on the whole sample makes the weights those of the whole sample
    return iterate(mixture, features)[0]
