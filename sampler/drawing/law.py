"""Draws that stand for the law at a condition, for its moments and quantiles."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.drawing.batch import draw_batch
from sampler.drawing.grain import OWN_GRAIN
from sampler.drawing.spin_draw import spin_draw_batch
from sampler.drawing.threads import run_rows
from sampler.formats.bounds import TableArrays

#: Draws at a condition, and a seed that is kept for them: a user's draws shall not repeat them.
DRAWS = 2**18
SEED = 0xB5297A4D3F84D5B5


def states_of_law(
    arrays: TableArrays, conditions: Iterable[tuple[Any, ...]]
) -> Iterator[NDArray[Any]]:
    """States at each condition, always with the same keys; the array is written again and again.

    Parameters
    ----------
    arrays : TableArrays
    conditions : iterable of (float, float) or (float, float, array)
        Impact angles (rad), speeds (m/s) and, for draws from the spin law, spins (3,) times a/V,
        checked before. Grains are those of the keys.

    Yields
    ------
    float64 array, shape (DRAWS, n_columns)
    """
    states = np.empty((DRAWS, len(arrays.columns)))
    keys = (np.uint64(SEED), np.arange(DRAWS, dtype=np.uint64), np.zeros(1, dtype=np.uint32))
    no_grains, own = np.zeros((0, 3)), np.full(1, OWN_GRAIN, dtype=np.uint32)
    for given in conditions:
        condition = [np.array([value]) for value in given]
        batch: Callable[..., Any] = draw_batch
        if len(condition) == 3:
            batch, condition = spin_draw_batch, [*condition, no_grains, own]
        run_rows(batch, (arrays, *condition, *keys, states), DRAWS, None)
        yield states
