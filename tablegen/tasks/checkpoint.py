"""Checkpoints: results of finished tasks on disk, from which an interrupted run is resumed.

A checkpoint is a set of named arrays with a key. Those of a run are the pieces in its
`tablegen.tasks.parts_folder`, with the fingerprint of what they were made from; they are removed
when the output is complete.

A checkpoint is a ``.npz`` archive followed by 32 bytes: the SHA-256 digest of the fingerprint, the
key and the archive. So one that was cut short or altered, or that belongs to another key or another
run, is recognised, and its task done again.
"""

import hashlib
import io
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from sampler.files import write_bytes
from tablegen.tasks.parts_folder import PartsFolder

Arrays = dict[str, NDArray[Any]]

#: ``numpy.savez`` for names known at run time only, which its stubs take for ``allow_pickle``. That
#: argument cannot be passed as well: before numpy 2.2 it would be stored as an array.
_savez: Callable[..., None] = np.savez

#: Bytes of a SHA-256 digest.
_DIGEST_SIZE = 32


class CheckpointStore:
    """Checkpoints of a run, in a folder that is its own until the store is closed.

    Parameters
    ----------
    output : Path
        The file that the run will write.
    fingerprint : str
        Everything that decides the result of a task, but for its key; checkpoints with another
        fingerprint are not used.
    resume : bool
        Use the checkpoints of an interrupted run with the same fingerprint, if there are any.
    discard : bool
        Remove the checkpoints of an interrupted run, if there are any.

    Raises
    ------
    InputError
        If another run is making the output; if there are checkpoints, and neither `resume` nor
        `discard` says what becomes of them, or those to resume from have another fingerprint; or
        if the folder cannot be used.

    Attributes
    ----------
    resumed : bool
        Whether there are checkpoints already.
    """

    def __init__(
        self, output: Path, fingerprint: str, *, resume: bool = False, discard: bool = False
    ) -> None:
        if resume and discard:
            raise InputError("--discard: got it with --resume, allowed: one of the two")
        self._fingerprint = hashlib.sha256(fingerprint.encode()).hexdigest()
        self._parts = PartsFolder(output)
        try:
            self.resumed = not discard and self._parts.pieces > 0
            if self.resumed:
                self._check_can_go_on(resume)
            else:
                self._parts.begin(self._fingerprint)
        except BaseException:
            self.close()
            raise

    def _check_can_go_on(self, resume: bool) -> None:
        pieces, same = self._parts.pieces, self._parts.fingerprint == self._fingerprint
        if same and resume:
            return
        made_from = "" if same else ", made from another configuration or version"
        going_on = "--resume, which uses them" if same else "another output"
        raise InputError(
            f"output: got {self.folder} with {pieces} piece{'s' * (pieces > 1)} of an unfinished "
            f"run{made_from}, "
            f"allowed: {going_on}, or --discard, which removes them"
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def folder(self) -> Path:
        """Where the checkpoints are."""
        return self._parts.path

    @property
    def rehearsal(self) -> Path:
        """A file in the folder for a table that is tried and removed."""
        return self._parts.rehearsal

    def path(self, key: str) -> Path:
        """File of a checkpoint, whether it is there or not."""
        return self._parts.file(hashlib.sha256(key.encode()).hexdigest()[:16])

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
            write_bytes(self.path(key), archive + self._digest(key, archive))
        except InputError as error:
            raise InputError(f"{error}; earlier pieces are kept for --resume") from error

    def remove(self) -> None:
        """Remove all checkpoints, which ends the run."""
        self._parts.remove()

    def close(self) -> None:
        """Leave the checkpoints for a later run."""
        self._parts.close()
