"""Moments and quantiles of the law of a table at conditions, from draws."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler import library
from sampler.arguments import Call
from sampler.library import OpenedTable, Rows

#: Draws at a condition, and a seed that is kept for them: a user's draws shall not repeat them.
DRAWS = 2**18
SEED = 0xB5297A4D3F84D5B5

#: From the states of many draws at one condition to some numbers.
Reduction = Callable[[NDArray[np.float64]], Any]


def reduced_draws(
    table: OpenedTable, call: Call, n_columns: int, reduce: Reduction
) -> NDArray[np.float64]:
    """Reduce many draws at each condition to some numbers.

    Parameters
    ----------
    table : OpenedTable
    call : Call
        The conditions, whose codes were looked at: ``alpha1``, ``speed`` and maybe ``spin``.
    n_columns : int
        Variables of a state.
    reduce : callable
        Takes the states (DRAWS, n_columns) of a condition, and returns as many numbers for each.

    Returns
    -------
    float64 array, shape (..., what `reduce` returns)
    """
    states = np.empty((DRAWS, n_columns))
    results = []
    for k in range(call.rows.n):
        names = (name for name in ("alpha1", "speed", "spin") if name in call.rows.arrays)
        condition: dict[str, NDArray[Any]] = {name: call.at(name, k)[None] for name in names}
        condition["index"] = np.arange(DRAWS, dtype=np.uint64)
        condition["hit"] = np.zeros(1, np.uint32)
        library.sample(table, Rows(DRAWS, SEED, condition, False), states, None)
        results.append(reduce(states))
    tail = reduce(np.zeros((1, n_columns))).shape
    return np.array(results).reshape(*call.shape, *tail)
