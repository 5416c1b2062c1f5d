"""Input files: regular files, read whole up to a size, and nothing that could be waited for."""

import os
from pathlib import Path

from sampler.errors import InputError
from sampler.files.regular import other_kind, reason

#: Most bytes of a file that is read whole, where a reader does not ask for fewer.
MOST_BYTES = 2**30

#: Opens a pipe without waiting for who writes into it; Windows has no such pipes.
_AT_ONCE = getattr(os, "O_NONBLOCK", 0)


def check_input(what: str, path: str | os.PathLike[str], allowed: str = "a regular file") -> Path:
    """Refuse a file that cannot be read, or that may have no end, before anything is read.

    Parameters
    ----------
    what : str
        What is read, to open the error message.
    path : str or path-like
        Links are followed.
    allowed : str
        What may be in its place.

    Returns
    -------
    Path
        The same path.

    Raises
    ------
    InputError
        If there is no such file, or it is a folder, a pipe, a socket or a device, or may not be
        read.
    """
    try:
        other = other_kind(os.stat(path).st_mode)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"{what}: got {path}, allowed: a file that exists") from None
    except (OSError, ValueError) as error:
        raise _unreadable(what, path, error) from error
    if other:
        raise InputError(f"{what}: got {path}, {other}, allowed: {allowed}")
    if not os.access(path, os.R_OK):
        raise _unreadable(what, path, PermissionError(0, "Permission denied"))
    return Path(path)


def read_file(what: str, path: str | os.PathLike[str], most: int = MOST_BYTES) -> bytes:
    """Bytes of a regular file.

    Parameters
    ----------
    what : str
        What is read, to open the error message.
    path : str or path-like
    most : int
        Largest size.

    Raises
    ------
    InputError
        As `check_input`; also if the file is larger or grows, or reading fails.
    """
    check_input(what, path)
    try:
        with open(path, "rb", opener=_open_at_once) as file:
            # a pipe may have taken the place of the file since it was looked at
            status = os.fstat(file.fileno())
            if other := other_kind(status.st_mode):
                raise InputError(f"{what}: got {path}, {other}, allowed: a regular file")
            if status.st_size > most:
                got = f"{path} of {status.st_size} bytes"
                raise InputError(f"{what}: got {got}, allowed: up to {most}")
            data = file.read(status.st_size + 1)
    except OSError as error:
        raise _unreadable(what, path, error) from error
    if len(data) != status.st_size:  # some files of the system say so and have no end
        raise InputError(
            f"{what}: got {path}, of another size than it says, allowed: a file at rest"
        )
    return data


def _open_at_once(path: str, flags: int) -> int:
    return os.open(path, flags | _AT_ONCE)


def _unreadable(what: str, path: str | os.PathLike[str], error: Exception) -> InputError:
    return InputError(
        f"{what}: got {path}, which cannot be read ({reason(error)}), allowed: a file that can"
    )
