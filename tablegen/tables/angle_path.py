"""How far rebounds change between two angles: the coordinate in which their quantiles are averaged.

Between two nodes a table averages quantiles. The mean of a variable is then right if the weights
follow that mean from one node to the other. Several variables have one pair of weights, so these
follow the *path* of their means, in units of their spreads: narrow variables decide, because a
small error is far off there. Nearly round grains near normal impact, whose tangential velocity
hardly spreads, are several times closer than with weights that follow the square root of the
angle (tablegen/fitting/EXPERIMENTS.md).
"""

import math
from functools import lru_cache
from itertools import pairwise

import numpy as np

from tablegen.config.config import PLANE, Config
from tablegen.fitting.node import STEEPEST_DEG
from tablegen.model.float_array import FloatArray
from tablegen.simulation.scene_variables import simulated_variables
from tablegen.simulation.simulate import simulate

#: Largest steps of the path, in the square root of the angle in degrees: narrower cells have one.
_LONGEST_STEP = 0.075

#: Particles at each step. They are the same at all steps, so that differences have little noise.
_PARTICLES = 2000

#: Share of the coordinate that is the same for all steps, so that it grows where nothing changes.
_EQUAL_SHARE = 0.05

#: Spread [V] below which a variable counts as one number.
_LEAST_SPREAD = 1e-6

#: Stream of the particles, below those of measurements.
_STREAM = 2**31 - 1


def path_index(config: Config, nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Follow the path from node to node.

    Returns increasing angles [degrees], and the fractional node index at each. A cell depends on
    its own two nodes alone, so it is the same in every grid.
    """
    angles, index = [nodes[:1]], [np.zeros(1)]
    for k, (low, high) in enumerate(pairwise(nodes.tolist())):
        steps, share = _divide_cell(config, low, high)
        angles.append(steps[1:])
        index.append(k + share[1:])
    return np.concatenate(angles), np.concatenate(index)


@lru_cache(maxsize=4096)
def _divide_cell(config: Config, low: float, high: float) -> tuple[FloatArray, FloatArray]:
    """Divide a cell into steps; returns their ends [degrees] and the shares of the path there."""
    first, last = math.sqrt(low), math.sqrt(high)
    count = math.ceil((last - first) / _LONGEST_STEP)
    steps = np.linspace(first, last, count + 1) ** 2
    steps[0], steps[-1] = low, high
    lengths = _step_lengths(config, steps) if count > 1 else np.ones(1)
    whole = lengths.sum()
    shares = lengths / whole if whole > 0.0 else np.full(count, 1.0 / count)
    ends = np.cumsum([0.0, *((1.0 - _EQUAL_SHARE) * shares + _EQUAL_SHARE / count)])
    ends[-1] = 1.0
    return steps, ends


def _step_lengths(config: Config, steps: FloatArray) -> FloatArray:
    """Measure the path of the means of a plane rebound, step by step.

    Changes are over the spread of a variable in the cell, at the slowest and the fastest speed.
    """
    squares = np.zeros(len(steps) - 1)
    for speed in dict.fromkeys(config.domain.speed):
        states = [_simulate_plane_rebounds(config, angle, speed) for angle in steps]
        means = np.array([state.mean(axis=0) for state in states])
        spread = np.mean([state.std(axis=0) for state in states], axis=0)
        changes = np.diff(means, axis=0) / np.maximum(spread, _LEAST_SPREAD)
        squares += np.square(changes).sum(axis=1)
    return np.sqrt(squares)


def _simulate_plane_rebounds(config: Config, alpha_deg: float, speed: float) -> FloatArray:
    """Simulate rebounds, and return their variables u, v and omega_z."""
    alpha1, seed = np.radians(min(alpha_deg, STEEPEST_DEG)), config.table.seed
    simulation = simulate(config, alpha1, speed, _PARTICLES, seed=seed, stream=_STREAM, threads=1)
    return simulated_variables(simulation, PLANE)
