"""Transitional: threads for rooms that do not have theirs yet."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any


class ThreadPool(ThreadPoolExecutor):
    """Threads."""


def go_on() -> None:
    """Do nothing."""


def side_by_side(run: Callable[[Any], Any], slices: Iterable[Any], threads: int) -> Iterator[Any]:
    """Run a function on slices in threads."""
    with ThreadPoolExecutor(threads) as pool:
        yield from pool.map(run, slices)
