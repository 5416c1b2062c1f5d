"""What a table says of itself: nodes, ranges, memory and accuracy."""

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import TableArrays, bytes_of


class TableFacts:
    """Properties of `sampler.Table` that are read from its arrays."""

    arrays: TableArrays
    _small: dict[str, NDArray[np.float64]]

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
