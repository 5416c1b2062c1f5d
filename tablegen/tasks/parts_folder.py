"""The folder ``OUTPUT.parts`` of an unfinished run: what is ours in it, kept from other runs.

There are pieces, a stamp that says what they were made from, a table that is tried before, and
what a killed process left of a file that it was writing. Nothing else is ever removed or
overwritten: a folder with a file of any other name is not used. The lock is on the stamp, so that
it needs no file of its own.
"""

import os
import re
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from sampler.errors import InputError
from tablegen.tasks.file_lock import open_locked

_PIECE = re.compile(r"piece-[0-9a-f]{16}\.npz")
_REHEARSAL = "rehearsal.h5"
_STAMP = "recipe.sha256"

#: What is ours but for the stamp, also under the name that `sampler.files` gives a file
#: while it is written.
_WRITTEN = rf"({_PIECE.pattern}|{re.escape(_REHEARSAL)})"
_OURS = re.compile(rf"{_WRITTEN}|\.{_WRITTEN}\.[0-9a-f]+\.tmp")

#: Times that a run may end and take its folder away, just as this one opens it.
_ATTEMPTS = 100


def parts_path(output: Path) -> Path:
    """Folder of the pieces of an output, beside it; of a link, beside what it leads to."""
    target = Path(os.path.realpath(output)) if output.is_symlink() else output
    return target.with_name(f"{target.name}.parts")


def _is_ours(entry: os.DirEntry[str]) -> bool:
    """Whether we made it, going by its name; links and folders we never make."""
    known = entry.name == _STAMP or _OURS.fullmatch(entry.name) is not None
    return known and entry.is_file(follow_symlinks=False)


class PartsFolder:
    """The folder of a run, made where there is none and locked until it is closed.

    Parameters
    ----------
    output : Path
        The file that the run will write.

    Raises
    ------
    InputError
        If the folder cannot be made or written to, holds anything that is not ours, or belongs to
        a run that goes on.

    Attributes
    ----------
    path : Path
    """

    def __init__(self, output: Path) -> None:
        self.path = parts_path(output)
        try:
            self._check_all_is_ours()
            self._stamp = self._open_stamp()
        except BlockingIOError:
            raise InputError(
                f"output: got {output}, which another run is making, "
                "allowed: another file, or this one when that run has ended"
            ) from None
        except OSError as error:
            raise InputError(f"output: cannot make {self.path}: {error.strerror}") from error

    def _check_all_is_ours(self) -> None:
        if not os.path.isdir(self.path):
            return
        for entry in os.scandir(self.path):
            if not _is_ours(entry):
                raise InputError(
                    f"output: got {self.path} with {entry.name} in it, "
                    "allowed: none, or a folder with the pieces of a run only"
                )
        if not os.access(self.path, os.W_OK):
            raise InputError(f"output: got {self.path}, allowed: a folder that can be written")

    def _open_stamp(self) -> BinaryIO:
        for _ in range(_ATTEMPTS):
            self.path.mkdir(exist_ok=True)
            with suppress(FileNotFoundError):
                if (file := open_locked(self.path / _STAMP)) is not None:
                    return file
        raise BlockingIOError

    @property
    def pieces(self) -> int:
        """How many pieces there are."""
        return sum(_PIECE.fullmatch(entry.name) is not None for entry in self._ours())

    @property
    def fingerprint(self) -> str:
        """What the pieces were made from; empty if there are none yet."""
        self._stamp.seek(0)
        return self._stamp.read().decode(errors="replace")

    def begin(self, fingerprint: str) -> None:
        """Remove all pieces, and stamp the folder for new ones.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        self._remove_pieces()
        try:
            self._stamp.truncate(0)
            self._stamp.write(fingerprint.encode())
            self._stamp.flush()
        except OSError as error:
            self.close()
            raise InputError(f"output: cannot make {self.path}: {error.strerror}") from error

    def file(self, name: str) -> Path:
        """Path of the piece of a name, 16 hexadecimal digits."""
        return self.path / f"piece-{name}.npz"

    @property
    def rehearsal(self) -> Path:
        """Path of a table that is tried before there are pieces."""
        return self.path / _REHEARSAL

    def _ours(self) -> list[os.DirEntry[str]]:
        return [entry for entry in os.scandir(self.path) if _is_ours(entry)]

    def _remove_pieces(self) -> None:
        for entry in self._ours():
            if entry.name != _STAMP:
                os.unlink(entry.path)

    def remove(self) -> None:
        """Remove what is ours, and the folder if nothing else is in it; ends the lock."""
        with suppress(OSError):  # what cannot be removed stays
            self._remove_pieces()
            # under the lock: who waits at this file sees that it is no longer the one of the name
            os.unlink(self.path / _STAMP)
        self._close_stamp()
        with suppress(OSError):
            self.path.rmdir()

    def close(self) -> None:
        """End the lock; without pieces nothing is left of the folder."""
        if self._stamp.closed:
            return
        with suppress(OSError):  # someone else has removed the folder
            if self.pieces == 0:
                self.remove()
        self._close_stamp()

    def _close_stamp(self) -> None:
        with suppress(OSError):  # what a full disk did not take, whose error was told
            self._stamp.close()
