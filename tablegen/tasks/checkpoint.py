"""Checkpoints: results of finished tasks on disk, from which an interrupted run is resumed.

A checkpoint is a set of named arrays with a key. Those of a run are in a folder next to its output,
with the fingerprint of what they were made from; it is removed when the output is complete.

A checkpoint is a ``.npz`` archive followed by 32 bytes: the SHA-256 digest of the fingerprint, the
key and the archive. So one that was cut short or altered, or that belongs to another key or another
run, is recognised, and its task done again.
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

#: ``numpy.savez`` for names known at run time only, which its stubs take for ``allow_pickle``. That
#: argument cannot be passed as well: before numpy 2.2 it would be stored as an array.
_savez: Callable[..., None] = np.savez

#: Bytes of a SHA-256 digest.
_DIGEST_SIZE = 32


class CheckpointStore:
    """Folder ``OUTPUT.parts`` with the checkpoints of a run.

    Parameters
    ----------
    output : Path
        The file that the run will write.
    fingerprint : str
        Everything that decides the result of a task, but for its key; checkpoints with another
        fingerprint are not used.
    resume : bool
        Keep the checkpoints of an interrupted run with the same fingerprint; else start again.

    Raises
    ------
    InputError
        If the checkpoints to resume from have another fingerprint, or the folder cannot be made
        or written to.
    """

    def __init__(self, output: Path, fingerprint: str, resume: bool) -> None:
        self.folder = output.with_name(output.name + ".parts")
        self._fingerprint = hashlib.sha256(fingerprint.encode()).hexdigest()
        if resume and self.folder.is_dir() and any(self.folder.iterdir()):
            self._check_fingerprint()
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

    def _check_fingerprint(self) -> None:
        found = self._stamp.read_text() if self._stamp.is_file() else "nothing"
        if found != self._fingerprint:
            raise InputError(
                f"resume: got {self.folder}, made from another configuration or version, "
                "allowed: parts of this one (leave out --resume to start afresh)"
            )
        if not os.access(self.folder, os.W_OK):
            raise InputError(f"resume: got {self.folder}, allowed: a folder that can be written")

    def path(self, key: str) -> Path:
        """File of a checkpoint, whether it is there or not."""
        return self.folder / f"piece-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npz"

    def _digest(self, key: str, archive: bytes) -> bytes:
        owner = hashlib.sha256(key.encode()).digest()
        return hashlib.sha256(self._fingerprint.encode() + owner + archive).digest()

    def load(self, key: str) -> Arrays | None:
        """Arrays of a checkpoint, or None if it is missing, damaged or not ours."""
        try:
            whole = self.path(key).read_bytes()
        except OSError:
            return None
        archive, digest = whole[:-_DIGEST_SIZE], whole[-_DIGEST_SIZE:]
        if digest != self._digest(key, archive):
            return None
        with np.load(io.BytesIO(archive), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}

    def save(self, key: str, arrays: Arrays) -> None:
        """Write a checkpoint.

        Raises
        ------
        InputError
            If it cannot be written; the others stay as they are.
        """
        buffer = io.BytesIO()
        _savez(buffer, **arrays)
        archive = buffer.getvalue()
        try:
            with atomic_output(self.path(key)) as temporary:
                temporary.write_bytes(archive + self._digest(key, archive))
        except InputError as error:
            raise InputError(f"{error}; earlier pieces are kept for --resume") from error

    def discard(self) -> None:
        """Remove the folder with everything in it."""
        shutil.rmtree(self.folder, ignore_errors=True)
