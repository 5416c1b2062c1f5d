"""Particles from far upstream until they have left, and what they leave behind.

A particle is a pure function of (seed, index): its place in the stream and every one of its
rebounds have random numbers of their own. What batches leave are counts, so their sums do not
depend on the number of threads.
"""

import math
from typing import NamedTuple

import numpy as np
from sampler.compilation.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.philox import philox_block, uniform
from sampler.drawing.vectors import scaled

from dusty_gas.gas import CYLINDER, outward, spin_left
from dusty_gas.motion import advance
from dusty_gas.walls import rebound_at_wall
from sampler.errors import CLAMPED, OK

#: Keeps places in the stream and rebounds on different random numbers.
_STREAM_KEY = np.uint64(0x4455_5354_5947_4153)

#: Time between two positions that are looked at, and length of a step, in R/U.
STEP = 0.04

#: Half-width of the band of particles in the stream, or its radius.
BAND = 2.0

#: Where particles start, and beyond which planes they are no longer followed.
START, UPSTREAM, DOWNSTREAM, SIDE = -4.0, -5.0, 2.0, 4.0

#: Time after which a particle that is still there is counted as lingering.
LONGEST = 100.0

#: Hits of a particle of which every number is kept.
RECORDED = 3

#: Columns of a record: particle, its hit, position (3), velocity before (3), after (3), spin after
#: (3) and before (3). Lengths in R, velocities in m/s, angular velocities in rad/s.
RECORD_SIZE = 17

#: Rows of the outcome of a particle.
HITS, CLAMPED_HITS, STATUS = 0, 1, 2

#: Status of a particle: it has left, it lingers, or a hit could not be computed.
LEFT, LINGERS, FAILED = 0, 1, 2


class Grid(NamedTuple):
    """Cells of the density field: ``columns`` in x from ``left``, ``rows`` in distance from 0.

    The distance is |y| for the cylinder and that from the x axis for the sphere; ``pitch`` is the
    side of a cell.
    """

    left: float
    pitch: float
    columns: int
    rows: int


class Outcome(NamedTuple):
    """What n particles leave behind.

    ``field`` (2, rows, columns) int64: in how many time steps of a particle it was in a cell,
    before its first hit and after it.
    ``particles`` (n, 3) int64: hits, hits outside the range of the law, status. ``records``
    (n * RECORDED, RECORD_SIZE) float64, of which the first ``used[0]`` rows are written.
    """

    field: np.ndarray
    particles: np.ndarray
    records: np.ndarray
    used: np.ndarray


@inline_kernel
def start(body, seed, index):
    """Place and velocity of a particle in the stream.

    Uniform over the band; its phase within the first step is random, or all particles would be
    looked at in the same planes.
    """
    w0, w1, w2, _ = philox_block(np.uint64(seed) ^ _STREAM_KEY, index, 0, 0)
    x = START - STEP * uniform(w2)
    if body == CYLINDER:
        return x, BAND * (2.0 * uniform(w0) - 1.0), 0.0, 1.0, 0.0, 0.0
    distance = BAND * math.sqrt(uniform(w0))
    azimuth = 2.0 * math.pi * uniform(w1)
    return x, distance * math.cos(azimuth), distance * math.sin(azimuth), 1.0, 0.0, 0.0


@inline_kernel
def _across(body, p):
    """Distance from the plane (cylinder) or axis (sphere) of symmetry."""
    return abs(p[1]) if body == CYLINDER else math.sqrt(p[1] * p[1] + p[2] * p[2])


@no_refcount_inline_kernel
def _count(grid, body, p, layer, field):
    """Count a particle in the cell that it is in."""
    column = math.floor((p[0] - grid.left) / grid.pitch)
    row = math.floor(_across(body, p) / grid.pitch)
    if 0 <= column < grid.columns and row < grid.rows:
        field[layer, int(row), int(column)] += 1


