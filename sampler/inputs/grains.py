"""Whose grain a particle has at a hit: its own, a fresh one, or the one given."""

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import Keys, Rows, broadcast, place
from sampler.drawing.grain import OWN_GRAIN, draw_grains
from sampler.errors import InputError
from sampler.formats.bounds import TableArrays
from sampler.formats.spin_buffer import law_in

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


def _check_word(grain: Grain) -> None:
    """Refuse another word than those that say whose grain it is."""
    if isinstance(grain, str) and grain not in ("own", "fresh"):
        allowed = "'own', 'fresh', or numbers of shape (..., 3)"
        raise InputError(f"grain: got {grain!r}, allowed: {allowed}")


def asks_spin_law(arrays: TableArrays, name: str, spin: Any, grain: Grain) -> bool:
    """Whether a call draws from the spin law.

    Parameters
    ----------
    arrays, name, spin, grain
        As for `rows_of_call`.

    Raises
    ------
    InputError
        If the table has no spin law for it, or the grain is a word that says nothing.
    """
    _check_word(grain)
    own = isinstance(grain, str) and grain == "own"
    if spin is None and own and not law_in(arrays).serves_all:
        return False
    if law_in(arrays).n_shapes == 0:
        asked = "grain" if spin is None else name
        raise InputError(f"{asked}: got one, allowed: none, for the table has no spin law")
    return True


def rows_of_call(
    arrays: TableArrays,
    arguments: dict[str, ArrayLike],
    name: str,
    spin: ArrayLike | None,
    grain: Grain,
    keys: Keys,
) -> tuple[Rows, Grains | None]:
    """Rows of arguments and keys, and where grains come from; None for the law without spin.

    Parameters
    ----------
    arrays : TableArrays
    arguments : dict
        All but the spin and the grain.
    name : str
        That of the spin: "spin" or "omega".
    spin : array, shape (..., 3), or None
        None where the particle has not spun: zeros, if a grain is given, or always.
    grain : "own", "fresh" or array, shape (..., 3)
    keys : Keys

    Raises
    ------
    InputError
        If an argument has a wrong type or shape, the table has no spin law for it, or a grain is
        none of those that the law was made for. Names the first row.
    """
    if not asks_spin_law(arrays, name, spin, grain):
        return broadcast(arguments, keys), None
    with_spin = arguments | {name: np.zeros(3) if spin is None else spin}
    if isinstance(grain, str):
        rows = broadcast(with_spin, keys)
        return rows, Grains(_NONE, _OWN if grain == "own" else rows.keys[2])
    rows = broadcast(with_spin | {"grain": grain}, keys)
    given = rows.values.pop("grain")
    check_grains(arrays, rows, given)
    return rows, Grains(given, _OWN)


def grains_of(arrays: TableArrays, seed: int, index: ArrayLike) -> NDArray[np.float64]:
    """Grains that particles keep, (..., 3); raises `InputError` if the table has no spin law."""
    if law_in(arrays).n_shapes == 0:
        raise InputError("grains: asked for, allowed: of a table with a spin law")
    rows = broadcast({}, Keys(seed, index))
    key: Any = rows.keys[0]
    grains = np.empty((rows.n, 3))
    draw_grains(law_in(arrays).grains, key, rows.keys[1], grains)
    return grains.reshape(*rows.shape, 3)


def check_grains(arrays: TableArrays, rows: Rows, given: NDArray[np.float64]) -> None:
    """Refuse the first grain that the spin law of a table was not made for."""
    law = law_in(arrays)
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
