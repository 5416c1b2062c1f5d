"""Executors of `concurrent.futures` by name: threads, a Dask cluster, the ranks of an MPI job."""

import logging
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager
from typing import Any, cast

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
    """Open an executor of threads, Dask or MPI, and close it at the end of the block.

    Workers are threads, or processes of a Dask cluster on this machine, by default one per
    processor; ``scheduler`` is the address of a running Dask scheduler. Yields None on all ranks of
    an MPI job but the first, when the first has finished.
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
    local_cluster: Any = {"n_workers": workers, "threads_per_worker": 1, "dashboard_address": ":0"}
    local_cluster["silence_logs"] = logging.CRITICAL
    try:
        client = Client(scheduler, timeout=_TIMEOUT) if scheduler else Client(**local_cluster)
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
