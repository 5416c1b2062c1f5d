"""Particles from the inlet of a duct to where they leave it, and what they leave behind."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from many_hits.duct import Bend, across, along, gap, onto_wall
from many_hits.models import HALF_SIZE, FloatArray, Hits, Wall
from many_hits.motion import Gas, Path, hit_share, step

#: Time step in widths of the duct over the speed of the gas.
STEP = 0.02

#: Steps after which a particle that is still there is counted as lingering.
MOST_STEPS = 20_000

#: Hits within one step after which a particle waits on the wall for the next one.
_MOST_HITS = 20

#: An impact whose velocity into the wall is below this, over the speed of the gas, is none: the
#: particle slides. So is one that spins faster than this, times V/a.
SLIDES, SPINS = 1e-3, 300.0

#: Cells of the density along a bend, and across it.
CELLS_ALONG, CELLS_ACROSS = 40, 20

#: Columns of a record of a hit: particle, its hit (0, 1, ...), bend, whether on the outer wall,
#: place along the bend [m], speed [m/s], angle [degrees], angular velocity times a over the speed.
RECORD = ("index", "hit", "stage", "outer", "place", "speed", "angle", "spin")

#: How a particle left a bend.
WITHIN, THROUGH, SPLIT, BACK = 0, 1, 2, 3


class Stage(NamedTuple):
    """A bend, and the share of its width, on the outside, that a splitter behind it takes away."""

    bend: Bend
    split: float


@dataclass
class Particles:
    """Particles within a bend; the last axis of every array counts them.

    ``x`` (2, n), ``v``, ``omega`` (3, n): m, m/s, rad/s in the axes of the bend. ``index``,
    ``hits``: which particle, and how many walls it has met. ``turned`` (n,): time since the spin
    was as in ``omega``, s.
    """

    x: FloatArray
    v: FloatArray
    omega: FloatArray
    index: NDArray[np.int64]
    hits: NDArray[np.int64]
    turned: FloatArray

    def some(self, which) -> "Particles":
        """Return some of the particles."""
        return Particles(*(array[..., which] for array in vars(self).values()))


@dataclass
class Passage:
    """What particles leave behind in one bend.

    ``left`` (n,): how each left it. ``density`` (groups, CELLS_ALONG, CELLS_ACROSS): number of
    particles in a cell, summed over time steps. ``records``: arrays (k, 8) of hits, see `RECORD`.
    ``slid``: impacts that were none.
    """

    left: NDArray[np.int64]
    density: NDArray[np.int64]
    records: list[FloatArray] = field(default_factory=list)
    slid: int = 0


class Run(NamedTuple):
    """A model's wall, its seed, and the number of groups of particles, whose scatter is chance."""

    wall: Wall
    seed: int
    groups: int
    count: int


def inlet(bend: Bend, gas: Gas, index: NDArray[np.int64], seed: int) -> Particles:
    """Particles at the inlet: anywhere across it, with the velocity of the gas, without spin.

    Their phase within the first step is random, or all would be counted in the same planes.
    """
    n = len(index)
    share, phase = np.random.default_rng(seed).random((2, n))
    x = np.stack((STEP * bend.width * phase - bend.before, bend.inner + bend.width * share))
    v = np.tile(np.array([[gas.speed], [0.0], [0.0]]), n)
    return Particles(x, v, np.zeros((3, n)), index, np.zeros(n, dtype=np.int64), np.zeros(n))


def next_inlet(stage: Stage, bend: Bend, particles: Particles) -> Particles:
    """Particles from behind a splitter, in the axes of the next bend, which turns the other way."""
    passed = -particles.x[1] - stage.bend.behind
    x = np.stack((passed - bend.before, bend.outer - (particles.x[0] - stage.bend.inner)))
    turn = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    return Particles(
        x,
        turn @ particles.v,
        turn @ particles.omega,
        particles.index,
        particles.hits,
        particles.turned,
    )


def _rebound(
    stage: int, bend: Bend, run: Run, hits: Particles, normal: FloatArray, kept: Passage
) -> None:
    """Let particles rebound that are at a wall with the spin that they have now."""
    velocity, omega = hits.v, hits.omega
    normals = np.zeros((len(hits.index), 3))
    normals[:, :2] = normal.T
    speed = np.sqrt((velocity * velocity).sum(axis=0))
    into = -(velocity[:2] * normal).sum(axis=0)
    angle = np.degrees(np.arcsin(np.minimum(into / speed, 1.0)))
    spin = HALF_SIZE * np.sqrt((omega * omega).sum(axis=0)) / speed
    outer = across(hits.x) > bend.middle
    stages = np.full(len(speed), stage)
    place = along(bend, hits.x)
    kept.records.append(
        np.stack((hits.index, hits.hits, stages, outer, place, speed, angle, spin), axis=1)
    )
    after = run.wall(Hits(velocity.T, normals, omega.T, hits.index, hits.hits), run.seed)
    hits.v, hits.omega = after.velocity.T, after.omega.T
    hits.turned = np.zeros_like(hits.turned)
    hits.hits = hits.hits + 1


