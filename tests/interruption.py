"""Ctrl-C in the middle of a call."""

import signal
import threading
import time
from contextlib import contextmanager

import pytest

#: Seconds after which Ctrl-C comes.
_AFTER = 0.05


def _press():
    time.sleep(_AFTER)
    signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)


@contextmanager
def interrupted(within):
    """Send Ctrl-C into a block soon after it began, and check that it then soon ends."""
    threading.Thread(target=_press).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        yield
    assert time.monotonic() - start < _AFTER + within
