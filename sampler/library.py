"""The compiled library of the draw (`sampler/c`), called through ctypes on slices of rows.

Arrays go in as addresses, and the GIL is released while the library works. Rows are cut into slices
of at most `SLICE`, which threads share: the same states for any number of threads.
"""

import atexit
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

from sampler.errors import FLAGS, OK, TableError
from sampler.formats.channels import VARIABLES, WORKS
from sampler.formats.image import Image, aligned
from sampler.formats.records import NUMBER, RECORDS

#: Rows of a slice at most: few enough for Ctrl-C, which comes between slices, to end a run at once.
SLICE = 2**16

#: The library beside this module; the variable names another build of it, for tests and profilers.
_LIBRARY_PATH = Path(__file__).with_name("librebound.so")
_PATH_VARIABLE = "REBOUND_SAMPLER_LIBRARY"


def _record(name: str) -> Any:
    """Make a record of `rebound_sampler.h`."""
    kinds = {"int": c_int, "size_t": c_size_t}
    fields = []
    for field in RECORDS[name]:
        kind = kinds[field.kind] if field.role == NUMBER else c_void_p
        is_array = field.role == NUMBER and field.width > 1
        fields.append((field.name, kind * field.width if is_array else kind))
    return type(name.capitalize(), (ctypes.Structure,), {"_fields_": fields})


Conditions, Impacts, Rebounds = map(_record, ("conditions", "impacts", "rebounds"))

#: Functions of the library: result, then arguments.
_FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "rbt_open_image": (c_int, c_void_p, c_size_t, c_void_p),
    "rbt_open_direct": (c_int, c_void_p, c_size_t, c_char_p, c_void_p),
    "rbt_close": (None, c_void_p),
    "rbt_strerror": (c_char_p, c_int),
    "rbt_covered": (c_int, c_void_p, c_void_p),
    "rbt_has_variable": (c_int, c_void_p, c_int),
    "rbt_grains": (c_int, c_void_p, c_size_t, c_uint64, c_void_p, c_void_p, c_void_p),
    "rbt_sample": (c_int, c_void_p, c_size_t, c_void_p, c_uint64, c_void_p, c_void_p),
    "rbt_rebound": (c_int, c_void_p, c_size_t, c_void_p, c_uint64, c_void_p),
    "rbt_mean_half_size": (c_double, c_void_p, c_double),
    "rbt_sample_all": (c_int, c_void_p, c_size_t, c_void_p, c_uint64, c_void_p, c_void_p),
    # of library.c: the number of rows, the arguments, the result
    "rbt_wall_tilt_rows": (None, c_size_t, *5 * [c_void_p]),
    "rbt_gas_torque_rows": (None, c_size_t, *6 * [c_void_p]),
    "rbt_spin_after_rows": (None, c_size_t, *8 * [c_void_p]),
    "rbt_half_size_rows": (None, c_size_t, *4 * [c_void_p]),
    "rbt_mean_inertia_rows": (None, c_size_t, *3 * [c_void_p]),
    "rbt_sphericity_rows": (None, c_size_t, *3 * [c_void_p]),
    "rbt_critical_speed_rows": (None, c_size_t, *7 * [c_void_p]),
    "rbt_deposits_rows": (None, c_size_t, *5 * [c_void_p]),
}


@cache
def library() -> Any:
    """Load the library.

    Raises
    ------
    ImportError
        If it was not built; says how to build it.
    """
    path = os.environ.get(_PATH_VARIABLE, str(_LIBRARY_PATH))
    try:
        loaded = ctypes.CDLL(path)
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


#: Tables whose memory outlives the interpreter: compiled code that knows only their address may
#: draw from them in a daemon thread until the process ends.
_open_tables: "weakref.WeakSet[OpenedTable]" = weakref.WeakSet()


@atexit.register
def _keep_open_tables() -> None:
    for table in _open_tables:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(table))


