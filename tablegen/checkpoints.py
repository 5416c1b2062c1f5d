"""Run the tasks of a long run, and keep their results, so that an interrupted run can resume.

The result of a task depends on its arguments and the software alone. So a table depends neither on
the executor, nor on the order of the tasks, nor on interruptions. Finished results are kept as
``.npz`` files in the folder ``OUTPUT.parts`` until the output is complete. A stamp in the folder
identifies the configuration, the seed and the software of the run.
"""

import errno
import hashlib
import io
import os
import platform
import time
import zipfile
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import Executor, as_completed
from contextlib import closing, nullcontext, suppress
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

import sampler
from sampler.errors import InputError
from sampler.files import write_bytes
from sampler.library import processors
from tablegen.parallel import thread_pool
from tablegen.progress import bar

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

Arrays = dict[str, NDArray[Any]]

#: Name of the processor time [s] in the result of a task; a task runs in one thread.
SECONDS = "seconds"

_STAMP = "stamp.sha256"

#: File that the living run holds locked.
_LOCK = "running.lock"

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
    """Checkpoints of a run, in a folder beside its output.

    The store is a context manager. At its end, it removes the folder if there are no checkpoints.

    Parameters
    ----------
    output : Path
        File that the run will write.
    fingerprint : str
        All that decides the results: configuration, seed and software.
    resume : bool
        Use the checkpoints of an interrupted run.
    discard : bool
        Remove the checkpoints of an interrupted run.

    Attributes
    ----------
    folder : Path
    resumed : bool
        Whether there were checkpoints of an interrupted run to use.

    Raises
    ------
    InputError
        There are checkpoints, and neither ``resume`` nor ``discard`` is given, or they are those of
        another run; another run is writing the output; the folder has other files, or cannot be
        made.
    """

    def __init__(
        self, output: Path, fingerprint: str, *, resume: bool = False, discard: bool = False
    ) -> None:
        if resume and discard:
            problem = "is given with --resume"
            raise InputError("--discard", problem=problem, remedy="give one of the two")
        self.folder = parts_path(output)
        self._stamp = hashlib.sha256(fingerprint.encode()).hexdigest()
        self._output = output
        stamp = self.folder / _STAMP
        try:
            self.folder.mkdir(exist_ok=True)
            if not stamp.is_file() and {path.name for path in self.folder.iterdir()} - {_LOCK}:
                problem = f"{self.folder} exists, and is not the folder of an unfinished run"
                raise InputError("output", problem=problem, remedy="choose another output")
            self._lock = self._lock_output()
            try:
                self.resumed = self._begin(stamp, resume, discard)
            except BaseException:
                self._lock.close()
                raise
        except OSError as error:
            problem = f"cannot make {self.folder}: {error.strerror}"
            raise InputError("output", problem=problem) from error

    def _begin(self, stamp: Path, resume: bool, discard: bool) -> bool:
        """Return whether the run resumes; if not, remove old checkpoints and write the stamp."""
        old_stamp = stamp.read_text() if stamp.is_file() else ""
        if not discard and self._pieces():
            self._check_can_resume(old_stamp, resume)
            return True
        for path in self._pieces():
            path.unlink()
        stamp.write_text(self._stamp)
        return False

    def _check_can_resume(self, old_stamp: str, resume: bool) -> None:
        """Refuse checkpoints of another run, and checkpoints that the user did not ask to use."""
        same = old_stamp == self._stamp
        if not (same and resume):
            other = "" if same else ", made from another configuration or version"
            pieces = len(self._pieces())
            count = f"{pieces} piece{'s' * (pieces > 1)}"
            choice = "--resume to use them" if same else "another output"
            raise InputError(
                "output",
                problem=f"{self.folder} has {count} of an unfinished run{other}",
                remedy=f"give {choice}, or --discard to remove them",
            )

    def _lock_output(self) -> BinaryIO:
        """Claim the output for this run, as long as the returned file is open.

        The system frees the lock of a process that ends in any way. Where it knows no locks, the
        first of two runs to end writes the output, and the other is refused.
        """
        path = self.folder / _LOCK
        while True:
            self.folder.mkdir(exist_ok=True)
            file = path.open("ab")
            try:
                if fcntl is not None:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                # the run that held the lock may have removed the file since it was opened
                if path.exists() and os.path.samestat(os.fstat(file.fileno()), path.stat()):
                    return file
            except OSError as error:
                if error.errno not in (errno.EWOULDBLOCK, errno.EACCES):
                    return file  # no locks on this file system
                file.close()
                problem = f"another run is writing {self._output}"
                remedy = "wait for its end, stop it, or choose another output"
                raise InputError("output", problem=problem, remedy=remedy) from None
            file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pieces():
            with suppress(OSError):
                (self.folder / _LOCK).unlink(missing_ok=True)
        else:
            self.remove()
        self._lock.close()

    def _pieces(self) -> list[Path]:
        return list(self.folder.glob("piece-*.npz"))

    def path(self, key: str) -> Path:
        """Name the file of a checkpoint."""
        return self.folder / f"piece-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npz"

    def load(self, key: str) -> Arrays | None:
        """Read the arrays of a checkpoint; returns None if it is missing or damaged."""
        return _read_arrays(self.path(key))

    def seconds(self) -> float:
        """Sum up the processor seconds of all checkpoints."""
        pieces = (_read_arrays(path) for path in self._pieces())
        return sum(float(piece[SECONDS]) for piece in pieces if piece)

    def save(self, key: str, arrays: Mapping[str, Any]) -> None:
        """Write a checkpoint; raises `InputError` if that fails."""
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
            for name, array in arrays.items():
                with file.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)
        write_bytes(self.path(key), buffer.getvalue())

    def remove(self) -> None:
        """Remove all checkpoints and their folder."""
        with suppress(OSError):  # other files of the user may stay in it
            for path in self._pieces():
                path.unlink()
            (self.folder / _STAMP).unlink(missing_ok=True)
            (self.folder / _LOCK).unlink(missing_ok=True)
            self.folder.rmdir()


def _read_arrays(path: Path) -> Arrays | None:
    """Read the arrays of a file; returns None if it is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None


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
        raise InputError("workers", f"one with {own_software}", expected_software)
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
