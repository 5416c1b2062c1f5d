"""The law of grains: which shapes particles have, and which ratios of their half-sizes."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES


class GrainLaw(NamedTuple):
    """Shapes with their shares, and the law of the ratios b/a and c/b; for kernels.

    Attributes
    ----------
    shape_codes : int64 array, shape (n,)
        Codes of `sampler.formats.shape_codes`, increasing; of mesh number k, ``FIRST_MESH`` + k.
    cumulative_weights : float64 array, shape (n,)
        Running sum of the shares; the last is exactly 1.
    aspect : float64 array, shape (2, 4)
        Rows b/a and c/b; columns mean, standard deviation, and the standard normal probabilities
        p_low, p_high of the ends of the range. With u uniform on (0, 1), a ratio is
        mean + sd * normal_quantile(p_low + u * (p_high - p_low)). A fixed ratio has sd = 0.
    fixed_ratios : float64 array, shape (n, 2)
        Ratios of the shapes that draw none, spheres and meshes; 0 for all others.
    """

    shape_codes: NDArray[np.int64]
    cumulative_weights: NDArray[np.float64]
    aspect: NDArray[np.float64]
    fixed_ratios: NDArray[np.float64]


def grain_law(
    shape_codes: ArrayLike, weights: ArrayLike, aspect: ArrayLike, ratio_range: ArrayLike
) -> GrainLaw:
    """Law of grains from weights.

    Parameters
    ----------
    shape_codes : array of int, shape (n,)
        Increasing.
    weights : array of float, shape (n,)
        Not negative, and one of them positive; only their ratios matter.
    aspect : array, shape (2, 4)
        As of `GrainLaw`.
    ratio_range : array, shape (n, 2, 2)
        Smallest and largest b/a, then c/b, of each shape; of those that draw none, its own.

    Returns
    -------
    GrainLaw
        With the shapes of positive weight.
    """
    shares = np.asarray(weights, dtype=np.float64)
    held = shares > 0.0
    codes, summed = np.asarray(shape_codes, dtype=np.int64)[held], np.cumsum(shares[held])
    own = (codes == SHAPE_CODES["sphere"]) | (codes >= FIRST_MESH)
    ratios = np.asarray(ratio_range, dtype=np.float64)[held, :, 0]
    return GrainLaw(
        codes,
        summed / summed[-1],
        np.array(aspect, dtype=np.float64),
        np.where(own[:, None], ratios, 0.0),
    )
