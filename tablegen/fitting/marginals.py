"""Marginals: normal scores of a sample, and quantile functions of its channels.

The mixture is fitted to normal scores. Its own marginals are close to normal, but not exactly
normal. The quantile stored for a variate z is therefore that of the probability F_mixture(z), so
that draws have the marginals of the sample. Knots equally spaced in z are dense where the sample is
and still reach the tails; the quantile function of a nearly normal channel is nearly straight
between them.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from tablegen.fitting.mixture import Mixture
from tablegen.model.float_array import FloatArray

#: Variate of the last knot. The probability beyond it is about 1.3e-5 on either side; a draw there
#: gets the quantile of the last knot.
VARIATE_MAX = 4.2

#: Rounding step of a quantile: this part of the smaller gap to a neighbour. Knots of a table are at
#: most 0.026 apart in probability, so probabilities change by at most 0.026 / 512 = 5e-5.
STEPS = 256


def _in_order(values: FloatArray, given: FloatArray) -> FloatArray:
    """Give the smallest of values (n,) the first of some numbers (n,), and so on.

    Ties are broken by position.
    """
    # a stable order takes five times as long
    order = np.argsort(values)
    ascending = values[order]
    if (ascending[1:] == ascending[:-1]).any():
        order = np.argsort(values, kind="stable")
    placed = np.empty(len(values))
    placed[order] = given
    return placed


def normal_scores(channels: FloatArray) -> FloatArray:
    """Compute the normal scores of each channel of a sample (n, d)."""
    quantiles = ndtri((np.arange(len(channels)) + 0.5) / len(channels))
    return np.column_stack([_in_order(column, quantiles) for column in channels.T])


def mixture_probabilities(mixture: Mixture, variates: FloatArray) -> FloatArray:
    """Evaluate the distribution functions of a mixture's marginals at variates (m,): (d, m)."""
    deviation = np.sqrt(np.einsum("kii->ki", mixture.covariance))
    probabilities = np.empty((mixture.mean.shape[1], len(variates)))
    for j, sign in enumerate(mixture.signs):
        mean, scale = mixture.mean[:, j], deviation[:, j]
        plain = ndtr((variates[:, None] - mean) / scale)
        reflected = ndtr((variates[:, None] - sign * mean) / scale)
        mixed = (1.0 - mixture.reflection) * plain + mixture.reflection * reflected
        probabilities[j] = mixed @ mixture.weight
    return np.maximum.accumulate(np.clip(probabilities, 0.0, 1.0), axis=1)


def variate_knots(count: int) -> FloatArray:
    """Variates of the knots, (count,), from -VARIATE_MAX to VARIATE_MAX, exactly symmetric."""
    half = np.linspace(0.0, VARIATE_MAX, count // 2 + 1)
    return np.concatenate([-half[:0:-1], half])


def quantile_knots(channels: FloatArray, probabilities: FloatArray) -> FloatArray:
    """Compute the quantiles of each channel of a sample (n, d) at probabilities (d, m)."""
    return np.array(
        [
            np.quantile(column, row, method="hazen")
            for column, row in zip(channels.T, probabilities, strict=True)
        ]
    )


def rounded_quantiles(quantiles: NDArray[Any]) -> NDArray[np.float32]:
    """Round quantiles to powers of two that are small beside the gaps between them.

    Zeros at the end of a number compress: a file gets a third smaller. The first and the last
    quantile, which bound the draws, stay the same, and so do quantiles that equal a neighbour.
    All are non-decreasing along the last axis.
    """
    values = quantiles.astype(np.float64)
    gaps = np.diff(values, axis=-1)
    smaller = np.minimum(gaps[..., :-1], gaps[..., 1:])
    apart = smaller > 0.0
    steps = np.exp2(np.floor(np.log2(smaller, where=apart, out=np.zeros_like(smaller)))) / STEPS
    inner = values[..., 1:-1]
    values[..., 1:-1] = np.where(apart, np.round(inner / steps) * steps, inner)
    return values.astype(np.float32)
