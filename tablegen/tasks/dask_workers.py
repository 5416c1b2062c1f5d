"""Workers of a Dask cluster as an executor: a running one, or processes on this machine."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import ExitStack, contextmanager
from typing import Any

from sampler.errors import InputError
from tablegen.tasks.dask_scheduler import check_scheduler

#: Seconds after which a scheduler counts as out of reach: with the time to start, less than 15.
_TIMEOUT = 8


#: What the scheduler and every worker must be able to run.
_PROBE = "import tablegen.tasks.runner"


@contextmanager
def _silent_logs() -> Iterator[None]:
    """Keep Dask's logs, tracebacks among them, off the terminal; our error message says it."""
    loggers = [logging.getLogger(n) for n in logging.root.manager.loggerDict if "distributed" in n]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextmanager
def dask_workers(
    scheduler: str | None, workers: int, say: Callable[[str], None]
) -> Iterator[Executor]:
    """Open an executor on Dask workers.

    The scheduler gives the task of a worker that dies to another worker, a few times.

    Parameters
    ----------
    scheduler : str or None
        Address of a running scheduler; None for a cluster on this machine.
    workers : int
        Processes on this machine, without a scheduler.
    say : callable
        Is called with a line of text if there are no workers yet.

    Yields
    ------
    Executor

    Raises
    ------
    InputError
        If Dask is not installed, the scheduler is out of reach, or the workers are lost.
    """
    try:
        from distributed import Client, KilledWorker, LocalCluster
    except ImportError as error:
        raise InputError(
            "--executor: got dask, which is not installed, "
            "allowed after: pip install 'rebound-tables[dask]'"
        ) from error
    with ExitStack() as stack:
        stack.enter_context(_silent_logs())
        if scheduler is None:
            options: dict[str, Any] = {"dashboard_address": None, "silence_logs": logging.CRITICAL}
            cluster = LocalCluster(n_workers=workers, threads_per_worker=1, **options)
            client = stack.enter_context(Client(stack.enter_context(cluster)))
        else:
            check_scheduler(scheduler, _TIMEOUT)
            try:
                client = stack.enter_context(Client(scheduler, timeout=_TIMEOUT))
                # a worker that cannot unpickle its task closes without a message, and the run hangs
                client.run_on_scheduler(exec, _PROBE, {})
                client.run(exec, _PROBE, {})
            except ImportError as error:
                raise InputError(
                    f"--scheduler: got {scheduler}, where Python says {error}, "
                    "allowed: a cluster with the same environment as here"
                ) from error
            except OSError as error:
                raise InputError(f"--scheduler: got {scheduler}, which was lost") from error
            if not client.scheduler_info()["workers"]:
                say(f"the scheduler {scheduler} has no workers yet; waiting for them")
        try:
            yield client.get_executor()
        except KilledWorker as error:
            deaths = error.allowed_failures + 1
            raise InputError(f"--executor: {deaths} workers died at the same piece") from error
        except CancelledError as error:
            raise InputError("--executor: the Dask scheduler was lost") from error
