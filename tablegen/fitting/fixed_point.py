"""How the numbers of a mixture are stored: as 16-bit integers.

Variates of a mixture have variance one, so means and factors lie within a few units. Steps of
1/4096 on a range of +-8 move a draw by less than a thousandth of a standard deviation, in half of
the bytes of floating point.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.formats.bounds import MIXTURE_SCALE


def to_steps(values: ArrayLike, coarse: int = 1) -> NDArray[np.int16]:
    """Round to the nearest step.

    Parameters
    ----------
    values : array_like of float
        Within [-8, 8).
    coarse : int
        Round to multiples of so many steps: the file gets smaller, because zeros compress.

    Returns
    -------
    int16 array of the same shape

    Raises
    ------
    OverflowError
        If a value does not fit.
    """
    steps = coarse * np.rint(np.asarray(values, dtype=np.float64) * (MIXTURE_SCALE / coarse))
    limits = np.iinfo(np.int16)
    if steps.size and not limits.min <= steps.min() <= steps.max() <= limits.max:
        raise OverflowError(f"mixture: got {np.max(np.abs(values)):g}, allowed: [-8, 8)")
    return steps.astype(np.int16)


def from_steps(steps: NDArray[np.int16]) -> NDArray[np.float64]:
    """Values that steps stand for, exactly."""
    return steps / MIXTURE_SCALE
