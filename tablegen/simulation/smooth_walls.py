"""Direct simulation of smooth walls: check the conditions, call the kernel, convert results."""

import numpy as np

from tablegen.model.impacts import states_to_lab
from tablegen.model.particle_run import simulate_batch
from tablegen.model.random_particles import ParticleKeys, first_wrong_inertia
from tablegen.simulation.direct_impacts import (
    INERTIA_NOT_ITS_OWN,
    OWN,
    DirectArrays,
    DirectImpacts,
    DirectResults,
    Failure,
)


def smooth_rebounds(arrays: DirectArrays, impacts: DirectImpacts, results: DirectResults) -> None:
    """Rebound particles from smooth walls, and write their results; raises `Failure`."""
    count = len(results.states)
    conditions, grain_hits = impacts.conditions(count, arrays.numerics), impacts.grain_hits
    kind = impacts.kind(count)
    if impacts.inertia.any():
        kind, grain_hits = impacts.grains(count, arrays.population), OWN[:0]
        row = first_wrong_inertia(arrays.population, kind, conditions)
        if row >= 0:
            raise Failure(row, INERTIA_NOT_ITS_OWN)
    energy = np.empty((count, 2 if results.works is None else 4))
    keys, collisions = ParticleKeys(*impacts.keys, grain_hits), np.empty(count, dtype=np.int64)
    model = arrays.law, arrays.population, conditions, keys
    outcome = results.states, collisions, kind, energy, results.inertia
    stuck = simulate_batch(*model, *outcome)
    if stuck >= 0:
        raise Failure(stuck, 0)
    if impacts.velocity is None:
        return
    if results.works is not None:
        # works of the kernel are over the kinetic energy before, that of the spin included
        square = np.square(results.states[:, :3]).sum(axis=1)
        results.works[:] = energy[:, 2:] * (square / energy[:, 0])[:, None]
        moving = impacts.velocity - impacts.wall_velocity
        results.works[:] *= 0.5 * np.square(moving).sum(axis=1, keepdims=True)
    states_to_lab(impacts.frame, impacts.keys, results.states)
