"""Alias tables: draws from K weights with one uniform number and one comparison.

Source: Walker, ACM Trans. Math. Softw. 3 (1977) 253-256; built by Vose's linear method.
"""

import numpy as np
from numpy.typing import NDArray


def alias_table(weight: NDArray[np.float64]) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
    """Build the alias table of a discrete law.

    A draw takes a column k uniformly and keeps it with ``probability[k]``, else takes
    ``alias[k]``.

    Parameters
    ----------
    weight : (K,) float64
        Non-negative, not all zero, K up to 65536.

    Returns
    -------
    tuple (probability (K,) uint16, alias (K,) uint16)
        Probabilities in units of 2**-16; a column that is always kept has itself as its alias.
    """
    count = len(weight)
    scaled = np.asarray(weight, dtype=np.float64) * (count / np.sum(weight))
    probability = np.ones(count)
    alias = np.arange(count)
    small = [k for k in range(count) if scaled[k] < 1.0]
    large = [k for k in range(count) if scaled[k] >= 1.0]
    while small and large:
        low, high = small.pop(), large.pop()
        probability[low] = scaled[low]
        alias[low] = high
        scaled[high] -= 1.0 - scaled[low]
        (small if scaled[high] < 1.0 else large).append(high)
    # the remaining columns differ from one by rounding only and are always kept
    steps = np.minimum(np.rint(probability * 65536.0), 65535.0)
    return steps.astype(np.uint16), alias.astype(np.uint16)
