"""Particles of a run, simulated on threads in short calls of kernels.

A particle is keyed by (seed, stream, index), so no result depends on how a run is split.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from tablegen.model.coulomb import PIECE_ALARM
from tablegen.model.float_array import FloatArray
from tablegen.model.rebound import COLLISION_ALARM

if TYPE_CHECKING:
    from tablegen.simulation.simulate import Simulation

#: Most particles in a call of a kernel, longest call in seconds, and particles of the first calls,
#: which show how long one takes: at grazing angles thousands of times longer than at others.
BATCH = 5_000
_CALL_SECONDS = 0.1
_FIRST_CALL = 50

_Result = TypeVar("_Result")


def in_slices(
    work: Callable[[slice], _Result], count: int, threads: int
) -> Iterator[tuple[slice, _Result]]:
    """Work on slices of particles in threads; yield the slices and their results in order.

    A slice takes about a tenth of a second whatever the condition. After Ctrl-C or an error the
    slices that wait are dropped, and those that run are waited for. One thread is the caller's.
    """
    size = _FIRST_CALL

    def timed(part: slice) -> tuple[slice, _Result]:
        nonlocal size
        begin = time.perf_counter()
        result = work(part)
        per_second = (part.stop - part.start) / max(time.perf_counter() - begin, 1e-9)
        size = int(min(max(_CALL_SECONDS * per_second, 1.0), BATCH))
        return part, result

    start = 0
    while threads == 1 and start < count:
        done = timed(slice(start, min(start + size, count)))
        start = done[0].stop
        yield done
    under_way: deque[Future[tuple[slice, _Result]]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        try:
            while start < count or under_way:
                while start < count and len(under_way) < 2 * threads:
                    part = slice(start, min(start + size, count))
                    under_way.append(pool.submit(timed, part))
                    start = part.stop
                yield under_way.popleft().result()
        finally:
            for future in under_way:
                future.cancel()


def unfinished(particle: str) -> RuntimeError:
    """Make the error for a particle, in words, that does not leave the wall."""
    return RuntimeError(
        f"{particle} is still in contact after {COLLISION_ALARM:,} collisions, or "
        f"{PIECE_ALARM:,} pieces of one; a larger contact_resolution ends a chain of collisions"
    )


class NotFiniteError(RuntimeError):
    """A particle with a state or energy that is not finite; `simulation` has all, if kept."""

    def __init__(
        self, particle: int, seed: int, stream: int, simulation: "Simulation | None" = None
    ) -> None:
        super().__init__(f"particle {particle} of seed {seed}, stream {stream} is not finite")
        self.simulation = simulation


def first_not_finite(*arrays: FloatArray) -> int:
    """Find the first row, in any of several arrays (n, k), with NaN or infinity; -1 if none."""
    bad = [np.flatnonzero(~np.isfinite(array).all(axis=1)) for array in arrays]
    return min((int(rows[0]) for rows in bad if rows.size), default=-1)
