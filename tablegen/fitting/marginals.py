"""Quantile functions of the channels at knots that are equally spaced in the mixture's variate.

The variates are nearly standard normal. Knots equally spaced in them are dense where
the samples are and still reach the tails; the quantile function of a nearly normal channel is
nearly straight between them.
"""

import numpy as np

from tablegen.model.float_array import FloatArray

#: Variate of the last knot; beyond it lies a probability of about 1.3e-5 on either side, and a
#: draw there has the quantile of the last knot.
VARIATE_MAX = 4.2


def variate_knots(count: int) -> FloatArray:
    """Variates of the knots, (count,), from -VARIATE_MAX to VARIATE_MAX, exactly symmetric."""
    half = np.linspace(0.0, VARIATE_MAX, count // 2 + 1)
    return np.concatenate([-half[:0:-1], half])


def quantile_knots(
    channels: FloatArray, probabilities: FloatArray, mirror: FloatArray
) -> FloatArray:
    """Sample quantiles of each channel at given probabilities.

    A channel that changes sign under the mirror gets the quantiles of the sample together with
    its reflection, which are odd about the median.

    Parameters
    ----------
    channels : (n, d) float64
    probabilities : (d, m) float64
        In [0, 1], non-decreasing along each row; symmetric about 1/2 for a mirrored channel.
    mirror : (d,) float64
        +1 or -1.

    Returns
    -------
    (d, m) float64, non-decreasing along each row
    """
    quantiles = np.empty(probabilities.shape)
    for j, sign in enumerate(mirror):
        column = channels[:, j]
        if sign > 0.0:
            quantiles[j] = np.quantile(column, probabilities[j], method="hazen")
        else:
            doubled = np.concatenate([column, -column])
            row = np.quantile(doubled, probabilities[j], method="hazen")
            quantiles[j] = 0.5 * (row - row[::-1])
    return quantiles
