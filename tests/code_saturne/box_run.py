"""Particles and hits in the box: records of cs_user_box.c, and the same flights in Python."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import saturne_run
from first_hits import CONDITIONS, DIAMETER, HALF_SIZE, SEED, states_of
from free_flight import fly

VECTORS = Path(__file__).parents[1] / "vectors"
#: Mass of a particle [kg]; density and viscosity of the gas.
MASS = 3950.0 * np.pi / 6 * DIAMETER**3
GAS = 1.17862, 1.83337e-5


class Particles(NamedTuple):
    """Particles at one time, in the order of their identities; (n,) or (n, 3), SI."""

    index: np.ndarray
    hits: np.ndarray
    omega: np.ndarray
    inertia: np.ndarray
    position: np.ndarray
    velocity: np.ndarray


class Hits(NamedTuple):
    """Hits of a run in the order of identities and hits; (n,) or (n, 3), SI."""

    index: np.ndarray
    hit: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray
    inertia: np.ndarray
    normal: np.ndarray
    new_velocity: np.ndarray
    new_omega: np.ndarray
    new_inertia: np.ndarray


def _read(folder, name, columns):
    """Records of all processes: identities, in order, and the rows with them."""
    parts = [np.fromfile(path) for path in sorted(folder.glob(f"{name}.*.bin"))]
    rows = np.concatenate([part.reshape(-1, columns) for part in parts])
    rows = rows[np.lexsort((rows[:, 2], rows[:, 1], rows[:, 0]))]
    index = rows[:, 0].astype(np.uint64) << np.uint64(32) | rows[:, 1].astype(np.uint64)
    return index, rows


def read_particles(folder, name):
    """Particles at the "start" of a run or at its "end"."""
    index, rows = _read(folder, name, 13)
    kept = rows[:, 2].astype(int), rows[:, 3:6], rows[:, 6]
    return Particles(index, *kept, rows[:, 7:10], rows[:, 10:])


def read_hits(*folders):
    """Hits of a run, and of those that go on from it."""
    records = [_read(folder, "hits", 23) for folder in folders]
    index, rows = map(np.concatenate, zip(*records, strict=True))
    before = rows[:, 10:13], rows[:, 3:6], rows[:, 6]
    after = rows[:, 16:19], rows[:, 19:22], rows[:, 22]
    return Hits(index, rows[:, 2].astype(int), *before, rows[:, 13:16], *after)


def read_faces(folder):
    """Centres of the boundary faces (n, 3), their sums (n, 8) and histograms (n, 20)."""
    parts = [np.fromfile(path).reshape(-1, 31) for path in sorted(folder.glob("faces.*.bin"))]
    return np.hsplit(np.concatenate(parts), [3, 11])


def places(folder):
    """Where on the walls the hits of `read_hits` were, shape (n, 3)."""
    return _read(folder, "hits", 23)[1][:, 7:10]


def number(index):
    """Number of each particle among those of its time step."""
    return (index & np.uint64(0xFFFFFFFF)).astype(int)


def is_normal(index):
    """Whether particles begin straight towards a wall: then any direction along it is as good."""
    return number(index) % len(CONDITIONS) == len(CONDITIONS) - 1


def rebound(table, hits, half_size=HALF_SIZE, **more):
    """Let `Table.rebound` compute rebounds of the grains of these particles at their hits."""
    given = {"omega": hits.omega, "inertia": hits.inertia, "index": hits.index, "hit": hits.hit}
    return table.rebound(hits.velocity, hits.normal, half_size, seed=SEED, **given, **more)


def replay(table, started, end, **flight):
    """Follow particles through the box from their start, as `free_flight.fly` does."""

    def at_wall(rows, normal, velocity, omega, inertia, hits):
        before = started.index[rows], hits, velocity, omega, inertia, normal
        return rebound(table, Hits(*before, None, None, None))

    box = saturne_run.LOWER, saturne_run.UPPER
    return fly((started.position, started.velocity), end, box, at_wall, **flight)


def states(hits):
    """States in the frame of each impact, (n, 6)."""
    straight = is_normal(hits.index) & (hits.hit == 0)
    return states_of(hits.velocity, hits.normal, hits.new_velocity, hits.new_omega, straight)


def conditions(hits):
    """Condition of each hit, -1 where it is not a first one on floor or lid."""
    first = (hits.hit == 0) & (np.abs(hits.normal[:, 1]) > 0.5)
    return np.where(first, number(hits.index) % len(CONDITIONS), -1)
