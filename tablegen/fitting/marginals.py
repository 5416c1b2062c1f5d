"""Compute normal scores of a sample, and the quantile functions of its channels.

The mixture of a node is fitted to normal scores. Its own marginals are nearly normal, but not
exactly. So a table stores, for each variate z, the quantile of the sample at the probability
F_mixture(z), and draws have exactly the marginals of the sample. The knots are equally spaced in z:
they are dense where the sample is dense, and reach its tails. The quantile function of a nearly
normal channel is nearly straight between them.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from tablegen.fitting.mixture import Mixture
from tablegen.model.float_array import FloatArray

#: Variate of the last knot. A variate is larger with a probability of about 1.3e-5; the draw then
#: gets the quantile of the last knot. The first knot is the same on the negative side.
VARIATE_MAX = 4.2

#: Steps of a rounded quantile in the smaller one of the gaps to its neighbours. Knots of a table
#: are at most 0.026 apart in probability, so probabilities change by at most 0.026 / 512 = 5e-5.
STEPS = 256


def _place_by_rank(values: FloatArray, numbers: FloatArray) -> FloatArray:
    """Give the smallest of values (n,) the first of numbers (n,), the next one the second, ...

    Equal values keep their order.
    """
    # a stable sort takes five times as long, and is needed only if values are equal
    order = np.argsort(values)
    ascending = values[order]
    if (ascending[1:] == ascending[:-1]).any():
        order = np.argsort(values, kind="stable")
    placed = np.empty(len(values))
    placed[order] = numbers
    return placed


def normal_scores(channels: FloatArray) -> FloatArray:
    """Compute the normal scores of each channel of a sample (n, d): Phi^-1((rank + 1/2) / n)."""
    quantiles = ndtri((np.arange(len(channels)) + 0.5) / len(channels))
    return np.column_stack([_place_by_rank(column, quantiles) for column in channels.T])


def mixture_probabilities(mixture: Mixture, variates: FloatArray) -> FloatArray:
    """Compute the distribution function of each marginal of a mixture at variates (m,): (d, m)."""
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
    """Compute the variates of the knots, (count,), which are exactly symmetric about zero."""
    half = np.linspace(0.0, VARIATE_MAX, count // 2 + 1)
    return np.concatenate([-half[:0:-1], half])


def quantile_knots(channels: FloatArray, probabilities: FloatArray) -> FloatArray:
    """Compute the quantiles of each channel of a sample (n, d) at probabilities (d, m): (d, m)."""
    return np.array(
        [
            np.quantile(column, row, method="hazen")
            for column, row in zip(channels.T, probabilities, strict=True)
        ]
    )


def round_quantiles(quantiles: NDArray[Any]) -> NDArray[np.float32]:
    """Round quantiles to multiples of powers of two that are small beside the gaps between them.

    Rounded numbers end with zeros, which compress: a file gets a third smaller. The first and the
    last quantile bound the draws and stay the same, and so do quantiles that equal a neighbour. The
    quantiles do not decrease along the last axis, before and after.
    """
    values = quantiles.astype(np.float64)
    gaps = np.diff(values, axis=-1)
    smaller = np.minimum(gaps[..., :-1], gaps[..., 1:])
    apart = smaller > 0.0
    steps = np.exp2(np.floor(np.log2(smaller, where=apart, out=np.zeros_like(smaller)))) / STEPS
    inner = values[..., 1:-1]
    values[..., 1:-1] = np.where(apart, np.round(inner / steps) * steps, inner)
    return values.astype(np.float32)
