"""The ranks of an MPI job: the first runs the command, the others are its workers.

Only the first rank reads its arguments, prints and writes, so that every message appears once.
"""

import signal
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from itertools import pairwise
from typing import cast

from sampler.errors import InputError


def asks_for_ranks(words: Sequence[str]) -> bool:
    """Whether the words of a command line select MPI."""
    return "--executor=mpi" in words or ("--executor", "mpi") in pairwise(words)


def on_first_rank(command: Callable[[Executor], int]) -> int:
    """Run a command on the first rank, with an executor that stands for all others.

    Parameters
    ----------
    command : callable
        Gets the executor, returns an exit status.

    Returns
    -------
    int
        That exit status; 0 on the other ranks, when the command has ended.

    Raises
    ------
    InputError
        If MPI is not installed, or this is the only rank.
    """
    try:
        from mpi4py import MPI
        from mpi4py.futures import MPICommExecutor
    except (ImportError, RuntimeError) as error:
        # a RuntimeError where mpi4py finds no library
        raise InputError(
            "--executor: got mpi, which is not installed, allowed after: "
            "pip install 'rebound-tables[mpi]', with Open MPI or MPICH from the system"
        ) from error
    world = MPI.COMM_WORLD
    if world.Get_size() < 2:
        raise InputError(
            "--executor: got mpi on one rank, allowed: two or more, "
            "with mpiexec -n N in front and the same MPI library as mpi4py's"
        )
    if world.Get_rank() > 0:
        # an interruption concerns the first rank, which ends the others; it also says so
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with MPICommExecutor(world, root=0) as opened:
        executor = cast(Executor | None, opened)
        return 0 if executor is None else command(executor)
