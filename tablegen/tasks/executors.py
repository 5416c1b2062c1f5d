"""Executors of `concurrent.futures` for tasks: threads, a Dask cluster, the ranks of an MPI job."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import AbstractContextManager, contextmanager, nullcontext

from sampler.library import processors

from tablegen.tasks.side_by_side import ThreadPool

from sampler.errors import InputError
from sampler.library import processors
from tablegen.tasks.dask_workers import dask_workers

THREADS, DASK, MPI = ENGINES = ("threads", "dask", "mpi")


@contextmanager
def open_executor(
    engine: str = THREADS,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    ranks: Executor | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Iterator[Executor]:
    """Open an executor by name, and close it at the end of the block.

    Parameters
    ----------
    engine : {"threads", "dask", "mpi"}
    workers : int, optional
        Threads, or processes of a Dask cluster on this machine; by default one a processor.
    scheduler : str, optional
        Address of a running Dask scheduler, whose workers are used.
    ranks : Executor, optional
        The other ranks of an MPI job, from `tablegen.tasks.mpi_ranks.on_first_rank`.
    say : callable
        Is called with a line of text for the user, for example if there are no workers yet.

    Yields
    ------
    Executor

    Raises
    ------
    InputError
        If the arguments do not go together, a package is missing, a scheduler is out of reach, or
        the workers are lost.
    """
    if scheduler is not None and engine != DASK:
        raise InputError(f"--scheduler: got {scheduler} with {engine}, allowed: with dask only")
    if workers is not None and engine == MPI:
        raise InputError(f"--workers: got {workers} with mpi, allowed: none, mpiexec has its own")
    if workers is not None and scheduler is not None:
        raise InputError(f"--workers: got {workers} with --scheduler, allowed: one of the two")
    if engine == MPI and ranks is None:
        raise InputError("--executor: got mpi outside MPI, allowed: under mpiexec -n N")
    opened: AbstractContextManager[Executor]
    if engine == DASK:
        opened = dask_workers(scheduler, workers or processors(), say)
    elif engine == MPI and ranks is not None:
        opened = nullcontext(ranks)
    elif engine == THREADS:
        opened = thread_pool(workers)
    else:
        raise InputError(f"--executor: got {engine}, allowed: {', '.join(ENGINES)}")
    with opened as executor:
        yield executor


def thread_pool(workers: int | None = None) -> ThreadPool:
    """Threads of this process, by default one a processor."""
    return ThreadPool(workers or processors())
