"""Divide the rebounds of a node into classes, and the components of its mixture between them.

A rebound has one collision or several. At steep angles the density of the normal velocity jumps at
the largest value that one collision can give. This value and the share of rebounds with one
collision depend on the speed. So a quantile function of all rebounds has the jump at a different
probability at each node, and averages of nodes smear it. Within a class the law changes slowly, and
nodes can be averaged (EXPERIMENTS.md, "First impacts").
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tablegen.model.float_array import FloatArray

#: Names of the classes, in the order of the arrays of a table: one collision, several collisions.
CLASSES = ("single", "repeated")

#: A class with a smaller share of the sample, or with fewer points, is too small to fit and joins
#: the other class. This changes no distribution function by more than the share.
LEAST_SHARE = 0.005
_LEAST_POINTS = 40

#: A class of share p gets components in proportion to p to this power.
_EXPONENT = 0.75


def rebound_classes(collisions: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the class of each rebound, (n,), from its number of collisions, (n,).

    Classes are indices into `CLASSES`. A class that is too small to fit joins the other class.
    """
    classes = np.where(collisions > 1, 1, 0)
    count = np.bincount(classes, minlength=len(CLASSES))
    if count.min() < max(LEAST_SHARE * len(classes), _LEAST_POINTS):
        classes[:] = np.argmax(count)
    return classes


def allocate_components(components: int, count: Sequence[int]) -> list[int]:
    """Divide the mixture components of a node between the classes by their counts of points.

    Each class with points gets at least one component, as long as there are enough components. An
    empty class gets none.
    """
    exact = np.asarray(count, dtype=np.float64) ** _EXPONENT
    exact *= components / exact.sum()
    shares = np.maximum(np.floor(exact).astype(np.int64), np.asarray(count) > 0)
    while shares.sum() > components:
        shares[np.argmax(shares)] -= 1
    shares[np.argmax(count)] += components - shares.sum()
    return [int(share) for share in shares]


def alias_table(weight: FloatArray) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
    """Build the alias table of a discrete law, so that a draw needs one random number.

    A draw chooses a column k uniformly. It takes k with ``probability[k]``, and ``alias[k]``
    otherwise. Sources: Walker, ACM Trans. Math. Softw. 3 (1977) 253-256; Vose, IEEE Trans. Softw.
    Eng. 17 (1991) 972-975.

    Parameters
    ----------
    weight : (n,) float64
        Weights, in any unit.

    Returns
    -------
    probability : (n,) uint16
        In units of 2**-16.
    alias : (n,) uint16
        A column that is always taken is its own alias.
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
    # the columns that are left differ from one by rounding only, and are always taken
    steps = np.minimum(np.rint(probability * 65536.0), 65535.0)
    return steps.astype(np.uint16), alias.astype(np.uint16)
