"""Show the progress of long work: a bar on a terminal, or a line every half minute in a log."""

import sys
from contextlib import suppress
from typing import Any, TextIO

from tqdm import tqdm

#: Seconds between two lines of a log, and before the first line.
INTERVAL = 30.0

_LINE = "{desc}: {n_fmt} of {total_fmt} {unit}s, {elapsed} so far, {remaining} left{postfix}"


class _LineFile:
    """File for tqdm that writes each state of a bar on a new line, as a log needs it."""

    def __init__(self, file: TextIO) -> None:
        self._file = file

    def write(self, text: str) -> None:
        """Write a state of the bar. A cleared bar is empty, and nothing is written."""
        if line := text.strip("\r\n ").removeprefix(": "):
            with suppress(OSError):  # a log that is full or has no reader ends no work
                self._file.write(f"tablegen: {line}\n")

    def flush(self) -> None:
        """Flush the file; tqdm needs this method."""
        with suppress(OSError):
            self._file.flush()


def draws_over(file: TextIO) -> bool:
    """Return whether a bar can be redrawn in place, as on a terminal or in a notebook."""
    return file.isatty() or "ipykernel" in sys.modules


def bar(shown: bool, unit: str = "step", **settings: Any) -> tqdm:
    """Make a progress bar on standard error, for use in a ``with`` block.

    If standard error is not a terminal, the bar writes a line every `INTERVAL` seconds instead.

    Parameters
    ----------
    shown : bool
        Whether anything is shown.
    unit : str
        What is counted, in the singular.
    **settings
        Arguments of tqdm: ``total``, ``desc``, ``initial``, ``postfix``, ``unit_scale``.
    """
    shown = shown and sys.stderr is not None  # None: standard error is closed
    if not shown or draws_over(sys.stderr):
        return tqdm(unit=unit, disable=not shown, **settings)
    return tqdm(
        unit=unit,
        file=_LineFile(sys.stderr),
        bar_format=_LINE,
        ascii=True,
        delay=INTERVAL,
        mininterval=INTERVAL,
        maxinterval=INTERVAL,
        miniters=1,
        **settings,
    )
