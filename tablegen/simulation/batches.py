"""Particles of a run, simulated in calls of kernels that are short whatever the condition.

A particle is keyed by (seed, stream, index), so no result depends on how a run is split.
"""

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model.audit import AUDIT_SIZE
from tablegen.model.impact_condition import Condition, one_row
from tablegen.model.particle_run import simulate_audited, simulate_batch
from tablegen.model.random_particles import keys_of_run
from tablegen.model.rebound import COLLISION_ALARM
from tablegen.tasks.side_by_side import go_on

if TYPE_CHECKING:
    from tablegen.simulation.simulate import Simulation

#: Particles that a thread takes at once: few enough to balance threads. Statistics are merged by
#: batches, so their last bits depend on it.
BATCH = 5_000

#: Seconds that a call of a kernel shall take at most, because nothing ends it, and particles of the
#: first call, which shows how long they take: at grazing angles thousands of times longer.
_CALL_SECONDS = 0.1
_FIRST_CALL = 50


def batches(count: int) -> Iterator[slice]:
    """Particles of each batch of a run."""
    for start in range(0, count, BATCH):
        yield slice(start, min(start + BATCH, count))


def unfinished(particle: str) -> RuntimeError:
    """Error for a particle, in words, that has too many collisions."""
    return RuntimeError(
        f"{particle} is still in contact after {COLLISION_ALARM:,} collisions; "
        "a larger contact_resolution ends its chain"
    )


class NotFiniteError(RuntimeError):
    """A particle with a state or energy that is not finite, which is a defect of the model.

    Attributes
    ----------
    simulation : Simulation or None
        All particles, where they were kept.
    """

    def __init__(
        self, particle: int, seed: int, stream: int, simulation: "Simulation | None" = None
    ) -> None:
        super().__init__(f"particle {particle} of seed {seed}, stream {stream} is not finite")
        self.simulation = simulation


def first_not_finite(*arrays: NDArray[np.float64]) -> int:
    """First row, in any of some arrays (n, k), with a number that is not finite; -1 if none."""
    bad = [np.flatnonzero(~np.isfinite(array).all(axis=1)) for array in arrays]
    return min((int(rows[0]) for rows in bad if rows.size), default=-1)


class ParticleRun:
    """Particles at one condition, simulated in calls of kernels between which a run can end.

    Parameters
    ----------
    pair, population, condition, seed, stream, audited
        As for `tablegen.simulation.simulate.simulate_condition`.
    """

    def __init__(
        self,
        pair: MaterialPair,
        population: Population,
        condition: Condition,
        seed: int,
        stream: int,
        audited: bool = False,
    ) -> None:
        self._shared = pair.kernel_arguments(), population.kernel_arguments(), one_row(condition)
        self._keys = seed, stream
        self._audited = audited
        #: Particles of the next call. Threads write it as they see fit: no result depends on it.
        self._size = _FIRST_CALL

    def simulate(self, first: int, *arrays: NDArray[Any]) -> NDArray[np.float64]:
        """Simulate particles from the first on, as many as the arrays have rows.

        Parameters
        ----------
        first : int
            Index of the particle of row 0.
        *arrays
            State, collisions, kind and energy, as for `tablegen.model.particle_run.simulate_batch`.

        Returns
        -------
        (AUDIT_SIZE,) float64, or empty
            Largest violation of each law, if the run is audited.

        Raises
        ------
        RuntimeError
            If a particle has too many collisions.
        """
        audit = np.zeros(AUDIT_SIZE if self._audited else 0)
        start, count = 0, len(arrays[0])
        while start < count:
            go_on()
            size = min(self._size, count - start)
            rows = [array[start : start + size] for array in arrays]
            begin = time.perf_counter()
            self._call(first + start, rows, audit)
            per_second = size / max(time.perf_counter() - begin, 1e-9)
            self._size = int(min(max(_CALL_SECONDS * per_second, 1.0), BATCH))
            start += size
        return audit

    def check_finite(
        self, first: int, *arrays: NDArray[np.float64], simulation: "Simulation | None" = None
    ) -> None:
        """Raise `NotFiniteError` for the first particle with a number that is not finite.

        Parameters
        ----------
        first : int
            Index of the particle of row 0.
        *arrays
            States and energies.
        simulation : Simulation, optional
            What to keep of the run.
        """
        bad = first_not_finite(*arrays)
        if bad >= 0:
            raise NotFiniteError(first + bad, *self._keys, simulation)

    def _call(self, first: int, rows: list[NDArray[Any]], audit: NDArray[np.float64]) -> None:
        seed, stream = self._keys
        keys = keys_of_run(seed, stream, first, len(rows[0]))
        arguments = [*self._shared, keys, *rows]
        if self._audited:
            arguments.append(audit)
        stuck = (simulate_audited if self._audited else simulate_batch)(*arguments)
        if stuck >= 0:
            raise unfinished(f"particle {first + stuck} of seed {seed}, stream {stream}")