class OpenedTable:
    """A table that the library has opened.

    Parameters
    ----------
    open_table : callable
        Function of the library that takes the address of the table that it opens.

    Attributes
    ----------
    handle : int
        Address of the ``rbt_table``, for C and `sampler.numba`.

    Raises
    ------
    TableError
        If the library refuses to open it.
    """

    #: Rows below which a further thread costs more than it saves.
    rows_per_thread = 20_000

    def __init__(self, open_table: Callable[[int], int]) -> None:
        table = c_void_p()
        code = open_table(ctypes.addressof(table))
        if code != OK:
            raise TableError("table", problem=library().rbt_strerror(code).decode())
        assert table.value is not None
        self.handle = table.value
        weakref.finalize(self, library().rbt_close, table.value).atexit = False
        _open_tables.add(self)

    def has_works(self) -> bool:
        """Tell whether rebounds have works, the energies that the impulses take."""
        places = (VARIABLES.index(name) for name in WORKS)
        return all(library().rbt_has_variable(self.handle, place) for place in places)

    def covered(self) -> dict[str, tuple[float, float]]:
        """Give the ends of what ``rbt_covered`` names: alpha1, rad, speed, spin, measured."""
        ends = np.empty((4, 2))
        library().rbt_covered(self.handle, ends.ctypes.data)
        names = ("alpha1", "speed", "spin", "measured")
        return {name: (float(a), float(b)) for name, (a, b) in zip(names, ends, strict=True)}


class OpenDirect(OpenedTable):
    """A table without a file, whose law is direct simulation.

    Parameters
    ----------
    law : int
        Address of an ``rbt_direct_law``, which must stay where it is.
    columns : list of int
        Places of the variables of a state among `sampler.formats.channels.VARIABLES`.
    """

    #: A rebound takes a microsecond, and a call in a thread some ten.
    rows_per_thread = 512

    def __init__(self, law: int, columns: list[int]) -> None:
        places = bytes(columns)
        super().__init__(lambda place: library().rbt_open_direct(law, len(columns), places, place))


class OpenTable(OpenedTable):
    """A binary image that the library has checked and opened.

    Copies and pickles hold the image and open it again.

    Parameters
    ----------
    image : uint8 array
        The bytes of a binary table, from `sampler.formats.image.table_image`.

    Attributes
    ----------
    image : uint8 array
    """

    def __init__(self, image: Image) -> None:
        if image.ctypes.data % 64 != 0:  # as after unpickling
            moved = aligned(image.size)
            moved[:] = image
            image = moved
        address, size = image.ctypes.data, image.size
        super().__init__(lambda place: library().rbt_open_image(address, size, place))
        self.image = image

    def __reduce__(self) -> tuple[Any, ...]:
        return OpenTable, (self.image,)


class Rows(NamedTuple):
    """Arguments of n rows by name: contiguous arrays (n, ...), or (1, ...) of one for all rows.

    They are float64, but ``index`` (uint64) and ``hit`` (uint32); fresh: another grain at each hit.
    """

    n: int
    seed: int
    arrays: dict[str, NDArray[Any]]
    fresh: bool


class Report(NamedTuple):
    """Codes of the rows of a call, and what there is among them.

    Attributes
    ----------
    codes : int array, shape (n,), or None
        None: all are 0.
    bad : bool
        Whether any is an error.
    counts : tuple of int
        Numbers of rows with each of `sampler.errors.FLAGS`.
    """

    codes: NDArray[np.intc] | None
    bad: bool
    counts: tuple[int, ...]

    @classmethod
    def from_codes(cls, codes: NDArray[np.intc]) -> "Report":
        """Look through codes, in the memory of the host or of a GPU."""
        bad = bool((codes < 0).any())
        # bytes take a third of the time
        flags = (codes.clip(0) if bad else codes).astype(np.uint8)
        counts = (int(np.count_nonzero(flags & flag)) for flag in FLAGS.values())
        return cls(codes, bad, tuple(counts))


def sample(
    table: OpenedTable,
    rows: Rows,
    states: NDArray[np.float64] | None,
    threads: int | None,
    report: Report | None = None,
    inertia: NDArray[np.float64] | None = None,
    all_values: bool = False,
) -> Report:
    """Draw the states (n, n_columns) of all rows, NaN where there is an error; None: codes alone.

    `threads`: None for as many as are worth their cost. `report`: the codes, if they are known.
    `inertia` (n,) is written with those after the rebound. `all_values`: by direct simulation,
    write all numbers of ``RBT_DIRECT_VALUES`` in place of the columns, shape (n, 12).
    """
    draw = library().rbt_sample_all if all_values else library().rbt_sample

    def draw_slice(addresses: dict[str, int], start: int, count: int, codes: int | None) -> int:
        after = None if inertia is None else inertia.ctypes.data + start * inertia.itemsize
        conditions = Conditions(**addresses, inertia_after=after, fresh=rows.fresh)
        out = None if states is None else states.ctypes.data + start * states.strides[0]
        return draw(table.handle, count, ctypes.byref(conditions), rows.seed, out, codes)

    return _run_in_slices(draw_slice, table, rows, threads, report)


