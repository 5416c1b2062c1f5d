"""A large direct sample that many small ones are compared with.

The distances are those of `tablegen.accuracy.metrics`. What they need of the reference alone -
sorted components, sorted projections, correlations - is worked out once.
"""

import numpy as np

from tablegen.accuracy.metrics import classifier_auc, correlations
from tablegen.accuracy.samples import FloatArray, as_state, varies

#: Metrics of an error, in the order of columns.
METRICS = ("ks", "sliced_wasserstein", "correlation_error", "auc")

#: Directions of the sliced Wasserstein distance.
DIRECTIONS = 32


class Reference:
    """Direct states at one condition.

    Parameters
    ----------
    state : float64 array, shape (m, 6)
    directions : int
        Of the sliced Wasserstein distance.
    """

    def __init__(self, state: FloatArray, directions: int = DIRECTIONS) -> None:
        self.state = as_state(state)
        self._sorted = np.sort(self.state, axis=0)
        self._correlations = correlations(self.state)
        self._mean = self.state.mean(axis=0)
        self._scale = np.where(varies(self.state), self.state.std(axis=0), 1.0)
        normal = np.random.default_rng(0).standard_normal((directions, 6))
        self._directions = (normal / np.linalg.norm(normal, axis=1, keepdims=True)).T
        self._projected = np.sort(self._standardised(self.state) @ self._directions, axis=0)

    def _standardised(self, state: FloatArray) -> FloatArray:
        return (state - self._mean) / self._scale

    def ks(self, sample: FloatArray) -> float:
        """Largest Kolmogorov-Smirnov distance of any component."""
        n, m = len(sample), len(self._sorted)
        steps = np.arange(n) / n
        largest = 0.0
        for k in range(6):
            values = np.sort(sample[:, k])
            # the two functions are farthest apart just before or at a step of the sample's
            below = np.searchsorted(self._sorted[:, k], values, side="left") / m
            upto = np.searchsorted(self._sorted[:, k], values, side="right") / m
            gap = max(np.max(below - steps), np.max(steps + 1.0 / n - upto))
            largest = max(largest, float(gap))
        return largest

    def sliced_wasserstein(self, sample: FloatArray) -> float:
        """Sliced Wasserstein-1 distance of the standardised states.

        The size of the sample divides that of the reference.
        """
        repeat, rest = divmod(len(self.state), len(sample))
        if rest:
            raise ValueError(f"{len(sample)} states do not divide {len(self.state)}")
        projected = np.sort(self._standardised(sample) @ self._directions, axis=0)
        parts = self._projected.reshape(len(sample), repeat, -1)
        return float(np.abs(parts - projected[:, None, :]).mean())

    def correlation_error(self, sample: FloatArray) -> float:
        """Largest difference of a correlation."""
        return float(np.abs(correlations(sample) - self._correlations).max())

    def auc(self, sample: FloatArray, batch: int, size: int) -> float:
        """Tell a sample from as many states of the reference, others for every batch."""
        size = min(size, len(sample))
        start = batch * size % (len(self.state) - size + 1)
        return classifier_auc(sample[:size], self.state[start : start + size], seed=batch)
