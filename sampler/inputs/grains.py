"""Whose grain a particle has at a hit: its own, a fresh one, or the one given."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.drawing.grain import OWN_GRAIN
from sampler.errors import InputError
from sampler.formats.table_arrays import TableArrays
from sampler.inputs.rows import Keys, Rows, broadcast, place

#: "own": a particle has the same grain at every hit, drawn by (seed, index). "fresh": another one
#: at every hit, drawn by (seed, index, hit). An array (..., 3): shape code, b/a, c/b.
Grain = Literal["own", "fresh"] | ArrayLike

_OWN = np.full(1, OWN_GRAIN, dtype=np.uint32)
_NONE = np.zeros((0, 3))


class Grains(NamedTuple):
    """Where the grains of rows come from.

    Attributes
    ----------
    given : float64 array, shape (n, 3), (1, 3) or (0, 3)
        Grains, or none.
    hit : uint32 array, shape (n,) or (1,)
        The hits whose random numbers make them where none are given.
    """

    given: NDArray[np.float64]
    hit: NDArray[np.uint32]


def rows_with_grains(
    arguments: dict[str, ArrayLike], grain: Grain, keys: Keys
) -> tuple[Rows, Grains]:
    """Rows of arguments and keys, and where their grains come from.

    Raises
    ------
    InputError
        If an argument has a wrong type or shape, or `grain` is another word.
    """
    if isinstance(grain, str):
        if grain not in ("own", "fresh"):
            allowed = "'own', 'fresh', or numbers of shape (..., 3)"
            raise InputError(f"grain: got {grain!r}, allowed: {allowed}")
        rows = broadcast(arguments, keys)
        return rows, Grains(_NONE, rows.keys[2] if grain == "fresh" else _OWN)
    rows = broadcast(arguments | {"grain": grain}, keys)
    return rows, Grains(rows.values.pop("grain"), _OWN)


def check_grains(arrays: TableArrays, rows: Rows, given: NDArray[np.float64]) -> None:
    """Refuse the first grain that the spin law of a table was not made for."""
    law = arrays.spin
    same = given[:, :1] == law.shape_codes
    low, high = law.ratio_range[:, :, 0], law.ratio_range[:, :, 1]
    inside = ((given[:, None, 1:] >= low) & (given[:, None, 1:] <= high)).all(axis=2)
    refused = ~(same & inside).any(axis=1)
    if not refused.any():
        return
    row = int(refused.argmax())
    got = ", ".join(f"{x:.9g}" for x in given[row])
    shapes = ", ".join(str(code) for code in law.shape_codes)
    raise InputError(
        f"grain: got {got} at {place(row, rows.shape)}, allowed: a shape code of the table "
        f"({shapes}), and b/a and c/b within what was simulated"
    )
