"""Normal scores: a sample's own, and those that belong to a mixture's variates.

The copula lives in normal-score space. A fitted mixture has marginals that are close to normal
but not exactly so; the score map of a channel, Phi^-1(F_mixture(z)), removes the difference, so
that the marginals of a draw are those of the quantile tables.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from tablegen.fitting.mixture import Mixture

FloatArray = NDArray[np.float64]


def _ranks(values: FloatArray) -> FloatArray:
    """Mid-ranks over n, in (0, 1); ties are broken by position."""
    order = np.argsort(values, kind="stable")
    ranks = np.empty(len(values))
    ranks[order] = np.arange(len(values)) + 0.5
    return ranks / len(values)


def normal_scores(channels: FloatArray, mirror: FloatArray) -> FloatArray:
    """Give the normal scores of each channel of a sample.

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


def score_maps(mixture: Mixture, variates: FloatArray, score_max: float) -> FloatArray:
    """Score maps of all channels at the given variates.

    Parameters
    ----------
    mixture : Mixture
    variates : (m,) float64
        Increasing and symmetric about zero.
    score_max : float
        Scores are limited to [-score_max, score_max], the span of the quantile knots.

    Returns
    -------
    (d, m) float64, non-decreasing along each row
    """
    deviation = np.sqrt(np.einsum("kii->ki", mixture.covariance))
    maps = np.empty((mixture.mean.shape[1], len(variates)))
    for j in range(len(maps)):
        standard = (variates[:, None] - mixture.mean[:, j]) / deviation[:, j]
        below = ndtr(standard) @ mixture.weight
        above = ndtr(-standard) @ mixture.weight
        if mixture.mirror[j] < 0.0:
            below, above = 0.5 * (below + above[::-1]), 0.5 * (above + below[::-1])
        # each tail from its own side, where its probability is not rounded against one
        maps[j] = np.where(below < above, ndtri(below), -ndtri(above))
        if mixture.mirror[j] < 0.0:
            maps[j] = 0.5 * (maps[j] - maps[j, ::-1])  # odd to the last bit
    return np.maximum.accumulate(np.clip(maps, -score_max, score_max), axis=1)
