"""Signals that end a program: in order where that is quick, and at once after a second.

Ctrl-C, or what asks a process to end, is a `KeyboardInterrupt` in the main thread, so that what was
begun is undone. The main thread may not hear of it, or be kept by others: by the compiler, a
kernel, a pipe that nobody reads. So a thread that only waits for signals ends the process then.
"""

import os
import select
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

#: Signals, as far as the system has them, and what is said of them.
_WORDS = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "terminated"}

#: Seconds for the main thread to end in order.
GRACE = 0.8


def _say_nothing(_: Any) -> None:
    """Take the place of a hook that prints a traceback."""


class EndedError(KeyboardInterrupt):
    """A signal ends the program.

    A class of its own, because Python remembers a plain `KeyboardInterrupt` that has passed through
    `exec`, and ``python -m`` then ends by SIGINT in place of the exit status.
    """


class _Ending:
    """What is known of the end of this process."""

    def __init__(self) -> None:
        #: Number of the signal that ends it, if any.
        self.signal: int | None = None
        #: Taken by who writes the line that says so: this thread or the watcher.
        self.line = threading.Lock()
        #: The end of the watcher's socket that signals write to. Kept, because to close it, which
        #: the block's end by an exception would do, wakes the watcher before it is time.
        self.told: socket.socket | None = None

    def begin(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal; the watcher sees to further ones."""
        if self.signal is None:
            self.signal = number
            # what it breaks off in a destructor or a thread is no news
            sys.unraisablehook = threading.excepthook = _say_nothing
            raise EndedError


_ENDING = _Ending()


def ending() -> tuple[int, str]:
    """Exit status of a program that is interrupted, and the word for it."""
    number = _ENDING.signal or signal.SIGINT
    return 128 + number, _WORDS[signal.Signals(number).name]


def first_to_say() -> bool:
    """Whether nobody has begun yet to write the line on the end, which the caller then does."""
    return _ENDING.line.acquire(blocking=False)


def is_ending() -> bool:
    """Whether a signal has told this process to end."""
    return _ENDING.signal is not None


@contextmanager
def ended_by_signals(program: str) -> Iterator[None]:
    """Block of a process whose signals end it; for the main thread.

    Where the parent has a signal ignored (``nohup``, a job in the background), it stays so.

    Parameters
    ----------
    program : str
        Name for the line that says so.
    """
    numbers = [getattr(signal, name) for name in _WORDS if hasattr(signal, name)]
    usual = (signal.SIG_DFL, signal.default_int_handler)
    numbers = [number for number in numbers if signal.getsignal(number) in usual]
    heard, told = socket.socketpair()
    told.setblocking(False)
    _ENDING.told = told
    watcher = threading.Thread(target=_watch, args=(program, heard, numbers), daemon=True)
    with suppress(RuntimeError):  # where the user may have no further thread: what is short works
        watcher.start()
    signal.set_wakeup_fd(told.fileno(), warn_on_full_buffer=False)
    for number in numbers:
        signal.signal(number, _ENDING.begin)
    yield
    if not is_ending():
        # nothing is left to undo
        for number in numbers:
            signal.signal(number, signal.SIG_DFL)
        signal.set_wakeup_fd(-1)
        told.close()


def _watch(program: str, heard: socket.socket, numbers: list[int]) -> None:
    """End the process a while after the first signal, or at the second."""
    while (read := heard.recv(1)) and read[0] not in numbers:
        pass  # of others that Python handles
    if not read:
        return
    select.select([heard], [], [], GRACE)
    _ENDING.signal = _ENDING.signal or read[0]
    status, word = ending()
    if first_to_say():
        say(f"{program}: {word}")
    os._exit(status)


def line_break() -> str:
    """End of the line that a terminal is in, after a ^C or in a bar."""
    return "\n" if os.isatty(2) else ""


def say(line: str) -> None:
    """Write a line on standard error, unless that would keep the process."""
    with suppress(OSError):
        if select.select([], [2], [], 0.0)[1]:
            os.write(2, f"{line_break()}{line}\n".encode())
