"""Chains of hits without a gas: on one wall, or on two walls in turn."""

from typing import NamedTuple

import numpy as np

from many_hits.models import HALF_SIZE, FloatArray, Hits, Wall

SAME, OPPOSITE = "same", "opposite"

#: What is looked at after each hit: speed [m/s], angle from the wall [degrees], angular velocity
#: times a over the speed, and its component along z, across the plane of the first impact.
QUANTITIES = ("speed", "angle", "spin", "spin_z")

_UP = np.array([0.0, 1.0, 0.0])


class Chain(NamedTuple):
    """How particles meet their walls.

    ``walls``: on "opposite" walls, as in a channel, they fly straight from one to the other; to the
    "same" wall they come back with the angle at which they left it, as on the outside of a bend.
    ``alpha_deg``, ``speed``: of the first impact, degrees and m/s; it is without spin.
    """

    walls: str
    alpha_deg: float
    speed: float

    @property
    def name(self) -> str:
        """Words for it."""
        wall = "one wall" if self.walls == SAME else "opposite walls"
        return f"{wall}, {self.alpha_deg:g}°, {self.speed:g} m/s"


def follow_chain(chain: Chain, wall: Wall, count: int, hits: int, seed: int) -> FloatArray:
    """Follow particles through their hits.

    Parameters
    ----------
    chain : Chain
    wall : Wall
    count : int
        Particles.
    hits : int
    seed : int

    Returns
    -------
    float64 array, shape (hits, 4, count)
        `QUANTITIES` after each hit.
    """
    alpha, index = np.radians(chain.alpha_deg), np.arange(count)
    velocity = np.tile(chain.speed * np.array([np.cos(alpha), -np.sin(alpha), 0.0]), (count, 1))
    omega, normal = np.zeros((count, 3)), _UP
    found = np.empty((hits, len(QUANTITIES), count))
    for hit in range(hits):
        velocity, omega = wall(Hits(velocity, normal, omega, index, hit), seed)
        speed = np.linalg.norm(velocity, axis=1)
        turn = HALF_SIZE / speed
        angle = np.degrees(np.arcsin(np.minimum(velocity @ normal / speed, 1.0)))
        found[hit] = speed, angle, turn * np.linalg.norm(omega, axis=1), turn * omega[:, 2]
        if chain.walls == SAME:
            velocity = velocity * np.array([1.0, -1.0, 1.0])
        else:
            normal = -normal
    return found
