"""The compiled library of the draw (`sampler/c`), called through ctypes on slices of rows.

Arrays go in as addresses, and the GIL is released while the library works. Rows are cut into slices
of at most `SLICE`, which threads share: the same states for any number of threads.
"""

import ctypes
import math
import os
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from ctypes import c_char_p, c_double, c_int, c_size_t, c_uint64, c_void_p
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.errors import OK, TableError
from sampler.formats.image import Image, aligned

#: Rows of a slice at most: few enough for Ctrl-C, which comes between slices, to end a run at once.
SLICE = 2**16

#: Rows below which a further thread costs more than it saves.
_ROWS_PER_THREAD = 20_000

#: The library beside this module; the variable names another build of it, for tests and profilers.
_PLACE = Path(__file__).with_name("librebound.so")
_VARIABLE = "REBOUND_SAMPLER_LIBRARY"


class _Report(ctypes.Structure):
    """``rbt_report``."""

    _fields_ = (
        *((name, c_size_t) for name in ("row", "clamped_row", "clamped")),
        *((name, c_size_t) for name in ("extrapolated", "extrapolated_row")),
    )


class _Conditions(ctypes.Structure):
    """``rbt_conditions``."""

    _fields_ = (
        *((name, c_void_p) for name in ("alpha1", "speed", "spin", "grain", "index", "hit")),
        ("fresh_grains", c_int),
    )


class _Impacts(ctypes.Structure):
    """``rbt_impacts``."""

    _fields_ = (
        *((name, c_void_p) for name in ("velocity", "normal", "half_size", "wall_velocity")),
        *((name, c_void_p) for name in ("index", "hit", "omega", "roughness", "grain")),
        *((name, c_int) for name in ("fresh_grains", "isotropic")),
    )


#: Functions of the library: result, then arguments.
_FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "rbt_open_image": (c_int, c_void_p, c_size_t, c_void_p),
    "rbt_close": (None, c_void_p),
    "rbt_strerror": (c_char_p, c_int),
    "rbt_grains_batch": (c_int, c_void_p, c_size_t, c_uint64, c_void_p, c_void_p),
    "rbt_sample_batch": (
        *(c_int, c_void_p, c_size_t, c_void_p, c_uint64, c_void_p, c_void_p, c_void_p),
    ),
    "rbt_rebound_batch": (
        *(c_int, c_void_p, c_size_t, c_void_p, c_uint64, c_void_p, c_void_p, c_void_p),
    ),
    "rbt_wall_tilt": (c_int, c_double, c_double, c_double, c_double, c_void_p),
    "rbt_mean_half_size": (c_double, c_void_p, c_double),
}


@cache
def library() -> Any:
    """Load the library.

    Raises
    ------
    ImportError
        If it was not built; says how to build it.
    """
    place = os.environ.get(_VARIABLE, str(_PLACE))
    try:
        loaded = ctypes.CDLL(place)
    except OSError as error:
        build = Path(__file__).parent / "c" / "build.py"
        raise ImportError(
            f"the compiled draw cannot be loaded ({error}); install the package with pip, or run: "
            f"python {build}"
        ) from None
    for name, (result, *arguments) in _FUNCTIONS.items():
        function = getattr(loaded, name)
        function.restype, function.argtypes = result, arguments
    return loaded


class OpenTable:
    """A binary image that the library has checked and opened.

    Copies and pickles hold the image and open it again.

    Parameters
    ----------
    image : uint8 array
        The bytes of a binary table, from `sampler.formats.image.table_image`.

    Attributes
    ----------
    image : uint8 array
    handle : int
        Address of the ``rbt_table``, for C, `sampler.draw` and `sampler.rebound`.

    Raises
    ------
    TableError
        If the library refuses the image.
    """

    def __init__(self, image: Image) -> None:
        if image.ctypes.data % 64 != 0:  # as after unpickling
            moved = aligned(image.size)
            moved[:] = image
            image = moved
        table = c_void_p()
        code = library().rbt_open_image(image.ctypes.data, image.size, ctypes.addressof(table))
        if code != OK:
            raise TableError(library().rbt_strerror(code).decode())
        assert table.value is not None
        self.image, self.handle = image, table.value
        weakref.finalize(self, library().rbt_close, table.value)

    def __reduce__(self) -> tuple[Any, ...]:
        return OpenTable, (self.image,)


class Report(NamedTuple):
    """What a batch reports of its rows; rows are -1 for none.

    Attributes
    ----------
    bad_row, code : int
        The first row with an error, and its code.
    clamped_row, clamped : int
        The first row outside the table, and how many there are.
    extrapolated : int
        Number of rows with a speed at which the laws of the pair were not measured.
    """

    bad_row: int
    code: int
    clamped_row: int
    clamped: int
    extrapolated: int


class Rows(NamedTuple):
    """Arguments of a batch by name; an array of one row stands for all rows.

    Attributes
    ----------
    n : int
        Number of rows.
    seed : int
    arrays : dict of contiguous arrays, shape (n, ...) or (1, ...)
        float64, but ``index`` (uint64) and ``hit`` (uint32).
    fresh : bool
        Whether a particle has another grain at each hit.
    """

    n: int
    seed: int
    arrays: dict[str, NDArray[Any]]
    fresh: bool


