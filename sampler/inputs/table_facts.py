"""What a table says of itself: nodes, ranges, memory, accuracy, and how many draws lay outside."""

import numpy as np
from numpy.typing import NDArray

from sampler.formats.table_arrays import TableArrays, bytes_of
from sampler.inputs.counts import Counts


class TableFacts:
    """Properties of `sampler.Table` that are read from its arrays, or from its counts."""

    arrays: TableArrays
    _small: dict[str, NDArray[np.float64]]
    _counts: Counts

    @property
    def alpha_nodes_deg(self) -> NDArray[np.float64]:
        """Impact angles of the nodes, degrees."""
        return self._small["axes/alpha_deg"].copy()

    @property
    def speed_nodes(self) -> NDArray[np.float64]:
        """Impact speeds of the nodes, m/s."""
        return self._small["axes/speed"].copy()

    @property
    def nbytes(self) -> int:
        """Memory that the table takes."""
        return bytes_of((self.arrays, *self._small.values()))

    @property
    def alpha_range(self) -> tuple[float, float]:
        """Smallest and largest impact angle, rad."""
        return self.arrays.alpha.first, self.arrays.alpha.last

    @property
    def speed_range(self) -> tuple[float, float]:
        """Smallest and largest impact speed of the nodes, m/s."""
        return self.arrays.speed.first, self.arrays.speed.last

    @property
    def accuracy(self) -> dict[str, NDArray[np.float64]]:
        """What was measured against direct simulation, at conditions that are no nodes.

        Keys: ``alpha_deg``, ``speed``, ``ks`` (n, n_columns), ``sliced_wasserstein``,
        ``correlation_error``, ``auc``, all (n,) but ks, which has a column for each of
        `columns`; n = 0 if nothing was measured.
        """
        paths = (path for path in self._small if path.startswith("accuracy/"))
        return {path.removeprefix("accuracy/"): self._small[path].copy() for path in paths}

    @property
    def clamped(self) -> int:
        """How many draws so far lay outside the table and were moved to its edge."""
        return self._counts.clamped.value

    @property
    def extrapolated(self) -> int:
        """How many draws so far had an impact speed outside the file's ``valid_speed``."""
        return self._counts.extrapolated.value
