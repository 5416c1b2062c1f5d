"""Components of a node: shared between two classes of rebounds, drawn from an alias table.

A rebound has a single collision, or repeated ones. At steep angles the density of the normal
velocity jumps at the largest value that one collision can give. That value and the share of single
collisions depend on the speed. A quantile function of all rebounds has the jump at another
probability at every node, and averaging nodes smears it. Within a class the law changes slowly, so
that nodes can be averaged. Measured: EXPERIMENTS.md.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tablegen.model.float_array import FloatArray

#: Names of the classes, in the order of the table's arrays.
CLASSES = ("single", "repeated")

#: A class with a smaller share of the sample, or with fewer points, is too small to fit. Merging it
#: changes no distribution function by more than its share.
LEAST_SHARE = 0.005
_LEAST_POINTS = 40

#: A class of share p gets components in proportion to p to this power.
_EXPONENT = 0.75


def class_of(collisions: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the class of each rebound, (n,), from its number of collisions, (n,).

    Classes are indices into `CLASSES`. A class that is too small to fit is merged with the other.
    """
    kind = np.where(collisions > 1, 1, 0)
    count = np.bincount(kind, minlength=len(CLASSES))
    if count.min() < max(LEAST_SHARE * len(kind), _LEAST_POINTS):
        kind[:] = np.argmax(count)
    return kind


def allocate_components(components: int, count: Sequence[int]) -> list[int]:
    """Divide the mixture components of a node between the classes by their counts of points.

    Each class that is not empty gets at least one component, and an empty class gets none.
    """
    wanted = np.asarray(count, dtype=np.float64) ** _EXPONENT
    wanted *= components / wanted.sum()
    shares = np.maximum(np.floor(wanted).astype(np.int64), np.asarray(count) > 0)
    while shares.sum() > components:
        shares[np.argmax(shares)] -= 1
    shares[np.argmax(count)] += components - shares.sum()
    return [int(share) for share in shares]


def alias_table(weight: FloatArray) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
    """Build the alias table of a discrete law, from which a draw needs one random number.

    A draw takes a column k uniformly and keeps it with ``probability[k]``, else takes ``alias[k]``.
    Probabilities are in units of 2**-16; a column that is always kept is its own alias. Source:
    Walker, ACM Trans. Math. Softw. 3 (1977) 253-256; Vose's linear method.
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
