"""Progress of long work: bars on a terminal, and a line now and then in a log."""

import sys
from typing import Any, TextIO

from tqdm import tqdm

#: Seconds between two lines of a log, and before the first one.
INTERVAL = 30.0

_LINE = "{desc}: {n_fmt} of {total_fmt} {unit}s, {elapsed} so far, {remaining} left{postfix}"


class _Lines:
    """File that writes every redrawn bar as a line of its own."""

    def __init__(self, file: TextIO) -> None:
        self._file = file

    def write(self, text: str) -> None:
        """Write a redrawn bar; a cleared one is left out."""
        if line := text.strip("\r\n ").removeprefix(": "):
            self._file.write(f"tablegen: {line}\n")

    def flush(self) -> None:
        """Flush the file."""
        self._file.flush()


def draws_over(file: TextIO) -> bool:
    """Whether a bar can be redrawn in place: on a terminal and in a notebook."""
    return file.isatty() or "ipykernel" in sys.modules


def bar(shown: bool, unit: str = "step", **settings: Any) -> tqdm:
    """Make a progress bar on standard error, to be used in a ``with`` block.

    Without a terminal it is a line every `INTERVAL` seconds. ``unit`` is that of the count, in the
    singular; ``settings`` are ``total``, ``desc``, ``initial``, ``postfix``, ``unit_scale`` of
    tqdm.
    """
    if not shown or draws_over(sys.stderr):
        return tqdm(unit=unit, disable=not shown, **settings)
    lines: Any = {"file": _Lines(sys.stderr), "bar_format": _LINE, "ascii": True}
    pace: Any = {"delay": INTERVAL, "mininterval": INTERVAL, "maxinterval": INTERVAL, "miniters": 1}
    return tqdm(unit=unit, **lines, **pace, **settings)
