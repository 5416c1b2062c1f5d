"""Gaussian mixture fitted by expectation-maximisation.

The logarithm of a Gaussian density is linear in the 28 monomials 1, z_i, z_i z_j of a 6-vector.
Both steps of EM are then one matrix product each: log-densities = features @ weights, and
sufficient statistics = responsibilities^T @ features.

A fit begins with stepwise EM (Cappe and Moulines, J. R. Stat. Soc. B 71 (2009) 593-613): the
statistics are a running average over blocks of the sample, and every block moves the components.
A few passes over a large sample then do what dozens of whole iterations do.

Most particles have mirror images among the others, so most of a law is symmetric under reflection
in the impact plane, M = diag(+1, +1, +1, -1, -1, -1). Every component may therefore be reflected,
with a probability q_k of its own,

    p(z) = sum_k pi_k ((1 - q_k) N(z; mu_k, S_k) + q_k N(M z; mu_k, S_k)),

so that a stored component counts twice where the law is symmetric, and once where it is not. M only
changes the sign of some monomials, so the reflected
part needs no features of its own.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tablegen.model.float_array import FloatArray

#: Monomials of a sample, in double precision where every digit counts, else in single.
Features = NDArray[np.float64] | NDArray[np.float32]

#: Rows of one block: its responsibilities fit into the cache.
_BLOCK = 1024

#: Least log-density of a component at a point, relative to the largest: a share of e^-40 is lost in
#: rounding, while subnormal numbers are ten times slower to compute with.
_DEPTH = -40.0

#: Stepwise EM: points of a block for each component and at least, passes over the sample, and the
#: weight (k + _DELAY)^-_DECAY of block k in the running average.
_POINTS_PER_COMPONENT = 40
_LEAST_BLOCK = 4000
_PASSES = 2
_DELAY = 2.0
_DECAY = 0.6

#: Least probability of a component to be reflected, and not to be, during the fit.
_LEAST_PART = 1e-3

#: Added to every variance (normal scores have variance one). It keeps components on a
#: lower-dimensional part of the law, such as near-spheres, from collapsing.
RIDGE = 1e-4


@dataclass(frozen=True)
class Mixture:
    """Gaussian mixture of K components in d dimensions.

    Components are reflected with probabilities of their own. The signs are those of the channels
    under reflection, all ones if there is none.
    """

    weight: FloatArray  # (K,)
    mean: FloatArray  # (K, d)
    covariance: FloatArray  # (K, d, d)
    reflection: FloatArray  # (K,)
    signs: FloatArray  # (d,)


def monomials(z: FloatArray) -> FloatArray:
    """Compute the features 1, z_i and z_i z_j (i <= j) of each row."""
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


def _expectation(features: Features, mixture: Mixture) -> tuple[FloatArray, float]:
    """Sufficient statistics (K, features + 1) and mean log-likelihood.

    The last column is the reflected part of the mass, which is the first column. Responsibilities
    have the precision of the features.
    """
    weights, signs = _log_density_weights(mixture), _mirror_signs(mixture.signs)
    count = weights.shape[1]
    if signs is not None:
        reflected = weights * signs[:, None]
        reflected[0] += np.log(mixture.reflection)
        weights[0] += np.log1p(-mixture.reflection)
        weights = np.hstack([weights, reflected])
    weights = np.ascontiguousarray(weights, dtype=features.dtype)
    statistics = np.zeros((weights.shape[1], features.shape[1]))
    total = 0.0
    for start in range(0, len(features), _BLOCK):
        block = features[start : start + _BLOCK]
        table = block @ weights
        peak = table.max(axis=1, keepdims=True)
        table -= peak
        np.maximum(table, _DEPTH, out=table)
        np.exp(table, out=table)
        mass = table.sum(axis=1, keepdims=True)
        total += float(np.log(mass).sum() + peak.sum())
        statistics += table.T @ (block / mass)
    part = np.zeros(count) if signs is None else statistics[count:, 0].copy()
    if signs is not None:
        statistics = statistics[:count] + statistics[count:] * signs
    return np.column_stack([statistics, part]), total / len(features)


def _maximisation(
    statistics: FloatArray, mixture: Mixture, points: int
) -> tuple[Mixture, FloatArray]:
    """Mixture that maximises the expected likelihood, and the statistics it was made from.

    The statistics may be averages over ``points`` points. Components that are left without points
    are dropped from both.
    """
    dimension = mixture.mean.shape[1]
    # a component needs more points than it has directions to have a covariance of its own
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


def _start(z: FloatArray, components: int, signs: FloatArray, rng: np.random.Generator) -> Mixture:
    """Components at random points, all with a shrunken covariance of the sample."""
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
    """Signs of the monomials under the reflection, or None if there is none."""
    return monomials(signs[None])[0] if bool((signs < 0.0).any()) else None


def iterate(mixture: Mixture, features: Features) -> tuple[Mixture, float]:
    """Take one iteration of EM over the `monomials` of a sample.

    Returns the mixture, and the mean log-likelihood before the step.
    """
    statistics, likelihood = _expectation(features, mixture)
    return _maximisation(statistics, mixture, len(features))[0], likelihood


def _stepwise(mixture: Mixture, features: Features) -> Mixture:
    """Improve a mixture block by block."""
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
    """Fit a Gaussian mixture with full covariances to normal scores (n, d) in random order.

    Parameters
    ----------
    z : (n, d) float64
    components : int
        Fewer are fitted if there are fewer than d + 1 points for each; those that lose their
        points are dropped.
    rng : numpy Generator
        Chooses the starting points.
    signs : (d,) float64
        Signs of the channels under reflection; all ones if there is none.
    """
    # with more points than this on average, one component at least is always alive
    most = max((len(z) - 1) // (z.shape[1] + 1), 1)
    mixture = _start(z, min(components, most), signs, rng)
    features = monomials(z).astype(np.float32)
    mixture = _stepwise(mixture, features)
    # one iteration on the whole sample settles the weights
    return iterate(mixture, features)[0]
