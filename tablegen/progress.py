"""Progress of long work: bars on a terminal, and a line now and then in a log."""

import sys
from typing import Any, TextIO

from tqdm import tqdm

#: Seconds between two lines of a log, and before the first one.
INTERVAL = 30.0

_LINE = "{desc}: {n_fmt} of {total_fmt} {unit}s, {elapsed} so far, {remaining} left{postfix}"


class _Lines:
    """File that writes each redrawn bar on a new line."""

    def __init__(self, file: TextIO) -> None:
        self._file = file

    def write(self, text: str) -> None:
        """Write a redrawn bar; a bar that was cleared is empty, and not written."""
        if line := text.strip("\r\n ").removeprefix(": "):
            self._file.write(f"tablegen: {line}\n")

    def flush(self) -> None:
        """Flush the file."""
        self._file.flush()


def draws_over(file: TextIO) -> bool:
    """Tell whether a bar can be redrawn in place, as on a terminal and in a notebook."""
    return file.isatty() or "ipykernel" in sys.modules


def bar(shown: bool, unit: str = "step", **settings: Any) -> tqdm:
    """Make a progress bar on standard error, for use in a ``with`` block.

    If standard error is no terminal, the bar is a line every `INTERVAL` seconds. ``unit`` is that
    of the count, in the singular. ``settings`` are arguments of tqdm: ``total``, ``desc``,
    ``initial``, ``postfix``, ``unit_scale``.
    """
    if not shown or draws_over(sys.stderr):
        return tqdm(unit=unit, disable=not shown, **settings)
    return tqdm(
        unit=unit,
        file=_Lines(sys.stderr),
        bar_format=_LINE,
        ascii=True,
        delay=INTERVAL,
        mininterval=INTERVAL,
        maxinterval=INTERVAL,
        miniters=1,
        **settings,
    )
