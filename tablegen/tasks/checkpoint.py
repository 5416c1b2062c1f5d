"""Finished pieces of a long run, kept on disk so that it can be resumed.

A piece is a set of named arrays with a key. Pieces of a run lie in a folder beside its output,
with a fingerprint of what they were made from; they are removed when the output is complete.

A piece is a ``.npz`` archive with 32 bytes behind it: the SHA-256 digest of the fingerprint, the
key and the archive. So a piece that was cut short or altered, or that belongs to another key or
another run, is told from a good one, and made again.
"""

import hashlib
import io
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from sampler.files.atomic import atomic_output

Arrays = dict[str, NDArray[Any]]

#: ``numpy.savez`` for names known at run time only. Its stubs see them as ``allow_pickle``, which
#: cannot be passed beside them either: before 2.2 it would be stored as an array.
_savez: Callable[..., None] = np.savez

#: Bytes of a SHA-256 digest.
_SEAL = 32


class PieceStore:
    """Folder ``OUTPUT.parts`` with the finished pieces of a run.

    Parameters
    ----------
    output : Path
        The file that the run will write.
    recipe : str
        Everything that decides what a piece holds, but for its key; pieces of another recipe are
        not used.
    resume : bool
        Keep the pieces of an interrupted run with the same recipe; else start afresh.

    Raises
    ------
    InputError
        If pieces shall be used that come from another recipe, or the folder cannot be made or
        written to.
    """

    def __init__(self, output: Path, recipe: str, resume: bool) -> None:
        self.folder = output.with_name(output.name + ".parts")
        self._fingerprint = hashlib.sha256(recipe.encode()).hexdigest()
        if resume and self.folder.is_dir() and any(self.folder.iterdir()):
            self._check_recipe()
            return
        self.discard()
        try:
            self.folder.mkdir()
            with atomic_output(self._stamp) as temporary:
                temporary.write_text(self._fingerprint)
        except OSError as error:
            raise InputError(f"output: cannot make {self.folder}: {error.strerror}") from error

    @property
    def _stamp(self) -> Path:
        return self.folder / "recipe.sha256"

    def _check_recipe(self) -> None:
        found = self._stamp.read_text() if self._stamp.is_file() else "nothing"
        if found != self._fingerprint:
            raise InputError(
                f"resume: got {self.folder}, made from another configuration or version, "
                "allowed: parts of this one (leave out --resume to start afresh)"
            )
        if not os.access(self.folder, os.W_OK):
            raise InputError(f"resume: got {self.folder}, allowed: a folder that can be written")

    def path(self, key: str) -> Path:
        """File of a piece, whether it is there or not."""
        return self.folder / f"piece-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npz"

    def _seal(self, key: str, archive: bytes) -> bytes:
        owner = hashlib.sha256(key.encode()).digest()
        return hashlib.sha256(self._fingerprint.encode() + owner + archive).digest()

    def load(self, key: str) -> Arrays | None:
        """Arrays of a finished piece, or None if it is missing, damaged or not ours."""
        try:
            whole = self.path(key).read_bytes()
        except OSError:
            return None
        archive, seal = whole[:-_SEAL], whole[-_SEAL:]
        if seal != self._seal(key, archive):
            return None
        with np.load(io.BytesIO(archive), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}

    def save(self, key: str, arrays: Arrays) -> None:
        """Keep a finished piece.

        Raises
        ------
        InputError
            If it cannot be written; the pieces that are there stay as they are.
        """
        buffer = io.BytesIO()
        _savez(buffer, **arrays)
        archive = buffer.getvalue()
        try:
            with atomic_output(self.path(key)) as temporary:
                temporary.write_bytes(archive + self._seal(key, archive))
        except InputError as error:
            raise InputError(f"{error}; earlier pieces are kept for --resume") from error

    def discard(self) -> None:
        """Remove the folder with everything in it."""
        shutil.rmtree(self.folder, ignore_errors=True)
