"""Finished pieces of a long run, kept on disk so that it can be resumed.

A piece is a named tuple of arrays with a number. Pieces of a run lie in a folder beside its
output, with a fingerprint of what they were made from; they are removed when the output is
complete.
"""

import hashlib
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.atomic import atomic_output
from sampler.errors import InputError

Arrays = dict[str, NDArray[Any]]

#: ``numpy.savez`` for names known at run time only. Its stubs see them as ``allow_pickle``, which
#: cannot be passed beside them either: before 2.2 it would be stored as an array.
_savez: Callable[..., None] = np.savez

#: What numpy and zipfile raise on files that are empty, cut short or altered.
_DAMAGE = (
    EOFError,
    KeyError,
    NotImplementedError,
    OSError,
    RuntimeError,
    ValueError,
    zipfile.BadZipFile,
)


class PieceStore:
    """Folder ``OUTPUT.parts`` with the finished pieces of a run.

    Parameters
    ----------
    output : Path
        The file that the run will write.
    recipe : str
        Everything that decides what a piece holds; pieces of another recipe are not used.
    resume : bool
        Keep the pieces of an interrupted run with the same recipe; else start afresh.

    Raises
    ------
    InputError
        If pieces shall be used that come from another recipe, or the folder cannot be made.
    """

    def __init__(self, output: Path, recipe: str, resume: bool) -> None:
        self.folder = output.with_name(output.name + ".parts")
        self._stamp = self.folder / "recipe.sha256"
        fingerprint = hashlib.sha256(recipe.encode()).hexdigest()
        if self.folder.is_dir() and resume:
            found = self._stamp.read_text() if self._stamp.is_file() else "nothing"
            if found != fingerprint:
                raise InputError(
                    f"resume: got {self.folder}, made from another configuration or version, "
                    "allowed: parts of this one (leave out --resume to start afresh)"
                )
            return
        self.discard()
        try:
            self.folder.mkdir()
            self._stamp.write_text(fingerprint)
        except OSError as error:
            raise InputError(f"output: cannot make {self.folder}: {error.strerror}") from error

    def _path(self, number: int) -> Path:
        return self.folder / f"piece-{number:05d}.npz"

    def load(self, number: int) -> Arrays | None:
        """Arrays of a finished piece, or None if it is missing or damaged."""
        try:
            with np.load(self._path(number), allow_pickle=False) as file:
                # an array whose header asks for too little leaves its checksum unread
                if file.zip.testzip() is not None:
                    return None
                return {name: file[name] for name in file.files}
        except _DAMAGE:
            return None

    def save(self, number: int, arrays: Arrays) -> None:
        """Keep a finished piece."""
        with atomic_output(self._path(number)) as temporary, open(temporary, "wb") as file:
            _savez(file, **arrays)

    def discard(self) -> None:
        """Remove the folder with everything in it."""
        shutil.rmtree(self.folder, ignore_errors=True)
