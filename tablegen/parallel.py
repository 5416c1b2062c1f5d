"""Work side by side: every way in which the generator uses the processors of a machine.

- `in_threads` works on independent pieces: conditions, chains of hits, cases of a study.
- `in_slices` works on the particles of one run, in short calls of a kernel.
- `thread_pool` runs the tasks of `tablegen.checkpoints.TaskRunner`, unless Dask or MPI does
  (`tablegen.tables.executors`).

Random numbers come from keys, so no result depends on the number of threads. The compiled draw of
the runtime splits its own rows (`sampler.library`).
"""

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from sampler.library import processors

#: Most particles in one call of a kernel.
LONGEST_SLICE = 5_000

#: Particles in the first calls, which show how long a call takes: at grazing angles a particle
#: takes thousands of times longer than at others.
_FIRST_SLICE = 50

#: Time that one call should take [s]: short enough to stop soon after Ctrl-C.
_SLICE_SECONDS = 0.1

_Piece = TypeVar("_Piece")
_Result = TypeVar("_Result")


@contextmanager
def thread_pool(threads: int) -> Iterator[ThreadPoolExecutor]:
    """Open a pool of threads.

    After an error or Ctrl-C the pieces that wait are dropped, and the block does not wait for those
    that run.
    """
    pool = ThreadPoolExecutor(threads)
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def in_threads(
    work: Callable[[_Piece], _Result],
    pieces: Iterable[_Piece],
    tick: Callable[[int], Any] = lambda _: None,
    threads: int | None = None,
) -> list[_Result]:
    """Work on independent pieces, each in one thread.

    Numerical libraries keep to one thread meanwhile: with more, the last bits of their sums would
    depend on the machine.

    Parameters
    ----------
    work : callable
        Takes a piece and returns its result.
    pieces : iterable
        What to work on.
    tick : callable, optional
        Called with 1 after each piece, for example the ``update`` of a progress bar.
    threads : int, optional
        By default one for each processor.

    Returns
    -------
    list
        The results in the order of the pieces.
    """
    results = []
    with threadpool_limits(limits=1):
        for result in _in_order(work, pieces, threads or processors()):
            results.append(result)
            tick(1)
    return results


def in_slices(
    work: Callable[[slice], _Result], count: int, threads: int
) -> Iterator[tuple[slice, _Result]]:
    """Work on slices of ``count`` particles; yield the slices and their results in order.

    The slices are as long as takes about a tenth of a second, whatever the condition.
    """
    length = _FIRST_SLICE

    def slices() -> Iterator[slice]:
        start = 0
        while start < count:
            stop = min(start + length, count)
            yield slice(start, stop)
            start = stop

    def timed(part: slice) -> tuple[slice, _Result]:
        nonlocal length
        begin = time.perf_counter()
        result = work(part)
        per_second = (part.stop - part.start) / max(time.perf_counter() - begin, 1e-9)
        length = int(min(max(_SLICE_SECONDS * per_second, 1.0), LONGEST_SLICE))
        return part, result

    return _in_order(timed, slices(), threads)


def _in_order(
    work: Callable[[_Piece], _Result], pieces: Iterable[_Piece], threads: int
) -> Iterator[_Result]:
    """Yield results in the order of the pieces, which are taken only a little ahead.

    One thread is that of the caller, without the cost of a pool.
    """
    if threads == 1:
        yield from map(work, pieces)
        return
    under_way: deque[Future[_Result]] = deque()
    with thread_pool(threads) as pool:
        for piece in pieces:
            under_way.append(pool.submit(work, piece))
            if len(under_way) == 2 * threads:
                yield under_way.popleft().result()
        while under_way:
            yield under_way.popleft().result()