@no_refcount_inline_kernel
def _record(outcome, index, hit, p, velocity, after, omega):
    """Keep a hit."""
    row = outcome.records[outcome.used[0]]
    row[0], row[1] = index, hit
    for k in range(3):
        row[2 + k] = p[k]
        row[5 + k] = velocity[k]
        row[14 + k] = omega[k]
    for k in range(6):
        row[8 + k] = after[k]
    outcome.used[0] += 1


@no_refcount_kernel
def _hit(flow, wall, scale, keys, p, omega, store, after, outcome):
    """Rebound of a particle on the surface; a status and its position and velocity afterwards."""
    speed, half_size = scale
    normal = outward(flow.body, p[0], p[1], p[2])
    velocity = (speed * p[3], speed * p[4], speed * p[5])
    status = rebound_at_wall(wall, velocity, normal, half_size, omega, keys, store, after)
    if status < OK:
        return status, p
    if keys[2] < RECORDED:
        _record(outcome, keys[1], keys[2], p, velocity, after, omega)
    return status, (p[0], p[1], p[2], after[0] / speed, after[1] / speed, after[2] / speed)


@no_refcount_kernel
def follow(flow, wall, scale, grid, seed, index, p, store, after, outcome, row):
    """Follow one particle until it has left.

    Parameters
    ----------
    flow : Flow
    wall : Wall
    scale : tuple of two float
        Speed of the stream in m/s, half-size of the particle in m.
    grid : Grid
    seed, index : int
    p : tuple of six float
        Position and velocity at the start.
    store : Store
    after : (6,) float64
        Work space.
    outcome : Outcome
    row : int
        The particle's row in ``outcome.particles``.
    """
    mine = outcome.particles[row]
    mine[HITS], mine[CLAMPED_HITS], mine[STATUS] = 0, 0, LINGERS
    omega, flown = (0.0, 0.0, 0.0), 0.0
    for _ in range(int(LONGEST / STEP)):
        left = STEP
        while left > 0.0:
            hits, passed, p = advance(flow, p, left)
            left -= passed
            flown += passed
            if not hits:
                break
            keys = (seed, index, mine[HITS])
            omega = scaled(spin_left(flow, flown), omega)
            status, p = _hit(flow, wall, scale, keys, p, omega, store, after, outcome)
            omega, flown = (after[3], after[4], after[5]), 0.0
            if status < OK:
                mine[STATUS] = FAILED
                return
            mine[HITS] += 1
            if status == CLAMPED:
                mine[CLAMPED_HITS] += 1
        _count(grid, flow.body, p, min(mine[HITS], 1), outcome.field)
        if p[0] < UPSTREAM or p[0] > DOWNSTREAM or _across(flow.body, p) > SIDE:
            mine[STATUS] = LEFT
            return


@no_refcount_kernel
def follow_batch(flow, wall, scale, grid, seed, first, store, after, outcome):
    """Follow the particles ``first``, ``first + 1``, ..., one for each row of the outcome."""
    for row in range(outcome.particles.shape[0]):
        index = first + row
        p = start(flow.body, seed, index)
        follow(flow, wall, scale, grid, seed, index, p, store, after, outcome, row)


@no_refcount_kernel
def replay(wall, body, half_size, seed, records, store, after):
    """Rebounds of recorded hits once more, for their time; largest difference of a velocity."""
    worst = 0.0
    for k in range(records.shape[0]):
        row = records[k]
        normal = outward(body, row[2], row[3], row[4])
        velocity = (row[5], row[6], row[7])
        keys = (seed, int(row[0]), int(row[1]))
        omega = (row[14], row[15], row[16])
        rebound_at_wall(wall, velocity, normal, half_size, omega, keys, store, after)
        for i in range(3):
            worst = max(worst, abs(after[i] - row[8 + i]))
    return worst


def make_outcome(count: int, grid: Grid) -> Outcome:
    """Empty outcome of `count` particles."""
    return Outcome(
        np.zeros((2, grid.rows, grid.columns), dtype=np.int64),
        np.zeros((count, 3), dtype=np.int64),
        np.empty((count * RECORDED, RECORD_SIZE)),
        np.zeros(1, dtype=np.int64),
    )
