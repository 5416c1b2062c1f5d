"""Quantile functions of the channels at knots that are equally spaced in normal score.

Knots equally spaced in score put their resolution where the samples are and still reach the
tails; the quantile function of a nearly normal channel is nearly straight between them.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

FloatArray = NDArray[np.float64]

#: Score of the last knot; beyond it lies a probability of 1.3e-5 on either side.
SCORE_MAX = 4.2


def score_knots(count: int) -> FloatArray:
    """Scores of the knots, (count,), from -SCORE_MAX to SCORE_MAX, exactly symmetric."""
    half = np.linspace(0.0, SCORE_MAX, count // 2 + 1)
    return np.concatenate([-half[:0:-1], half])


def quantile_knots(channels: FloatArray, knots: FloatArray, mirror: FloatArray) -> FloatArray:
    """Sample quantiles of each channel at the knots.

    A channel that changes sign under the mirror gets the quantiles of the sample together with
    its reflection, which are odd in the score.

    Parameters
    ----------
    channels : (n, d) float64
    knots : (m,) float64
        Normal scores, symmetric about zero.
    mirror : (d,) float64
        +1 or -1.

    Returns
    -------
    (d, m) float64, non-decreasing along each row
    """
    probability = ndtr(knots)
    quantiles = np.empty((channels.shape[1], len(knots)))
    for j, sign in enumerate(mirror):
        column = channels[:, j]
        if sign > 0.0:
            quantiles[j] = np.quantile(column, probability, method="hazen")
        else:
            doubled = np.concatenate([column, -column])
            row = np.quantile(doubled, probability, method="hazen")
            quantiles[j] = 0.5 * (row - row[::-1])
    return quantiles
