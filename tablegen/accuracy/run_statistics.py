"""Statistics of a direct simulation of any length, in memory that does not grow with it.

Batches are simulated, summarised and forgotten. Summaries are merged in the order of the
particles, whichever thread was first, so the result is the same to the last bit for any number
of threads.
"""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial, reduce

import numpy as np

from tablegen.accuracy.streaming import RunStatistics, merge, summarise
from tablegen.materials.pairs import MaterialPair
from tablegen.model.particle_run import simulate_batch
from tablegen.model.rebound import Condition
from tablegen.particles.population import Population
from tablegen.simulate import BATCH, Simulation, check_run, unfinished
from tablegen.tasks.progress import bar


def statistics_of(simulation: Simulation) -> RunStatistics:
    """Statistics of a simulation at hand, the same to the last bit as `simulate_statistics`.

    Parameters
    ----------
    simulation : Simulation

    Returns
    -------
    RunStatistics
    """
    state, collisions, energy = simulation.state, simulation.collisions, simulation.energy
    parts = (slice(start, start + BATCH) for start in range(0, len(state), BATCH))
    return reduce(merge, (summarise(state[p], collisions[p], energy[p]) for p in parts))


def _batch_statistics(
    pair: MaterialPair,
    population: Population,
    condition: Condition,
    keys: tuple[int, int],
    part: range,
) -> RunStatistics:
    """Simulate the particles of ``part``; their statistics."""
    seed, stream = keys
    size = len(part)
    state, energy, kind = np.empty((size, 6)), np.empty((size, 2)), np.empty((size, 3))
    collisions = np.empty(size, dtype=np.int64)
    stuck = simulate_batch(
        pair.kernel_arguments(),
        population.kernel_arguments(),
        condition,
        (np.uint64(seed), np.uint32(stream)),
        part.start,
        state,
        collisions,
        kind,
        energy,
    )
    if stuck >= 0:
        raise unfinished(stuck, seed, stream)
    return summarise(state, collisions, energy)


def _in_order(
    work: Callable[[range], RunStatistics], count: int, workers: int
) -> Iterator[RunStatistics]:
    """Statistics of all batches of a run, in their order, worked on side by side."""
    # No more are under way than keep the threads busy, or summaries would pile up behind a slow
    # batch.
    under_way: deque[Future[RunStatistics]] = deque()
    with ThreadPoolExecutor(workers) as pool:
        for start in range(0, count, BATCH):
            under_way.append(pool.submit(work, range(start, min(start + BATCH, count))))
            if len(under_way) > 2 * workers:
                yield under_way.popleft().result()
        while under_way:
            yield under_way.popleft().result()


def simulate_statistics(
    pair: MaterialPair,
    population: Population,
    condition: Condition,
    count: int,
    *,
    seed: int,
    stream: int = 0,
    threads: int | None = None,
    progress: bool = False,
) -> RunStatistics:
    """Simulate ``count`` rebounds and keep their statistics only.

    The particles are those of `tablegen.simulate.simulate_condition` with the same arguments.
    Memory does not depend on ``count``.

    Parameters
    ----------
    pair : MaterialPair
        Laws of restitution (6) and of resistance to sliding (7).
    population : Population
        Shapes and aspect ratios.
    condition : Condition
        From `tablegen.simulate.make_condition`.
    count : int
        Number of particles, positive.
    seed : int
        0 to 2**64 - 1.
    stream : int
        0 to 2**32 - 1; keeps conditions that share a seed independent.
    threads : int, optional
        Default: one a processor. The result does not depend on it.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    RunStatistics

    Raises
    ------
    InputError
        If an argument is out of range.
    RuntimeError
        If a particle is still in contact after 10**8 collisions.
    """
    workers = check_run(count, seed, stream, threads)
    work = partial(_batch_statistics, pair, population, condition, (seed, stream))
    total: RunStatistics | None = None
    with bar(progress, "rebound", total=count, unit_scale=True, desc="simulating") as counted:
        for part in _in_order(work, count, workers):
            total = part if total is None else merge(total, part)
            counted.update(part.count)
    assert total is not None  # a run has at least one batch
    return total
