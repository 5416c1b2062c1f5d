"""Direct rebounds from smooth walls: conditions, orientations, the kernel, and its results."""

import numpy as np

from tablegen.model.impacts import states_to_lab
from tablegen.model.orientation import axes_from, orientations_from
from tablegen.model.particle_run import simulate_batch
from tablegen.model.random_particles import ParticleKeys
from tablegen.simulation.direct_impacts import DirectArrays, DirectImpacts, DirectResults, Failure


def smooth_rebounds(arrays: DirectArrays, impacts: DirectImpacts, results: DirectResults) -> None:
    """Rebound particles from smooth walls, and write their results; raises `Failure`.

    Impacts in the frame of the wall need no orientations after it, whose kernel is then not
    compiled.
    """
    count = len(results.states)
    conditions, axes = impacts.conditions(count, arrays.numerics), np.empty((count, 6))
    oriented = impacts.orientation is not None
    if oriented:
        row, code = axes_from(impacts.orientation, impacts.frame, impacts.keys, axes)
        if row >= 0:
            raise Failure(row, code)
    keys = ParticleKeys(*impacts.keys, impacts.made_at, oriented)
    energy = np.empty((count, 2 if results.works is None else 4))
    unused = np.empty(count, dtype=np.int64), impacts.kind(count)
    model = arrays.law, arrays.population, conditions, keys
    stuck = simulate_batch(*model, axes, results.states, *unused, energy)
    if stuck >= 0:
        raise Failure(stuck, 0)
    if impacts.velocity is None:
        return
    if results.works is not None:  # those of the kernel are over all energy, that of spin too
        square = np.square(results.states[:, :3]).sum(axis=1)
        results.works[:] = energy[:, 2:] * (square / energy[:, 0])[:, None]
        moving = impacts.velocity - impacts.wall_velocity
        results.works[:] *= 0.5 * np.square(moving).sum(axis=1, keepdims=True)
    orientations_from(axes, impacts.frame, impacts.keys, results.orientation)
    states_to_lab(impacts.frame, impacts.keys, results.states)
