"""The program ``tablegen``, and ``python -m tablegen``."""

import ctypes
import os
import sys
from contextlib import suppress
from typing import NoReturn

#: M_ARENA_MAX of malloc.h of the GNU C library.
_MOST_ARENAS = -8


def _share_freed_memory() -> None:
    """Let all threads take memory from one arena.

    By default the GNU C library has an arena for each thread, which keeps the memory that this
    thread has freed. The threads of the next stage would then take their memory on top of it.
    """
    if sys.platform == "linux":
        with suppress(AttributeError):  # another C library
            ctypes.CDLL(None).mallopt(_MOST_ARENAS, 1)


def run() -> NoReturn:
    """Run the program and end the process with its exit status."""
    from sampler.options import INTERRUPTED
    from tablegen.commands.main import main

    _share_freed_memory()
    status = main()
    if status == INTERRUPTED:  # threads that still work are not waited for
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)


if __name__ == "__main__":
    run()
