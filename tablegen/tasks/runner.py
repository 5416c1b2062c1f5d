"""Run keyed pieces of work: on any executor, in any order, kept on disk as they finish.

A piece is a function of its arguments and the software alone, but for last digits, which depend on
the kind of processor: so a table does not depend on who computed its pieces, or when, and where
processors of several kinds took part, it says so. What a piece costs is counted, and shown while
the work goes on.
"""

import hashlib
import time
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import Executor, as_completed
from contextlib import closing, nullcontext
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from sampler.errors import InputError
from tablegen.tasks.checkpoint import PieceStore
from tablegen.tasks.executors import thread_pool
from tablegen.tasks.processor_kind import processor_kind
from tablegen.tasks.progress import bar
from tablegen.tasks.software import software

Arrays = dict[str, NDArray[Any]]

#: What time is spent on, in the order of the array `SECONDS` of a piece.
STAGES = ("simulation", "fit", "check")

#: Name under which a piece keeps its seconds by stage, beside its results.
SECONDS = "seconds"

#: Name under which a piece keeps the kind of processor that made it.
PROCESSOR = "processor"


class Piece(NamedTuple):
    """A piece of work: ``function(*arguments)`` returns named arrays, `SECONDS` among them."""

    function: Callable[..., Arrays]
    arguments: tuple[Any, ...]


def stable_number(key: str, bits: int) -> int:
    """Give the number of a text, the same on every machine; from 0 to 2**bits - 1."""
    return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big") >> (64 - bits)


def perform(piece: Piece, wanted_software: str) -> Arrays:
    """Do a piece of work, on whatever machine this runs.

    Parameters
    ----------
    piece : Piece
    wanted_software : str
        What `software` says where the pieces are put together.

    Returns
    -------
    Arrays
        With the kind of processor here as `PROCESSOR`.

    Raises
    ------
    InputError
        If the software here is different, so that the result could be.
    """
    if (ours := software()) != wanted_software:
        raise InputError(f"workers: got one with {ours}, allowed: {wanted_software}")
    return {**piece.function(*piece.arguments), PROCESSOR: np.array(processor_kind())}


class Workshop:
    """Where the pieces of a table are made.

    Parameters
    ----------
    store : PieceStore, optional
        Where finished pieces are kept, and found again.
    executor : concurrent.futures.Executor, optional
        By default one thread a processor. It stays open.
    progress : bool
        Show progress bars on standard error.

    Attributes
    ----------
    seconds : dict
        Worker seconds of all pieces so far, by stage.
    processors : set of str
        Kinds of processor that made the pieces so far, those found again among them.
    note : str
        Shown beside the bar; the generator puts the present worst error here.
    """

    def __init__(
        self,
        store: PieceStore | None = None,
        executor: Executor | None = None,
        progress: bool = False,
    ) -> None:
        self._store, self._executor, self._progress = store, executor, progress
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self.processors: set[str] = set()
        self.note = ""

    def run(
        self,
        what: str,
        pieces: Mapping[str, Piece],
        see: Callable[[str, Arrays], None] | None = None,
    ) -> dict[str, Arrays]:
        """Do all pieces that are not done yet.

        Parameters
        ----------
        what : str
            For the progress bar.
        pieces : mapping from key to Piece
            The key says everything that decides the result, but for the configuration.
        see : callable, optional
            Gets the key and the result of every piece as soon as it is there, to update the note.

        Returns
        -------
        dict from key to Arrays, in the order of the pieces
        """
        done: dict[str, Arrays] = {}
        for key in pieces:
            found = self._store.load(key) if self._store else None
            if found is not None:
                done[key] = found
                if see:
                    see(key, found)
        counted = bar(
            self._progress and len(done) < len(pieces),
            unit="piece",
            total=len(pieces),
            initial=len(done),
            desc=what,
            postfix=self.note,
        )
        # closed at once where a piece cannot be kept: the traceback would hold it open
        with counted, closing(self._finished(pieces, done)) as finished:
            for key, arrays in finished:
                if self._store:
                    self._store.save(key, arrays)
                done[key] = arrays
                if see:
                    see(key, arrays)
                counted.set_postfix_str(self.note, refresh=False)
                counted.update()
        for arrays in done.values():
            for stage, spent in zip(STAGES, arrays[SECONDS], strict=True):
                self.seconds[stage] += float(spent)
            self.processors.add(str(arrays[PROCESSOR]))
        return {key: done[key] for key in pieces}

    def _finished(
        self, pieces: Mapping[str, Piece], done: Mapping[str, Arrays]
    ) -> Generator[tuple[str, Arrays], None, None]:
        """Do what is not done yet; keys and results in the order of completion."""
        missing = {key: piece for key, piece in pieces.items() if key not in done}
        if not missing:
            return
        # A piece limits linear algebra to one thread itself. But that holds for the whole process,
        # and of two pieces that overlap, the first to end would lift it for the other.
        with (
            threadpool_limits(limits=1, user_api="blas"),
            nullcontext(self._executor) if self._executor else thread_pool() as pool,
        ):
            waiting = {pool.submit(perform, p, software()): key for key, p in missing.items()}
            try:
                for future in as_completed(waiting):
                    yield waiting.pop(future), future.result()
            finally:
                for future in waiting:
                    future.cancel()


class Stopwatch:
    """Seconds that one piece takes, by stage."""

    def __init__(self) -> None:
        self._seconds = dict.fromkeys(STAGES, 0.0)
        self._last = time.perf_counter()

    def stage(self, name: str) -> None:
        """Count what has passed since the last call for a stage."""
        now = time.perf_counter()
        self._seconds[name] += now - self._last
        self._last = now

    @property
    def seconds(self) -> NDArray[np.float64]:
        """Seconds of every stage, in the order of `STAGES`."""
        return np.array([self._seconds[name] for name in STAGES])
