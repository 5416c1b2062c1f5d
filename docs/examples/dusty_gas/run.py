"""One case with one model of the wall: batches on threads, and what they add up to."""

import math
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dusty_gas.case import Case
from dusty_gas.tracker import (
    BAND,
    CLAMPED_HITS,
    HITS,
    STATUS,
    STEP,
    Grid,
    Outcome,
    follow_batch,
    make_outcome,
    replay,
)
from dusty_gas.walls import Wall, make_store

FloatArray = NDArray[np.float64]

#: Equal parts that a run is cut into. Their scatter tells what chance does, see `compare`.
BATCHES = 64

#: Cells of the density field.
GRID = Grid(left=-2.5, pitch=0.025, columns=160, rows=80)

#: Hits whose rebounds are timed on their own.
_TIMED = 20_000


@dataclass(frozen=True)
class Run:
    """What the particles of one case did with one model of the wall.

    Attributes
    ----------
    case : Case
    model : str
    count : int
        Particles.
    fields : (BATCHES, 2, rows, columns) int64
        Time steps of particles in each cell of `GRID` before their first hit and after it, for
        each batch.
    hits, clamped, status : (count,) int64
        Of each particle: its hits, those beyond the range of the law, how it ended.
    first, second : (n, 5) float64
        First and second hits: impact angle [rad], speed [m/s], angle on the body from the
        stagnation point [rad], and velocity after the rebound along the normal and along the
        tangential velocity before it, over the impact speed.
    seconds : float
        Processor time of the whole run, without compilation.
    rebound_seconds : float
        Processor time of a single rebound.
    """

    case: Case
    model: str
    count: int
    fields: NDArray[np.int64]
    hits: NDArray[np.int64]
    clamped: NDArray[np.int64]
    status: NDArray[np.int64]
    first: FloatArray
    second: FloatArray
    seconds: float
    rebound_seconds: float

    @property
    def rebound_share(self) -> float:
        """Share of the processor time that goes into rebounds."""
        return float(self.hits.sum() * self.rebound_seconds / self.seconds)

    @property
    def efficiency(self) -> float:
        """Share of the particles aimed at the body that hit it at least once."""
        aimed = 1.0 / BAND if self.case.body == "cylinder" else 1.0 / BAND**2
        return float((self.hits > 0).mean() / aimed)

    @property
    def density(self) -> FloatArray:
        """Number density over that in the stream, (rows, columns), of particles that have hit."""
        return self.fields[:, 1].sum(axis=0) * density_scale(self.case.body, self.count)


def density_scale(body: str, count: int) -> FloatArray:
    """Density for one time step of one particle in each cell; zero inside the body."""
    pitch = GRID.pitch
    row = np.arange(GRID.rows)
    if body == "cylinder":
        flux, size = 2.0 * BAND / count, np.full(GRID.rows, 2.0 * pitch**2)
    else:
        flux, size = np.pi * BAND**2 / count, np.pi * ((row + 1.0) ** 2 - row**2) * pitch**3
    # Part of each cell that is outside the body, from 8 x 8 points of it.
    fine = (np.arange(8) + 0.5) / 8.0
    x = GRID.left + pitch * (np.arange(GRID.columns)[:, None] + fine).ravel()
    y = pitch * (row[:, None] + fine).ravel()
    outside = (x[None, :] ** 2 + y[:, None] ** 2 > 1.0).astype(float)
    free = outside.reshape(GRID.rows, 8, GRID.columns, 8).mean(axis=(1, 3))
    # Cells that hardly reach out of the body would show little but noise.
    return np.where(free > 0.1, STEP * flux / (size[:, None] * np.maximum(free, 0.1)), 0.0)


def _described(records: FloatArray, body: str) -> FloatArray:
    """Columns of `Run.first` for records of hits."""
    place, before, after = records[:, 2:5], records[:, 5:8], records[:, 8:11]
    normal = place.copy()
    if body == "cylinder":
        normal[:, 2] = 0.0
    speed = np.linalg.norm(before, axis=1)
    fall = -np.einsum("nk,nk->n", before, normal)
    along = before + fall[:, None] * normal
    size = np.linalg.norm(along, axis=1)
    return np.column_stack(
        (
            np.arctan2(fall, size),
            speed,
            np.arccos(np.clip(-normal[:, 0], -1.0, 1.0)),
            np.einsum("nk,nk->n", after, normal) / speed,
            np.einsum("nk,nk->n", after, along) / (size * speed),
        )
    )


def _timed_rebound(case: Case, wall: Wall, seed: np.uint64, records: FloatArray) -> float:
    """Processor time of one of the recorded rebounds; the best of three."""
    if not len(records):
        return math.nan
    store, times = make_store(wall), []
    for _ in range(3):
        begin = time.thread_time()
        worst = replay(
            wall, case.flow().body, 0.5 * case.diameter, seed, records, store, np.empty(6)
        )
        times.append(time.thread_time() - begin)
        assert worst == 0.0, "a rebound is a function of its hit and its keys"
    return min(times) / len(records)


def follow_all(case: Case, model: str, wall: Wall, count: int, *, seed: int, threads: int) -> Run:
    """Follow the particles 0, 1, ... of a case.

    Parameters
    ----------
    case : Case
    model : str
        Name of the wall's model.
    wall : Wall
    count : int
        Particles, a multiple of `BATCHES`.
    seed : int
    threads : int
        They change nothing but the time.
    """
    # Of one type for all seeds, or kernels would be compiled twice.
    key = np.uint64(seed)
    size = count // BATCHES
    scale = (case.speed, 0.5 * case.diameter)

    def work(batch: int, n: int = size) -> tuple[Outcome, float]:
        outcome, store, after = make_outcome(n, GRID), make_store(wall), np.empty(6)
        begin = time.thread_time()
        follow_batch(case.flow(), wall, scale, GRID, key, batch * size, store, after, outcome)
        return outcome, time.thread_time() - begin

    work(0, 0)  # compiles
    with ThreadPoolExecutor(threads) as pool:
        parts = list(pool.map(work, range(BATCHES)))
    outcomes = [outcome for outcome, _ in parts]
    records = np.concatenate([o.records[: o.used[0]] for o in outcomes])
    particles = np.concatenate([o.particles for o in outcomes])
    return Run(
        case=case,
        model=model,
        count=count,
        fields=np.stack([o.field for o in outcomes]),
        hits=particles[:, HITS],
        clamped=particles[:, CLAMPED_HITS],
        status=particles[:, STATUS],
        first=_described(records[records[:, 1] == 0.0], case.body),
        second=_described(records[records[:, 1] == 1.0], case.body),
        seconds=sum(seconds for _, seconds in parts),
        rebound_seconds=_timed_rebound(case, wall, key, records[:_TIMED]),
    )
