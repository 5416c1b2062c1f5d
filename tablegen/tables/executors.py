"""Open executors of `concurrent.futures`: threads, a Dask cluster, or the ranks of an MPI job."""

import logging
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager
from typing import cast

from sampler.errors import InputError
from sampler.library import processors
from tablegen.parallel import thread_pool

THREADS, DASK, MPI = ENGINES = ("threads", "dask", "mpi")

#: Seconds after which a Dask scheduler counts as out of reach.
_TIMEOUT = 8


@contextmanager
def open_executor(
    engine: str = THREADS, *, workers: int | None = None, scheduler: str | None = None
) -> Iterator[Executor | None]:
    """Open an executor, and close it at the end of the block.

    Parameters
    ----------
    engine : {"threads", "dask", "mpi"}
    workers : int, optional
        Number of threads, or of processes of a Dask cluster on this machine; by default one for
        each processor.
    scheduler : str, optional
        Address of a running Dask scheduler.

    Yields
    ------
    Executor or None
        None on all ranks of an MPI job but the first one; these ranks work until the first rank has
        finished.

    Raises
    ------
    InputError
        Arguments contradict each other, a package is missing, or workers cannot be reached.
    """
    if scheduler is not None and engine != DASK:
        problem = f"is given with --executor {engine}"
        raise InputError("--scheduler", problem=problem, remedy="give --executor dask")
    if workers is not None and (engine == MPI or scheduler is not None):
        problem = "is given with mpi or with --scheduler, which have their own workers"
        raise InputError("--workers", problem=problem, remedy="leave it out")
    if engine == THREADS:
        with thread_pool(workers or processors()) as pool:
            yield pool
    elif engine == DASK:
        with _dask(workers or processors(), scheduler) as executor:
            yield executor
    elif engine == MPI:
        with _mpi() as ranks:
            yield ranks
    else:
        raise InputError("--executor", engine, ", ".join(ENGINES))


@contextmanager
def _dask(workers: int, scheduler: str | None) -> Iterator[Executor]:
    """Open an executor on a running Dask cluster, or on processes of this machine."""
    try:
        from distributed import Client, KilledWorker
    except ImportError as error:
        remedy = "run: pip install 'rebound-tables[dask]'"
        raise InputError("--executor", problem="Dask is not installed", remedy=remedy) from error
    try:
        if scheduler:
            client = Client(scheduler, timeout=_TIMEOUT)
        else:
            client = Client(
                n_workers=workers,
                threads_per_worker=1,
                dashboard_address=":0",
                silence_logs=logging.CRITICAL,
            )
    except (OSError, ValueError) as error:
        problem = f"no Dask scheduler answered at {scheduler} within {_TIMEOUT} s"
        raise InputError("--scheduler", problem=problem) from error
    with client:
        try:
            yield client.get_executor()
        except (KilledWorker, CancelledError) as error:
            problem = f"the Dask workers were lost: {error}"
            raise InputError("--executor", problem=problem) from error


@contextmanager
def _mpi() -> Iterator[Executor | None]:
    """Open an executor on the first rank of an MPI job; the other ranks work until it closes."""
    try:
        from mpi4py.futures import MPICommExecutor
        from mpi4py.MPI import COMM_WORLD
    except (ImportError, RuntimeError) as error:  # RuntimeError: mpi4py finds no MPI library
        remedy = "install Open MPI or MPICH, and run: pip install 'rebound-tables[mpi]'"
        raise InputError("--executor", problem="MPI is not installed", remedy=remedy) from error
    if COMM_WORLD.Get_size() < 2:
        problem, remedy = "mpi runs on one rank only", "start the command with mpiexec -n 2 or more"
        raise InputError("--executor", problem=problem, remedy=remedy)
    with MPICommExecutor(COMM_WORLD, root=0) as ranks:
        yield cast("Executor | None", ranks)
