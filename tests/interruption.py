"""Ctrl-C in the middle of a call."""

import signal
import threading
import time
from contextlib import contextmanager

import pytest


def _press(begun, after):
    begun.wait()
    time.sleep(after)
    signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)


@contextmanager
def interrupted(within, after=0.05, begun=None):
    """Send Ctrl-C into a block some seconds after it began, and check that it soon ends."""
    if begun is None:
        begun = threading.Event()
        begun.set()
    threading.Thread(target=_press, args=(begun, after)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        yield
    assert time.monotonic() - start < after + within
