"""Pieces of work on threads, given up at once when they are no longer wanted.

Ctrl-C reaches the main thread alone, and only between two steps of Python. So the main thread
waits, and others work. Work that is given up, because of Ctrl-C or an error, ends when it next asks
`go_on`, in however many threads and pools it is.
"""

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any, TypeVar

_Piece = TypeVar("_Piece")
_Result = TypeVar("_Result")

#: Seconds for which what was given up is waited for: it may write to an array of the user's.
_PATIENCE = 0.4

#: Of a thread, ``given_up``: events that say that the work it does is no longer wanted.
_HERE = threading.local()


class GivenUpError(BaseException):
    """The work that this was a part of is no longer wanted."""


def go_on() -> None:
    """Raise `GivenUpError` where the work that this thread does is no longer wanted."""
    if any(event.is_set() for event in _given_up()):
        raise GivenUpError


def _given_up() -> tuple[threading.Event, ...]:
    events: tuple[threading.Event, ...] = getattr(_HERE, "given_up", ())
    return events


def _take_part(events: tuple[threading.Event, ...]) -> None:
    """Let this thread work on what the events tell of."""
    _HERE.given_up = events


class ThreadPool(ThreadPoolExecutor):
    """Threads that give up their work when the ``with`` block is left by an exception.

    What is under way cannot be stopped but where it asks `go_on`; the block does not wait for it.

    Parameters
    ----------
    threads : int
    """

    def __init__(self, threads: int) -> None:
        self._end = threading.Event()
        super().__init__(threads, initializer=_take_part, initargs=((*_given_up(), self._end),))

    def __exit__(self, kind: type[BaseException] | None, *error: Any) -> None:
        if kind is not None:
            self._end.set()
        self.shutdown(wait=kind is None, cancel_futures=kind is not None)


def side_by_side(
    work: Callable[[_Piece], _Result],
    pieces: Iterable[_Piece],
    threads: int,
    ahead: int | None = None,
) -> Iterator[_Result]:
    """Work on pieces in threads, and give the results in the order of the pieces.

    Ctrl-C ends it within a second, however long a piece takes, and as soon as the pieces under way
    are done where they are short. So does an error of a piece, and whoever closes the iterator.

    Parameters
    ----------
    work : callable
        Takes a piece. Where it is long, it asks `go_on` between steps.
    pieces : iterable
    threads : int
        1 or more. A single one is this thread itself, unless that is the one that Ctrl-C reaches.
    ahead : int, optional
        How many pieces are begun or waiting at most; by default all at once.
    """
    if threads == 1 and threading.current_thread() is not threading.main_thread():
        for piece in pieces:
            go_on()
            yield work(piece)
        return
    # a result is taken out when it is there, so that whoever leaves can wait for it
    under_way: deque[Future[_Result]] = deque()
    try:
        with ThreadPool(threads) as pool:
            for piece in pieces:
                under_way.append(pool.submit(work, piece))
                if ahead is not None and len(under_way) >= ahead:
                    yield under_way[0].result()
                    under_way.popleft()
            while under_way:
                yield under_way[0].result()
                under_way.popleft()
    except BaseException:
        wait([future for future in under_way if future.running()], _PATIENCE)
        raise