def _slide(bend: Bend, path: Path, slow: Particles) -> None:
    """Move particles along the wall for a whole step."""
    slow.x, normal = onto_wall(bend, path.end_x)
    slow.v = path.end_v.copy()
    slow.v[:2] -= np.minimum((slow.v[:2] * normal).sum(axis=0), 0.0) * normal
    slow.turned = slow.turned + path.duration


def _at_wall(gas: Gas, bend: Bend, path: Path, some: Particles) -> tuple[Particles, FloatArray]:
    """Particles that end a step behind a wall, as they are at the wall; wall normals there."""
    share = hit_share(bend, path)
    x, normal = onto_wall(bend, path.place(share))
    turned = some.turned + share * path.duration
    omega = some.omega * gas.spin_left(turned)
    return Particles(x, path.velocity(share), omega, some.index, some.hits, turned), normal


def _is_impact(gas: Gas, hits: Particles, normal: FloatArray) -> NDArray[np.bool_]:
    """Whether particles at a wall hit it, or slide along it."""
    speed = np.sqrt((hits.v * hits.v).sum(axis=0))
    spin = HALF_SIZE * np.sqrt((hits.omega * hits.omega).sum(axis=0))
    into = -(hits.v[:2] * normal).sum(axis=0)
    return (into > SLIDES * gas.speed) & (spin < SPINS * speed)


def _put(particles: Particles, rows: NDArray[Any], some: Particles) -> None:
    """Write particles into rows."""
    for name, array in vars(some).items():
        getattr(particles, name)[..., rows] = array


def _advance(
    stage: int, bend: Bend, gas: Gas, run: Run, particles: Particles, h: float, kept: Passage
) -> None:
    """Move particles for a time h, through their hits."""
    n = len(particles.index)
    moving, left = np.arange(n), np.full(n, h)
    for _ in range(_MOST_HITS):
        path = step(bend, gas, particles.x[:, moving], particles.v[:, moving], left)
        behind = gap(bend, path.end_x) <= 0.0
        free = moving[~behind]
        particles.x[:, free], particles.v[:, free] = path.end_x[:, ~behind], path.end_v[:, ~behind]
        particles.turned[free] += left[~behind]
        if len(free) == len(moving):
            return
        moving, path = moving[behind], path.some(behind)
        hits, normal = _at_wall(gas, bend, path, particles.some(moving))
        impact = _is_impact(gas, hits, normal)
        kept.slid += int((~impact).sum())
        slow = particles.some(moving[~impact])
        _slide(bend, path.some(~impact), slow)
        _put(particles, moving[~impact], slow)
        if not impact.any():
            return
        left = left[behind] - (hits.turned - particles.turned[moving])
        moving, left, hits = moving[impact], left[impact], hits.some(impact)
        _rebound(stage, bend, run, hits, normal[:, impact], kept)
        _put(particles, moving, hits)


def _count(bend: Bend, run: Run, particles: Particles, density: NDArray[np.int64]) -> None:
    """Count particles in the cells that they are in."""
    s = (along(bend, particles.x) + bend.before) / bend.length
    r = (across(particles.x) - bend.inner) / bend.width
    column = np.clip((CELLS_ALONG * s).astype(np.int64), 0, CELLS_ALONG - 1)
    row = np.clip((CELLS_ACROSS * r).astype(np.int64), 0, CELLS_ACROSS - 1)
    group = particles.index * run.groups // run.count
    cell = (group * CELLS_ALONG + column) * CELLS_ACROSS + row
    density += np.bincount(cell, minlength=density.size).reshape(density.shape)


def follow_bend(
    number: int, stage: Stage, gas: Gas, run: Run, particles: Particles
) -> tuple[Particles, Passage]:
    """Follow particles from the inlet of a bend until they have left it.

    Parameters
    ----------
    number : int
        Of the stage, for the records.
    stage : Stage
    gas : Gas
    run : Run
    particles : Particles
        At the inlet.

    Returns
    -------
    tuple (Particles, Passage)
        The same particles where they have left, and what they left behind.
    """
    bend, n = stage.bend, len(particles.index)
    shape = (run.groups, CELLS_ALONG, CELLS_ACROSS)
    kept = Passage(np.zeros(n, dtype=np.int64), np.zeros(shape, dtype=np.int64))
    # Copies, which are written to.
    particles, ended = (particles.some(np.arange(n)) for _ in range(2))
    row, h = np.arange(n), STEP * bend.width / gas.speed
    for _ in range(MOST_STEPS):
        _advance(number, bend, gas, run, particles, h, kept)
        _count(bend, run, particles, kept.density)
        x, y = particles.x
        taken = x > bend.outer - stage.split * bend.width
        how = np.where(y < -bend.behind, np.where(taken, SPLIT, THROUGH), WITHIN)
        how = np.where(x < -bend.before, BACK, how)
        out = how != WITHIN
        if out.any():
            kept.left[row[out]] = how[out]
            _put(ended, row[out], particles.some(out))
            particles, row = particles.some(~out), row[~out]
        if not len(row):
            break
    return ended, kept
