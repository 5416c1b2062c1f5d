"""Run the tasks of a long run, and keep their results, so that an interrupted run can resume.

The result of a task depends on its arguments and the software alone. So a table depends neither on
the executor, nor on the order of the tasks, nor on interruptions. Finished results are pieces in
the folder ``OUTPUT.parts`` until the output is complete. The name of a piece is made of all that
decides its result: configuration, seed, software and the key of the task. A run reads pieces of its
own name only, so pieces of another configuration or version are never used.
"""

import hashlib
import io
import os
import platform
import time
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import Executor, as_completed
from contextlib import closing, nullcontext, suppress
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

import sampler
from sampler.errors import InputError
from sampler.files import write_bytes
from sampler.library import processors
from tablegen.parallel import thread_pool
from tablegen.progress import bar

Arrays = dict[str, NDArray[Any]]

#: Name of the processor time [s] in the result of a task; a task runs in one thread.
SECONDS = "seconds"

#: Endings of files that results depend on: Python, the draw in C, and numbers.
_SOURCES = (".py", ".c", ".h", ".npy")

#: Packages that take part in the arithmetic.
_LIBRARIES = ("llvmlite", "numba", "numpy", "scikit-learn", "scipy")


@cache
def software() -> str:
    """Describe the software that results depend on, in one line: sources and versions."""
    digest = hashlib.sha256()
    for package in (Path(sampler.__file__).parent, Path(__file__).parent):
        sources = (path for path in package.rglob("*") if path.suffix in _SOURCES)
        for path in sorted(sources):
            digest.update(f"{path.relative_to(package.parent)}\0".encode())
            digest.update(path.read_bytes())
    versions = [f"{name} {metadata.version(name)}" for name in _LIBRARIES]
    ours = f"rebound-tables {sampler.__version__} (sources {digest.hexdigest()[:12]})"
    return ", ".join([ours, *versions, *platform.libc_ver(), platform.machine()])


def parts_path(output: Path) -> Path:
    """Name the folder of the checkpoints of an output; links are followed to their target."""
    target = Path(os.path.realpath(output)) if output.is_symlink() else output
    return target.with_name(f"{target.name}.parts")


class CheckpointStore:
    """Finished pieces of a run, in a folder beside its output.

    A piece is the SHA-256 of its content, 32 bytes, and the content, as `numpy.savez` writes it.

    Parameters
    ----------
    output : Path
        File that the run will write.
    fingerprint : str
        All that decides the results beside the keys: configuration, seed and software.
    resume : bool
        Whether to read the pieces of an interrupted run; otherwise they are written again.

    Attributes
    ----------
    folder : Path
    """

    def __init__(self, output: Path, fingerprint: str, *, resume: bool = False) -> None:
        self.folder, self._resume = parts_path(output), resume
        self._name = f"piece-{hashlib.sha256(fingerprint.encode()).hexdigest()[:12]}"

    def pieces(self) -> list[Path]:
        """List the pieces of this configuration and software."""
        return list(self.folder.glob(f"{self._name}-*"))

    def path(self, key: str) -> Path:
        """Name the file of a piece."""
        return self.folder / f"{self._name}-{hashlib.sha256(key.encode()).hexdigest()[:16]}"

    def load(self, key: str) -> Arrays | None:
        """Read the arrays of a piece; returns None if it is missing, damaged, or not to be read."""
        return _read_arrays(self.path(key)) if self._resume else None

    def seconds(self) -> float:
        """Sum up the processor seconds of the pieces that this run uses."""
        pieces = map(_read_arrays, self.pieces() if self._resume else ())
        return sum(float(piece[SECONDS]) for piece in pieces if piece)

    def save(self, key: str, arrays: Mapping[str, Any]) -> None:
        """Write a piece; raises `InputError` if that fails."""
        buffer = io.BytesIO()
        np.savez(buffer, **arrays)
        content = buffer.getvalue()
        try:
            self.folder.mkdir(exist_ok=True)
        except OSError as error:
            problem = f"cannot make {self.folder}: {error.strerror}"
            raise InputError("output", problem=problem) from error
        write_bytes(self.path(key), hashlib.sha256(content).digest() + content)

    def remove(self) -> None:
        """Remove all pieces, those of other runs too, and their folder."""
        with suppress(OSError):  # other files of the user may stay in it
            for path in self.folder.glob("piece-*"):
                path.unlink()
            self.folder.rmdir()


