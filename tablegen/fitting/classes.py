"""Two classes of rebounds: one collision, or several.

At steep angles the density of the normal velocity jumps at the largest value that one collision
can give. That value and the share of single collisions depend on the speed. A quantile function of
all rebounds has the jump at another probability at every node, and averaging nodes smears it.
Within a class the law changes slowly, so that nodes can be averaged. Measured: EXPERIMENTS.md.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

#: Names of the classes, in the order of the table's arrays.
CLASSES = ("single", "repeated")

#: A class with a smaller share of the sample, or with fewer points, is merged with the other one.
#: Its share bounds the change of any distribution function.
LEAST_SHARE = 0.005
_LEAST_POINTS = 40

#: A class of share p gets components in proportion to p to this power.
_EXPONENT = 0.75


def class_of(collisions: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the class of each rebound from its number of collisions.

    Parameters
    ----------
    collisions : (n,) int64

    Returns
    -------
    (n,) int64
        Index into `CLASSES`. All rebounds get the same class if the other is too small to fit.
    """
    kind = np.where(collisions > 1, 1, 0)
    count = np.bincount(kind, minlength=len(CLASSES))
    if count.min() < max(LEAST_SHARE * len(kind), _LEAST_POINTS):
        kind[:] = np.argmax(count)
    return kind


def allocate_components(components: int, count: Sequence[int]) -> list[int]:
    """Divide the mixture components of a node between the classes.

    Parameters
    ----------
    components : int
        Components of the node; at least one for each class that is not empty.
    count : sequence of int
        Points of each class.

    Returns
    -------
    list of int
        Components of each class; none for an empty one.
    """
    wanted = np.asarray(count, dtype=np.float64) ** _EXPONENT
    wanted *= components / wanted.sum()
    shares = np.maximum(np.floor(wanted).astype(np.int64), np.asarray(count) > 0)
    while shares.sum() > components:
        shares[np.argmax(shares)] -= 1
    shares[np.argmax(count)] += components - shares.sum()
    return [int(share) for share in shares]
