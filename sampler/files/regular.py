"""What a path leads to: a regular file, or what a program could wait for or damage."""

import os
import stat
from collections.abc import Iterable
from pathlib import Path

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def other_kind(mode: int) -> str:
    """Kind of what has this mode, in words; empty for a regular file."""
    return next((words for test, words in _KINDS if test(mode)), "")


def reason(error: Exception) -> str:
    """Few words of the system on a path that cannot be used."""
    told = error.strerror if isinstance(error, OSError) else None
    return told or str(error).partition("\n")[0]


def _identity(path: str | Path | int) -> tuple[int, int, str]:
    """Device and number of a file, or those of its folder with its name if it is yet to come."""
    try:
        found, name = os.stat(path), ""
    except FileNotFoundError:
        assert not isinstance(path, int)
        folder, name = os.path.split(os.path.realpath(path))
        found = os.stat(folder)
    return found.st_dev, found.st_ino, name


def is_one_of(path: str | Path | int, others: Iterable[str | Path | int]) -> bool:
    """Whether a path leads to the same file as another, also through links or spelt otherwise.

    Parameters
    ----------
    path : str or Path or int
        A file that is there, or is yet to come in a folder that is; or a file descriptor.
    others : iterable of the same
    """
    try:
        own = _identity(path)
    except (OSError, ValueError):
        return False
    for other in others:
        try:
            if _identity(other) == own:
                return True
        except (OSError, ValueError):
            continue  # where nothing can be, there is nothing to be the same
    return False