def sample(table: OpenTable, rows: Rows, states: NDArray[Any], threads: int | None) -> Report:
    """Draw the states of all rows.

    Parameters
    ----------
    table : OpenTable
    rows : Rows
        ``alpha1``, ``speed``, ``index``, ``hit`` and, if they are given, ``spin`` and ``grain``.
    states : float64 or float32 array, shape (n, n_columns), written
    threads : int or None
        None: as many as the number of rows is worth.
    """
    draw = library().rbt_sample_batch
    single = states.dtype == np.float32

    def run(place: Callable[[str], int | None], start: int, count: int, report: int) -> int:
        given = _Conditions(*map(place, ("alpha1", "speed", "spin", "grain", "index", "hit")))
        given.fresh_grains = rows.fresh
        out = states.ctypes.data + start * states.strides[0]
        where = (None, out) if single else (out, None)
        return draw(table.handle, count, ctypes.addressof(given), rows.seed, *where, report)

    return _run(run, rows, threads)


def rebound(
    table: OpenTable,
    rows: Rows,
    velocity: NDArray[np.float64],
    omega: NDArray[np.float64],
    threads: int | None,
    isotropic: bool,
) -> Report:
    """Rebound the particles of all rows.

    Parameters
    ----------
    table : OpenTable
    rows : Rows
        ``velocity``, ``normal``, ``half_size``, ``index``, ``hit`` and, if they are given,
        ``wall_velocity``, ``omega``, ``roughness`` and ``grain``.
    velocity, omega : float64 array, shape (n, 3), written
        After the rebound, m/s and rad/s, lab frame.
    threads : int or None
        As for `sample`.
    isotropic : bool
        Whether facets of rough walls are tilted across the plane of incidence as well.
    """
    bounce = library().rbt_rebound_batch
    names = [field[0] for field in _Impacts._fields_ if field[1] is c_void_p]

    def run(place: Callable[[str], int | None], start: int, count: int, report: int) -> int:
        given = _Impacts(*map(place, names))
        given.fresh_grains, given.isotropic = rows.fresh, isotropic
        after = [array.ctypes.data + 24 * start for array in (velocity, omega)]
        return bounce(table.handle, count, ctypes.addressof(given), rows.seed, *after, report)

    return _run(run, rows, threads)


def grains(table: OpenTable, seed: int, index: NDArray[np.uint64], n: int) -> NDArray[np.float64]:
    """Draw the grains that n particles keep, shape (n, 3); `index` has shape (n,) or (1,)."""
    whole = np.ascontiguousarray(np.broadcast_to(index, (n,)))
    found = np.empty((n, 3))
    address = found.ctypes.data
    library().rbt_grains_batch(table.handle, n, seed, whole.ctypes.data, address)
    return found


def _run(run: Callable[..., int], rows: Rows, threads: int | None) -> Report:
    """Run a batch function over slices of all rows, up to the first with an error."""
    n = rows.n
    if threads is None:
        worth = n // _ROWS_PER_THREAD
        threads = min(processors(), worth) if worth > 1 else 1
    parts = threads * max(1, math.ceil(n / (threads * SLICE))) if threads > 1 or n > SLICE else 1
    longest = math.ceil(n / parts)
    arrays = {name: _long_enough(array, n, longest) for name, array in rows.arrays.items()}
    at = {name: array.ctypes.data for name, array in arrays.items()}
    step = {name: array.strides[0] if len(array) == n else 0 for name, array in arrays.items()}
    first_bad = [n]  # start of a slice with an error: those behind it need not run

    def part(ends: tuple[int, int]) -> Report:
        start, end = ends
        report = _Report()
        if start > first_bad[0] or end == start:
            return Report(-1, OK, -1, 0, 0)

        def place(name: str) -> int | None:
            return at[name] + start * step[name] if name in at else None

        code = run(place, start, end - start, ctypes.addressof(report))
        if code < OK:
            first_bad[0] = min(first_bad[0], start)
        return Report(
            start + report.row if code < OK else -1,
            min(code, OK),
            start + report.clamped_row if report.clamped else -1,
            report.clamped,
            report.extrapolated,
        )

    slices = list(pairwise(n * k // parts for k in range(parts + 1)))
    if threads == 1:
        return _merged([part(ends) for ends in slices])
    with ThreadPoolExecutor(threads) as pool:
        return _merged(list(pool.map(part, slices)))


def _long_enough(array: NDArray[Any], n: int, longest: int) -> NDArray[Any]:
    """Repeat a row that stands for all as often as a slice has rows."""
    if len(array) == n or len(array) > 1:
        return array
    return np.repeat(array, longest, axis=0)


def processors() -> int:
    """Count the processors that this process may use, of those that the machine has."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _merged(parts: list[Report]) -> Report:
    """Put the reports of slices together; counts are of the rows before the first error."""
    bad = next((k for k, part in enumerate(parts) if part.bad_row >= 0), len(parts) - 1)
    told = parts[: bad + 1]
    first = next((part.clamped_row for part in told if part.clamped_row >= 0), -1)
    clamped, extrapolated = sum(p.clamped for p in told), sum(p.extrapolated for p in told)
    return Report(parts[bad].bad_row, parts[bad].code, first, clamped, extrapolated)