def _read_arrays(path: Path) -> Arrays | None:
    """Read the arrays of a piece; returns None if it is missing or damaged."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    digest, content = data[:32], data[32:]
    if hashlib.sha256(content).digest() != digest:
        return None
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


class Task(NamedTuple):
    """Part of a run: ``function(*arguments)`` returns arrays by name."""

    function: Callable[..., Arrays]
    arguments: tuple[Any, ...]


def stable_number(key: str, bits: int) -> int:
    """Hash a text to an integer from 0 to 2**bits - 1, the same on every machine."""
    return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big") >> (64 - bits)


def run_task(task: Task, expected_software: str) -> Arrays:
    """Run a task on a worker, and add its processor time to the result.

    Raises `InputError` if the worker has other software than the run.
    """
    if (own_software := software()) != expected_software:
        problem = f"a worker runs {own_software}, and this process {expected_software}"
        raise InputError("workers", problem=problem, remedy="start all in one environment")
    begin = time.thread_time()
    return {**task.function(*task.arguments), SECONDS: np.array(time.thread_time() - begin)}


class TaskRunner:
    """Run tasks, and collect their results and times.

    Parameters
    ----------
    store : CheckpointStore, optional
        Keeps the results of this run, and has those of an interrupted one.
    executor : Executor, optional
        By default one thread for each processor.
    progress : bool
        Show a progress bar.

    Attributes
    ----------
    seconds : float
        Processor time [s] of all tasks so far, those of the interrupted run included.
    note : str
        Text after the progress bar.
    """

    def __init__(
        self,
        store: CheckpointStore | None = None,
        executor: Executor | None = None,
        progress: bool = False,
    ) -> None:
        self._store, self._executor, self._progress = store, executor, progress
        self.seconds = 0.0
        self.note = ""

    def run(
        self,
        title: str,
        tasks: Mapping[str, Task],
        on_result: Callable[[str, Arrays], None] = lambda key, arrays: None,
        stored: bool = True,
    ) -> dict[str, Arrays]:
        """Run all tasks that have no checkpoint.

        Parameters
        ----------
        title : str
            Text before the progress bar.
        tasks : mapping
            Tasks by key. A key identifies a task among all tasks of the same configuration.
        on_result : callable, optional
            Called with the key and the result of each task when it is done.
        stored : bool
            Whether results become checkpoints. Large results of short tasks need not: a run that
            resumes computes them again.

        Returns
        -------
        dict
            Results by key, in the order of the tasks.
        """
        results: dict[str, Arrays] = {}
        store = self._store if stored else None
        for key in tasks:
            if store and (arrays := store.load(key)) is not None:
                results[key] = arrays
                on_result(key, arrays)
        missing = {key: task for key, task in tasks.items() if key not in results}
        progress_bar = bar(
            self._progress and bool(missing),
            unit="piece",
            total=len(tasks),
            initial=len(results),
            desc=title,
            postfix=self.note,
        )
        with progress_bar, closing(self._finished(missing)) as finished:
            for key, arrays in finished:
                if store:
                    store.save(key, arrays)
                results[key] = arrays
                on_result(key, arrays)
                progress_bar.set_postfix_str(self.note, refresh=False)
                progress_bar.update()
        self.seconds += sum(float(arrays[SECONDS]) for arrays in results.values())
        return {key: results[key] for key in tasks}

    def _finished(self, tasks: Mapping[str, Task]) -> Generator[tuple[str, Arrays], None, None]:
        """Run tasks, and yield keys and results as they come in."""
        if not tasks:
            return
        context = nullcontext(self._executor) if self._executor else thread_pool(processors())
        # BLAS is limited once for all tasks: the limit is one number for the whole process
        with context as executor, threadpool_limits(limits=1, user_api="blas"):
            waiting = {executor.submit(run_task, t, software()): key for key, t in tasks.items()}
            try:
                for future in as_completed(waiting):
                    yield waiting.pop(future), future.result()
            finally:
                for future in waiting:
                    future.cancel()