def rebound(
    table: OpenedTable,
    rows: Rows,
    results: dict[str, NDArray[np.float64]],
    threads: int | None,
    isotropic: bool,
) -> Report:
    """Write the results that are wanted: velocity, omega (n, 3), inertia (n,), works (n, 2).

    They are in the lab frame, in m/s, rad/s and J/kg, and NaN where there is an error, but what it
    was before where a particle does not approach the wall.
    """
    rbt_rebound = library().rbt_rebound

    def rebound_slice(addresses: dict[str, int], start: int, count: int, codes: int | None) -> int:
        impacts = Impacts(**addresses, fresh=rows.fresh, isotropic=isotropic)
        rebounds = Rebounds(codes=codes)
        for name, array in results.items():
            setattr(rebounds, name, array.ctypes.data + start * array.strides[0])
        records = ctypes.byref(impacts), ctypes.byref(rebounds)
        return rbt_rebound(table.handle, count, records[0], rows.seed, records[1])

    return _run_in_slices(rebound_slice, table, rows, threads)


def grains(
    table: OpenedTable,
    seed: int,
    index: NDArray[np.uint64],
    n: int,
    hit: NDArray[np.uint32] | None = None,
) -> NDArray[np.float64]:
    """Draw the grains of n particles, shape (n, 3); `index` and `hit` have shape (n,) or (1,).

    They are the grains that the particles keep, or with `hit` their fresh grains.
    """
    whole = np.ascontiguousarray(np.broadcast_to(index, (n,)))
    hits = None if hit is None else np.ascontiguousarray(np.broadcast_to(hit, (n,)))
    rows = np.empty((n, 3))
    address = None if hits is None else hits.ctypes.data
    library().rbt_grains(table.handle, n, seed, whole.ctypes.data, address, rows.ctypes.data)
    return rows


def _run_in_slices(
    run_slice: Callable[[dict[str, int], int, int, int | None], int],
    table: OpenedTable,
    rows: Rows,
    threads: int | None,
    known: Report | None = None,
) -> Report:
    """Run a function over slices of all rows, and return the codes of the rows.

    The function takes the addresses of the arguments by name, the first row and the number of rows
    of its slice, and the address of their codes. It returns the code of the call. If the codes are
    `known`, they are not written again.
    """
    n = rows.n
    if threads is None:
        worth = n // table.rows_per_thread
        threads = min(processors(), worth) if worth > 1 else 1
    parts = threads * max(1, math.ceil(n / (threads * SLICE))) if threads > 1 or n > SLICE else 1
    longest = math.ceil(n / parts)
    arrays = {name: _repeat_single_row(array, n, longest) for name, array in rows.arrays.items()}
    codes = np.empty(0 if known else n, np.intc)
    all_zero = Report(None, False, (0,) * len(FLAGS))

    def report_on(ends: tuple[int, int]) -> Report:
        start, end = ends
        addresses = {
            name: array.ctypes.data + (start * array.strides[0] if len(array) == n else 0)
            for name, array in arrays.items()
        }
        code_address = None if known else codes.ctypes.data + start * codes.itemsize
        code = run_slice(addresses, start, end - start, code_address)
        # now, while the codes are in the cache
        return Report.from_codes(codes[start:end]) if code and not known else all_zero

    slices = list(pairwise(n * k // parts for k in range(parts + 1)))
    if threads == 1:
        reports = [report_on(ends) for ends in slices]
    else:
        with ThreadPoolExecutor(threads) as pool:
            reports = list(pool.map(report_on, slices))
    if known:
        return known
    if all(report is all_zero for report in reports):
        return all_zero
    counts = tuple(map(sum, zip(*(report.counts for report in reports), strict=True)))
    return Report(codes, any(report.bad for report in reports), counts)


def _repeat_single_row(array: NDArray[Any], n: int, longest: int) -> NDArray[Any]:
    """Repeat a row that stands for all as often as a slice has rows."""
    if len(array) == n or len(array) > 1:
        return array
    return np.repeat(array, longest, axis=0)


def processors() -> int:
    """Count the processors that this process may use, of those that the machine has."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
