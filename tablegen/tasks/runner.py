"""Run tasks with keys: on any executor, in any order, with checkpoints on disk.

The result of a task is a function of its arguments and the software alone, but for last digits,
which depend on the kind of processor. So a table does not depend on when and where its tasks were
done, and it names the kinds of processor that took part. The time of each task is counted, and
shown while the run goes on.
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
from tablegen.tasks.checkpoint import CheckpointStore
from tablegen.tasks.executors import thread_pool
from tablegen.tasks.processor_kind import processor_kind
from tablegen.tasks.progress import bar
from tablegen.tasks.software import software

Arrays = dict[str, NDArray[Any]]

#: What time is spent on, in the order of the array `SECONDS` of a result.
STAGES = ("simulation", "fit", "check")

#: Name of the array with the seconds of each stage in the result of a task.
SECONDS = "seconds"

#: Name of the array with the kind of processor in the result of a task.
PROCESSOR = "processor"


class Task(NamedTuple):
    """A part of a run: ``function(*arguments)`` returns named arrays, `SECONDS` among them."""

    function: Callable[..., Arrays]
    arguments: tuple[Any, ...]


def stable_number(key: str, bits: int) -> int:
    """Hash a text to an integer from 0 to 2**bits - 1, the same on every machine."""
    return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big") >> (64 - bits)


def run_task(task: Task, wanted_software: str) -> Arrays:
    """Run a task on the machine of a worker.

    Parameters
    ----------
    task : Task
    wanted_software : str
        What `software` says where the results are collected.

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
    return {**task.function(*task.arguments), PROCESSOR: np.array(processor_kind())}


class TaskRunner:
    """Runs tasks, and collects their results, times and kinds of processor.

    Parameters
    ----------
    store : CheckpointStore, optional
        Where checkpoints are written and found.
    executor : concurrent.futures.Executor, optional
        By default one thread a processor. It stays open.
    progress : bool
        Show progress bars on standard error.

    Attributes
    ----------
    seconds : dict
        Worker seconds of all tasks so far, by stage.
    processors : set of str
        Kinds of processor on which the tasks so far were done, those of checkpoints included.
    note : str
        Text after the progress bar; the generator puts the present worst error here.
    """

    def __init__(
        self,
        store: CheckpointStore | None = None,
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
        tasks: Mapping[str, Task],
        on_result: Callable[[str, Arrays], None] = lambda key, arrays: None,
    ) -> dict[str, Arrays]:
        """Run all tasks without a checkpoint.

        Parameters
        ----------
        what : str
            For the progress bar.
        tasks : mapping from key to Task
            The key says everything that decides the result, but for the configuration.
        on_result : callable, optional
            Is called with key and result of each task when it is done, to update the note.

        Returns
        -------
        dict from key to Arrays, in the order of the tasks
        """
        done: dict[str, Arrays] = {}
        for key in tasks:
            if self._store and (found := self._store.load(key)) is not None:
                done[key] = found
                on_result(key, found)
        counted = bar(
            self._progress and len(done) < len(tasks),
            unit="piece",
            total=len(tasks),
            initial=len(done),
            desc=what,
            postfix=self.note,
        )
        # closed at once if a checkpoint cannot be written: the traceback would keep it open
        with counted, closing(self._finished(tasks, done)) as finished:
            for key, arrays in finished:
                if self._store:
                    self._store.save(key, arrays)
                done[key] = arrays
                on_result(key, arrays)
                counted.set_postfix_str(self.note, refresh=False)
                counted.update()
        for arrays in done.values():
            for stage, spent in zip(STAGES, arrays[SECONDS], strict=True):
                self.seconds[stage] += float(spent)
            self.processors.add(str(arrays[PROCESSOR]))
        return {key: done[key] for key in tasks}

    def _finished(
        self, tasks: Mapping[str, Task], done: Mapping[str, Arrays]
    ) -> Generator[tuple[str, Arrays], None, None]:
        """Keys and results of the tasks that are not done, in the order of completion."""
        missing = {key: task for key, task in tasks.items() if key not in done}
        if not missing:
            return
        # A task itself limits linear algebra to one thread. But the limit is that of the process:
        # of two tasks that overlap, the first to end would lift it for the other.
        with (
            threadpool_limits(limits=1, user_api="blas"),
            nullcontext(self._executor) if self._executor else thread_pool() as pool,
        ):
            waiting = {pool.submit(run_task, t, software()): key for key, t in missing.items()}
            try:
                for future in as_completed(waiting):
                    yield waiting.pop(future), future.result()
            finally:
                for future in waiting:
                    future.cancel()


class Stopwatch:
    """Seconds that one task takes, by stage."""

    def __init__(self) -> None:
        self._seconds = dict.fromkeys(STAGES, 0.0)
        self._last = time.perf_counter()

    def stage(self, name: str) -> None:
        """Count the time since the last call for a stage."""
        now = time.perf_counter()
        self._seconds[name] += now - self._last
        self._last = now

    @property
    def seconds(self) -> NDArray[np.float64]:
        """Seconds of every stage, in the order of `STAGES`."""
        return np.array([self._seconds[name] for name in STAGES])
