"""The rows of a batch shared among threads, and what the batch kernels report of them."""

import math
import threading
from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

from sampler.compilation.side_by_side import go_on, side_by_side
from sampler.errors import OK
from sampler.library import processors

#: Draws below which a further thread costs more than it saves.
_DRAWS_PER_THREAD = 20_000

#: Rows of a slice at most: a tenth of a second, and enough for the start of it to cost nothing.
_SLICE = 2**18


class Counter:
    """A count to which any thread may add; a copy of it, in another process or not, is 0."""

    def __init__(self) -> None:
        self.value = 0
        self._lock = threading.Lock()

    def add(self, count: int) -> bool:
        """Add a count; whether it is the first."""
        with self._lock:
            first, self.value = self.value == 0, self.value + count
        return first

    def __reduce__(self) -> tuple[type["Counter"], tuple[()]]:
        return Counter, ()


class Report(NamedTuple):
    """What a batch kernel says of its rows; rows are -1 for none."""

    bad_row: int
    code: int
    clamped_row: int
    clamped: int
    extrapolated: int


def run_rows(
    batch: Callable[..., Any], arguments: tuple[Any, ...], n: int, threads: int | None
) -> list[Report]:
    """Run a batch kernel over slices of n rows; return the reports of the slices, in order.

    The last is the first with an error, if there is one. Slices are so short that Ctrl-C, which
    comes between them, ends a run at once.

    Parameters
    ----------
    batch : callable
        Takes the arguments, first row and end; returns the numbers of a `Report`.
    arguments : tuple
    n : int
    threads : int or None
        None: as many as the number of rows is worth.
    """
    if threads is None:
        worth = n // _DRAWS_PER_THREAD
        threads = min(processors(), worth) if worth > 1 else 1
    if threads == 1 and n <= _SLICE:
        return [Report(*batch(*arguments, 0, n))]
    parts = threads * max(1, math.ceil(n / (threads * _SLICE)))
    slices = pairwise(n * k // parts for k in range(parts + 1))

    def run(rows: tuple[int, int]) -> Report:
        go_on()
        return Report(*batch(*arguments, *rows))

    reports = []
    for report in map(run, slices) if threads == 1 else side_by_side(run, slices, threads):
        reports.append(report)
        if report.bad_row >= 0:
            break
    return reports


def merge(parts: list[Report], outside_is_bad: bool) -> Report:
    """First error and first clamped row of all slices; an error hides what follows."""
    clamped_row = next((part.clamped_row for part in parts if part.clamped_row >= 0), -1)
    bad = next((part for part in parts if part.bad_row >= 0), None)
    if bad is not None and not (outside_is_bad and 0 <= clamped_row < bad.bad_row):
        return bad
    clamped, extrapolated = (sum(column) for column in list(zip(*parts, strict=True))[3:])
    return Report(-1, OK, clamped_row, clamped, extrapolated)
