"""Draws that stand for the law at a condition, for its moments and quantiles."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.drawing.batch import draw_batch
from sampler.drawing.threads import run_rows
from sampler.formats.table_arrays import TableArrays

#: Draws at a condition, and a seed that is kept for them: a user's draws shall not repeat them.
DRAWS = 2**18
SEED = 0xB5297A4D3F84D5B5


def states_of_law(
    arrays: TableArrays, conditions: Iterable[tuple[float, float]]
) -> Iterator[NDArray[Any]]:
    """States at each condition, always with the same keys; the array is written again and again.

    Parameters
    ----------
    arrays : TableArrays
    conditions : iterable of (float, float)
        Impact angles (rad) and speeds (m/s), checked before.

    Yields
    ------
    float64 array, shape (DRAWS, n_columns)
    """
    states = np.empty((DRAWS, len(arrays.columns)))
    keys = (np.uint64(SEED), np.arange(DRAWS, dtype=np.uint64), np.zeros(1, dtype=np.uint32))
    for alpha1, speed in conditions:
        condition = (np.array([alpha1]), np.array([speed]))
        run_rows(draw_batch, (arrays, *condition, *keys, states), DRAWS, None)
        yield states
