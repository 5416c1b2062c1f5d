"""Motion of many particles through a duct over one step, and the instants at which they hit.

A step is one of the midpoint rule. A hit is looked for on the cubic curve through its ends, by
halving; so it is found within the curve's own error, of fourth order in the step. A particle that
grazes the inner wall within one step, between two points in the gas, is missed.
"""

from typing import NamedTuple

import numpy as np
from dusty_gas.case import GAS_DENSITY, PARTICLE_DENSITY, VISCOSITY
from dusty_gas.gas import SPIN_RESPONSE, drag_factor

from many_hits.duct import Bend, gap, gas_velocity
from many_hits.models import FloatArray

#: Halvings by which a hit is found: to 1e-9 of a step.
_HALVINGS = 30


class Gas(NamedTuple):
    """Speed of the gas in the straight parts, m/s, and diameter of the particles, m."""

    speed: float
    diameter: float

    @property
    def response(self) -> float:
        """Stokes response time of a particle's velocity, s."""
        return PARTICLE_DENSITY * self.diameter**2 / (18.0 * VISCOSITY)

    def spin_left(self, passed: FloatArray) -> FloatArray:
        """Share of its spin that a particle has after some time, s, in a gas without vorticity."""
        return np.exp(-SPIN_RESPONSE / self.response * passed)


class Path(NamedTuple):
    """Steps of n particles: places (2, n) and velocities (3, n) at both ends, durations (n,)."""

    x: FloatArray
    v: FloatArray
    end_x: FloatArray
    end_v: FloatArray
    duration: FloatArray

    def some(self, which) -> "Path":
        """Steps of some of the particles."""
        return Path(*(array[..., which] for array in self))

    def place(self, t: FloatArray) -> FloatArray:
        """Places at shares t of the steps."""
        h, s = self.duration, 1.0 - t
        ends = s * s * (1.0 + 2.0 * t) * self.x + t * t * (1.0 + 2.0 * s) * self.end_x
        return ends + t * s * h * (s * self.v[:2] - t * self.end_v[:2])

    def velocity(self, t: FloatArray) -> FloatArray:
        """Velocities at shares t of the steps."""
        return (1.0 - t) * self.v + t * self.end_v


def acceleration(bend: Bend, gas: Gas, x: FloatArray, v: FloatArray) -> FloatArray:
    """Acceleration of particles by drag, (3, n)."""
    slip = -v
    slip[:2] += gas_velocity(bend, gas.speed, x)
    size = np.sqrt((slip * slip).sum(axis=0))
    reynolds = (GAS_DENSITY * gas.diameter / VISCOSITY) * size
    return slip * (drag_factor(reynolds) / gas.response)


def step(bend: Bend, gas: Gas, x: FloatArray, v: FloatArray, duration: FloatArray) -> Path:
    """Move particles for a time each."""
    half = 0.5 * duration
    middle_v = v + half * acceleration(bend, gas, x, v)
    end_v = v + duration * acceleration(bend, gas, x + half * v[:2], middle_v)
    return Path(x, v, x + duration * middle_v[:2], end_v, duration)


def hit_share(bend: Bend, path: Path) -> FloatArray:
    """Shares of steps that end behind a wall after which they are at the wall, (n,)."""
    low, high = np.zeros_like(path.duration), np.ones_like(path.duration)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        inside = gap(bend, path.place(middle)) > 0.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return low
