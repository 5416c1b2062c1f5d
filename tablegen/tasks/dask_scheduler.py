"""Whether a Dask scheduler answers at an address, before a client is opened that would wait for it.

Dask's client bounds the time for a connection, but not that for the first words on it: at a port
that accepts and says nothing, or that belongs to another service, it waits for minutes.
"""

import asyncio
from collections.abc import Coroutine
from typing import Any

from sampler.errors import InputError

_ALLOWED = "allowed: the address of a running Dask scheduler"


def check_scheduler(address: str, timeout: float) -> None:
    """Refuse an address where no Dask scheduler answers.

    Parameters
    ----------
    address : str
    timeout : float
        Seconds, for everything.

    Raises
    ------
    InputError
        If none answers in time, another service does, or there are no certificates for ``tls://``.
    """
    from distributed.security import Security

    security: dict[str, Any] = Security().get_connection_args("client")
    if address.startswith(("tls://", "wss://")) and security.get("ssl_context") is None:
        raise InputError(
            f"--scheduler: got {address}, for which there are no certificates, "
            "allowed after: distributed.comm.tls in Dask's configuration"
        )
    try:
        kind = asyncio.run(_in_time(_kind_of_service(address, timeout, security), timeout))
    except (OSError, ValueError) as error:  # timeouts are of the first kind
        raise InputError(
            f"--scheduler: got {address}, where none answered within {timeout} s, {_ALLOWED}"
        ) from error
    except Exception as error:  # whatever comes of reading the words of another service
        said = f"{type(error).__name__}: {error}".rstrip(": ")
        raise InputError(
            f"--scheduler: got {address}, where no Dask scheduler answers ({said}), {_ALLOWED}"
        ) from error
    if kind != "Scheduler":
        raise InputError(f"--scheduler: got {address}, which is a {kind}, {_ALLOWED}")


async def _in_time(answer: Coroutine[Any, Any, str], timeout: float) -> str:
    # what Ctrl-C breaks off is no news; errors come out of the call
    asyncio.get_running_loop().set_exception_handler(lambda *_: None)
    return await asyncio.wait_for(answer, timeout)


async def _kind_of_service(address: str, timeout: float, security: dict[str, Any]) -> str:
    from distributed.core import connect, send_recv

    comm = await connect(address, timeout=timeout, **security)
    try:
        identity = await send_recv(comm, op="identity")
        return str(identity["type"])
    finally:
        comm.abort()
