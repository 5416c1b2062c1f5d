"""Run keyed pieces of work: on any executor, in any order, kept on disk as they finish.

A piece is a function of its arguments alone, so a table does not depend on who computed its
pieces, or when. What a piece costs is counted, and shown while the work goes on.
"""

import hashlib
import os
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor, as_completed
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from tablegen.pieces import PieceStore

Arrays = dict[str, NDArray[Any]]

#: What time is spent on, in the order of the array `SECONDS` of a piece.
STAGES = ("simulation", "fit", "check")

#: Name under which a piece keeps its seconds by stage, beside its results.
SECONDS = "seconds"


class Piece(NamedTuple):
    """A piece of work: ``function(*arguments)`` returns named arrays, `SECONDS` among them."""

    function: Callable[..., Arrays]
    arguments: tuple[Any, ...]


def stable_number(key: str, bits: int) -> int:
    """Give the number of a text, the same on every machine; from 0 to 2**bits - 1."""
    return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big") >> (64 - bits)


class Workshop:
    """Where the pieces of a table are made.

    Parameters
    ----------
    store : PieceStore, optional
        Where finished pieces are kept, and found again.
    executor : concurrent.futures.Executor, optional
        By default one thread a processor.
    progress : bool
        Show progress bars on standard error.

    Attributes
    ----------
    seconds : dict
        Worker seconds of all pieces so far, by stage.
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
        self.note = ""

    def run(self, what: str, pieces: Mapping[str, Piece]) -> dict[str, Arrays]:
        """Do all pieces that are not done yet.

        Parameters
        ----------
        what : str
            For the progress bar.
        pieces : mapping from key to Piece
            The key says everything that decides the result, but for the configuration.

        Returns
        -------
        dict from key to Arrays, in the order of the pieces
        """
        done: dict[str, Arrays] = {}
        for key in pieces:
            found = self._store.load(stable_number(key, 48)) if self._store else None
            if found is not None and SECONDS in found:
                done[key] = found
        bar = tqdm(
            total=len(pieces),
            initial=len(done),
            desc=what,
            postfix=self.note,
            disable=not self._progress or len(done) == len(pieces),
        )
        with bar:
            self._finish(pieces, done, bar)
        for arrays in done.values():
            for stage, spent in zip(STAGES, arrays[SECONDS], strict=True):
                self.seconds[stage] += float(spent)
        return {key: done[key] for key in pieces}

    def _finish(self, pieces: Mapping[str, Piece], done: dict[str, Arrays], bar: tqdm) -> None:
        pool = self._executor or ThreadPoolExecutor(os.cpu_count())
        waiting = {
            pool.submit(piece.function, *piece.arguments): key
            for key, piece in pieces.items()
            if key not in done
        }
        try:
            for future in as_completed(waiting):
                key = waiting[future]
                done[key] = future.result()
                if self._store:
                    self._store.save(stable_number(key, 48), done[key])
                bar.update()
        finally:
            for future in waiting:
                future.cancel()
            if self._executor is None:
                pool.shutdown()


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
