"""Normal scores of a sample, and the probabilities that belong to a mixture's variates.

The copula is fitted to normal scores. The marginals of a fitted mixture are close to normal, but
not exactly normal. The quantile stored for a variate z is therefore that of the probability
F_mixture(z), so that draws have the marginals of the sample.
"""

import numpy as np
from scipy.special import ndtr, ndtri

from tablegen.fitting.mixture import Mixture
from tablegen.model.float_array import FloatArray


def _ranks(values: FloatArray) -> FloatArray:
    """Mid-ranks over n, in (0, 1); ties are broken by position."""
    order = np.argsort(values, kind="stable")
    ranks = np.empty(len(values))
    ranks[order] = np.arange(len(values)) + 0.5
    return ranks / len(values)


def normal_scores(channels: FloatArray, mirror: FloatArray) -> FloatArray:
    """Compute the normal scores of each channel of a sample.

    A channel that changes sign under the mirror is scored by the rank of its absolute value, so
    that its scores are those of the sample together with its reflection.

    Parameters
    ----------
    channels : (n, d) float64
    mirror : (d,) float64
        +1 or -1.

    Returns
    -------
    (n, d) float64
    """
    scores = np.empty_like(channels)
    for j, sign in enumerate(mirror):
        column = channels[:, j]
        if sign > 0.0:
            scores[:, j] = ndtri(_ranks(column))
        else:
            scores[:, j] = np.copysign(ndtri(0.5 + 0.5 * _ranks(np.abs(column))), column)
    return scores


def mixture_probabilities(mixture: Mixture, variates: FloatArray) -> FloatArray:
    """Distribution functions of the mixture's own marginals.

    Parameters
    ----------
    mixture : Mixture
    variates : (m,) float64

    Returns
    -------
    (d, m) float64, non-decreasing along each row
    """
    deviation = np.sqrt(np.einsum("kii->ki", mixture.covariance))
    probabilities = np.empty((mixture.mean.shape[1], len(variates)))
    for j, sign in enumerate(mixture.signs):
        mean, scale = mixture.mean[:, j], deviation[:, j]
        plain = ndtr((variates[:, None] - mean) / scale)
        reflected = ndtr((variates[:, None] - sign * mean) / scale)
        mixed = (1.0 - mixture.reflection) * plain + mixture.reflection * reflected
        probabilities[j] = mixed @ mixture.weight
    return np.maximum.accumulate(np.clip(probabilities, 0.0, 1.0), axis=1)
