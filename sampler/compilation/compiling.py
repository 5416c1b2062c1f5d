"""A line in the log when kernels are about to be compiled, which takes a while the first time.

It goes to the log ``sampler`` as a warning, which Python prints on standard error unless the
program has set up logging otherwise.
"""

import logging
from collections.abc import Callable

from numba.core import event

_LOG = logging.getLogger("sampler")

#: What the kernels of a package are, and how long they take to compile.
_PARTS = {
    "sampler": ("the draw", "a few seconds"),
    "tablegen": ("the direct model", "up to half a minute"),
}


class _CompilationLogger(event.Listener):
    """Logs once a process and part what is being compiled; kernels from the cache are not."""

    def __init__(self, log: Callable[[str], None]) -> None:
        self._log = log
        self._logged: set[str] = set()

    def on_start(self, event: event.Event) -> None:
        """Log the part of a kernel that is being compiled."""
        kernel = event.data["dispatcher"].py_func
        # code that was made by exec may belong to no module
        package = (kernel.__module__ or "").partition(".")[0]
        if package not in _PARTS or package in self._logged:
            return
        self._logged.add(package)
        part, time = _PARTS[package]
        self._log(f"compiling {part} for this processor, which takes {time} and happens once")

    def on_end(self, event: event.Event) -> None:
        """Do nothing when a kernel has been compiled."""


def log_compilations() -> None:
    """Log from now on when kernels are being compiled."""
    event.register("numba:compile", _CompilationLogger(_LOG.warning))
