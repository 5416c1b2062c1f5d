"""Files under a lock of the operating system, which no crash leaves behind."""

import logging
import os
from pathlib import Path
from typing import BinaryIO

try:
    import fcntl
except ImportError:  # not a Unix
    fcntl = None  # type: ignore[assignment]

_LOG = logging.getLogger("tablegen")


def open_locked(path: Path) -> BinaryIO | None:
    """Open a file under an exclusive lock, and make it where there is none.

    The lock belongs to the open file: it ends when that is closed, or with the process, however
    that ends. Between machines it holds as far as the file system carries locks: NFS does, unless
    it is mounted with ``nolock`` or ``local_lock``; where there are none at all, a note says so and
    the file is open without.

    Parameters
    ----------
    path : Path
        In a folder that exists.

    Returns
    -------
    BinaryIO or None
        Open to read and to append; None if who held the lock has removed the file meanwhile.

    Raises
    ------
    BlockingIOError
        If the lock is held already, by this process or another one.
    OSError
        If the file cannot be made or opened to write.
    """
    file = open(path, "a+b")  # noqa: SIM115  (the caller closes it)
    try:
        _lock(file, path)
        if _is_file_of(path, file):
            return file
    except BaseException:
        file.close()
        raise
    file.close()
    return None


def _lock(file: BinaryIO, path: Path) -> None:
    reason = "this operating system has no such locks"
    if fcntl is not None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            raise
        except OSError as error:
            reason = str(error.strerror)
    _LOG.warning("%s is not locked (%s): see that no other run uses it", path.parent, reason)


def _is_file_of(path: Path, file: BinaryIO) -> bool:
    """Whether a path still leads to an open file."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False
