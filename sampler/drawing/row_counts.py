"""What a batch counts of its rows: the first clamped row (-1: none), clamped, extrapolated rows."""

from sampler.compilation.jit import no_refcount_inline_kernel
from sampler.errors import CLAMPED
from sampler.formats.bounds import TableArrays

Counts = tuple[int, int, int]

#: Before the first row.
NO_ROWS: Counts = (-1, 0, 0)


@no_refcount_inline_kernel
def counted(counts: Counts, row: int, status: int, beyond: int) -> Counts:
    """Add a row to the counts.

    Parameters
    ----------
    counts : tuple of three int
    row : int
        Its number.
    status : int
        `OK` or `CLAMPED`.
    beyond : int
        1 where it extrapolates the laws of the pair, else 0; or how many rows of a block do.
    """
    first, clamped, extrapolated = counts
    if status == CLAMPED:
        first = row if first < 0 else first
        clamped += 1
    return first, clamped, extrapolated + beyond


@no_refcount_inline_kernel
def extrapolates(arrays: TableArrays, speed: float) -> int:
    """1 where the pair's laws were not measured at the speed of an impact, else 0."""
    slow, fast = arrays.valid_speed
    return int(not slow <= speed <= fast)
