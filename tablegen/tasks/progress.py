"""Progress of long work: a bar on a terminal, a line now and then anywhere else."""

import sys
from typing import Any, TextIO

from tqdm import tqdm

#: Seconds between two lines where there is no terminal, and before the first one.
INTERVAL = 30.0

_LINE = "{desc}: {n_fmt} of {total_fmt} {unit}s, {elapsed} so far, {remaining} left{postfix}"


class _Lines:
    """File that gets what a bar draws over and over as lines, for a log."""

    def __init__(self, file: TextIO) -> None:
        self._file = file

    def write(self, text: str) -> None:
        """Write a line of a bar that starts over; the clearing of a bar is nothing."""
        if line := text.strip("\r\n ").removeprefix(": "):
            self._file.write(f"tablegen: {line}\n")

    def flush(self) -> None:
        """Bring the lines out."""
        self._file.flush()


def draws_over(file: TextIO) -> bool:
    """Whether a bar can be drawn over and over: on a terminal and in a notebook."""
    return file.isatty() or "ipykernel" in sys.modules


def bar(shown: bool, unit: str = "step", **settings: Any) -> tqdm:
    """Make the progress bar of a piece of work.

    Parameters
    ----------
    shown : bool
        Whether it is seen at all. On standard error, where that is no terminal as a line every
        `INTERVAL` seconds, so that nothing is said of short work.
    unit : str
        What is counted, in the singular.
    **settings
        Of `tqdm.tqdm`: ``total``, ``desc``, ``initial``, ``postfix``, ``unit_scale``.

    Returns
    -------
    tqdm
        To be used in a ``with`` block; ``update(n)`` counts.
    """
    if not shown or draws_over(sys.stderr):
        return tqdm(unit=unit, disable=not shown, **settings)
    lines: Any = {"file": _Lines(sys.stderr), "bar_format": _LINE, "ascii": True}
    pace: Any = {"delay": INTERVAL, "mininterval": INTERVAL, "maxinterval": INTERVAL, "miniters": 1}
    return tqdm(unit=unit, **lines, **pace, **settings)
