"""Rebounds of a run of particles of a population at one impact condition."""

import numpy as np

from sampler.jit import borrowing_kernel, kernel
from tablegen.model.directions import empty_map
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
from tablegen.model.shapes import MAX_VERTICES, MESH, mesh_body, shaped_body


@borrowing_kernel
def _follow(law, population, condition, drawn, motion, store, audit):
    """Rebound of a particle drawn with its orientation; its body lives here only.

    Parameters
    ----------
    law, population, condition, audit
        As for `simulate_batch`.
    drawn : tuple (shape code, b / a, c / b)
    motion : (13,) float64
        In: the orientation. Out: the motion after the rebound.
    store : tuple
        Storage for vertices, an empty map, and the work space of `rebound`.

    Returns
    -------
    tuple (status, collisions, kinetic energy before, rotational energy after)
    """
    shape, ba, cb = drawn
    vertices, no_map, work = store
    if shape < MESH:
        body = shaped_body(shape, ba, ba * cb, population.truncation, vertices, no_map)
    else:
        body = mesh_body(population.meshes, shape - MESH)
    approach(condition, body, motion)
    initial = 0.5 + rotational_energy(body.moments, motion)
    status, collisions = rebound(law, condition, body, motion, work, audit)
    return status, collisions, initial, rotational_energy(body.moments, motion)


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
        Output: shape code (the same for all meshes), b / a, c / b.
    energy : (n, 2) float64
        Output: translational and rotational energy over the energy before the impact.
    audit : (0,) or (AUDIT_SIZE,) float64

    Returns
    -------
    int
        Index of the first particle that did not finish, or -1.
    """
    seed, stream = keys
    motion = np.empty(MOTION_SIZE)
    store = np.empty((MAX_VERTICES, 3)), empty_map(), workspace()
    for i in range(state.shape[0]):
        drawn = draw_particle(population, seed, stream, first + i, motion)
        status, collisions[i], initial, rotational = _follow(
            law, population, condition, drawn, motion, store, audit
        )
        if status != LEFT:
            return first + i
        kind[i, 0], kind[i, 1], kind[i, 2] = min(drawn[0], MESH), drawn[1], drawn[2]
        state[i, 0], state[i, 1], state[i, 2] = motion[U], motion[V], motion[W]
        state[i, 3], state[i, 4], state[i, 5] = wall_spin(motion)
        velocity2 = motion[U] ** 2 + motion[V] ** 2 + motion[W] ** 2
        energy[i, 0] = 0.5 * velocity2 / initial
        energy[i, 1] = rotational / initial
    return -1
