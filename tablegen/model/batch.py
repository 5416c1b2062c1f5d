"""Rebounds of a run of particles of a population at one impact condition."""

import numpy as np

from sampler.jit import kernel
from tablegen.model.population import draw_particle
from tablegen.model.rebound import (
    LEFT,
    MOTION_SIZE,
    U,
    V,
    W,
    approach,
    rebound,
    rotational_energy,
    wall_spin,
    workspace,
)
from tablegen.model.shapes import MAX_VERTICES, make_body


@kernel
def simulate_batch(law, population, condition, keys, first, state, collisions, kind, energy, audit):
    """Simulate the particles ``first``, ``first + 1``, ... of a stream.

    Parameters
    ----------
    law : LawArguments
    population : PopulationArguments
    condition : Condition
    keys : tuple (uint64, uint32)
        Seed and stream.
    first : int
    state : (n, 6) float64
        Output: velocities over V, angular velocities times a / V, wall axes.
    collisions : (n,) int64
        Output.
    kind : (n, 3) float64
        Output: shape code, b / a, c / b.
    energy : (n, 2) float64
        Output: translational and rotational energy over the energy before the impact.
    audit : (0,) or (AUDIT_SIZE,) float64

    Returns
    -------
    int
        Index of the first particle that did not finish, or -1.
    """
    seed, stream = keys
    vertices = np.empty((MAX_VERTICES, 3))
    motion = np.empty(MOTION_SIZE)
    work = workspace()
    for i in range(state.shape[0]):
        shape, ba, cb = draw_particle(population, seed, stream, first + i, motion)
        b, c = ba, ba * cb
        body = make_body(shape, b, c, population.truncation, vertices)
        approach(condition, body, motion)
        initial = 0.5 + rotational_energy(body.moments, motion)
        status, collisions[i] = rebound(law, condition, body, motion, work, audit)
        if status != LEFT:
            return first + i
        kind[i, 0], kind[i, 1], kind[i, 2] = shape, ba, cb
        state[i, 0], state[i, 1], state[i, 2] = motion[U], motion[V], motion[W]
        state[i, 3], state[i, 4], state[i, 5] = wall_spin(motion)
        velocity2 = motion[U] ** 2 + motion[V] ** 2 + motion[W] ** 2
        energy[i, 0] = 0.5 * velocity2 / initial
        energy[i, 1] = rotational_energy(body.moments, motion) / initial
    return -1
