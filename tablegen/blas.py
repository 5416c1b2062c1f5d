"""One thread for the linear algebra of a whole process, while any piece is at work in it.

The pieces are the parallel work, and sums keep their order. `threadpool_limits` alone restores
what it found when it ends: of two pieces that overlap in time, the first to end would give the
other its threads back.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits

_lock = threading.Lock()
_held: list[threadpool_limits] = []
_users = 0


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep linear algebra to one thread until the last of all such blocks has ended."""
    global _users
    with _lock:
        if _users == 0:
            _held.append(threadpool_limits(limits=1, user_api="blas"))
        _users += 1
    try:
        yield
    finally:
        with _lock:
            _users -= 1
            if _users == 0:
                _held.pop().restore_original_limits()
