"""Rebounds of many particles of a population, at one impact condition or at one each.

Nobody needs this file to change the physics. It draws the particles, sorts them by shape, so that
particles followed in lockstep have equally many vertices, and follows each shape
(`tablegen.model.lockstep`). An audited run follows one particle at a time, by the same functions
and with the same bits. It is a kernel of its own because few runs are audited, and it takes as long
to compile.

Units are those of `tablegen.model.rebound`.
"""

import numpy as np

from tablegen.model.impacts import condition_of
from tablegen.model.jit import kernel, no_refcount_kernel
from tablegen.model.lockstep import follow_particles, make_slots
from tablegen.model.random_particles import draw_particles
from tablegen.model.rebound import (
    LEFT,
    MOTION_SIZE,
    U,
    V,
    W,
    departing_spin,
    place_before_impact,
    rebound,
    rotational_energy,
    workspace,
)
from tablegen.model.shapes import (
    FIRST_MESH,
    MAX_VERTICES,
    N_SHAPES,
    empty_map,
    mesh_body,
    mesh_map,
    shaped_body,
)


@kernel
def _sorted_by_shape(kind, meshes):
    """Sort the particles by shape; return their indices and where each shape starts.

    Shapes are numbered without a gap: first those with codes of their own, then the meshes.
    """
    starts = np.zeros(N_SHAPES + meshes + 1, dtype=np.int64)
    numbers = np.empty(kind.shape[0], dtype=np.int64)
    for i in range(kind.shape[0]):
        code = int(kind[i, 0])
        numbers[i] = code if code < FIRST_MESH else code - FIRST_MESH + N_SHAPES
        starts[numbers[i] + 1] += 1
    for number in range(starts.size - 1):
        starts[number + 1] += starts[number]
    order = np.empty(kind.shape[0], dtype=np.int64)
    place = starts.copy()
    for i in range(kind.shape[0]):
        order[place[numbers[i]]] = i
        place[numbers[i]] += 1
    return order, starts


@no_refcount_kernel
def follow_particle(law, population, condition, drawn, motion, storage, audit):
    """Follow one random particle with a given orientation through its rebound.

    ``drawn`` is shape code, b / a and c / b. ``motion`` (13,) has the orientation, and on return
    the motion after the rebound. ``storage`` are arrays for vertices and their number, an empty
    support map, and the work space of `rebound`. Returns the status, the number of collisions, the
    angular velocity in wall axes with the inertia about it, and four energies over the kinetic
    energy before the impact: translational and rotational after the rebound, and those that the
    normal and the tangential impulses took.
    """
    shape, ba, cb = drawn
    candidates, counts, no_map, work = storage
    if shape < FIRST_MESH:
        body = shaped_body(shape, ba, ba * cb, population.truncation, candidates, counts, no_map)
    else:
        support_map = mesh_map(population.meshes, shape - FIRST_MESH)
        body = mesh_body(population.meshes, shape - FIRST_MESH, candidates, counts, support_map)
    place_before_impact(condition, body, motion)
    initial = 0.5 + rotational_energy(body.moments, motion)
    status, collisions, taken = rebound(law, condition, body, motion, work, audit)
    translational = 0.5 * (motion[U] ** 2 + motion[V] ** 2 + motion[W] ** 2) / initial
    rotational = rotational_energy(body.moments, motion) / initial
    energies = translational, rotational, taken[0] / initial, taken[1] / initial
    return status, collisions, departing_spin(body.moments, condition.instant, motion), energies


@kernel
def simulate_batch(law, population, conditions, keys, state, collisions, kind, energy, inertia):
    """Simulate particles, WIDTH at a time; return the row of one that did not finish, or -1.

    ``conditions`` (n, 10) or (1, 10) is the impact of each particle, or of all of them
    (`tablegen.model.impacts`); ``keys`` are `ParticleKeys`. The other arrays are written:

    - ``state`` (n, 6): velocities over V, angular velocities times a / V, wall axes;
    - ``collisions`` (n,);
    - ``kind`` (n, 3): shape code, with FIRST_MESH + k for mesh number k, b / a, c / b; if
      ``keys.grain`` is empty, it is read and not written;
    - ``energy`` (n, 2) or (n, 4): translational and rotational energy over the energy before the
      impact, and the energies that the normal and the tangential impulses took;
    - ``inertia`` (n,): about the spin of a particle as it leaves, over m a^2; 0 without spin.
    """
    axes = np.empty((state.shape[0], 6))
    draw_particles(population, conditions, keys, axes, kind)
    order, starts = _sorted_by_shape(kind, population.meshes.resolutions.size)
    slots, no_map = make_slots(max(MAX_VERTICES, population.meshes.longest)), empty_map()
    drawn, outcome = (axes, kind), (state, collisions, energy, inertia)
    for number in range(starts.size - 1):
        code = number if number < N_SHAPES else number - N_SHAPES + FIRST_MESH
        members = order[starts[number] : starts[number + 1]]
        unfinished = follow_particles(
            law, population, conditions, drawn, code, no_map, members, slots, outcome
        )
        if unfinished >= 0:
            return unfinished
    return -1


@kernel
def simulate_audited(
    law, population, conditions, keys, state, collisions, kind, energy, inertia, audit
):
    """Simulate as `simulate_batch`, one particle at a time, and check each collision and flight.

    ``audit`` (AUDIT_SIZE,) gets the largest violation of each law.
    """
    motion, axes = np.empty(MOTION_SIZE), np.empty((state.shape[0], 6))
    draw_particles(population, conditions, keys, axes, kind)
    candidates = np.zeros((max(MAX_VERTICES, population.meshes.longest), 3))
    storage = candidates, np.zeros(1, dtype=np.int64), empty_map(), workspace()
    for i in range(state.shape[0]):
        condition = condition_of(conditions[i if conditions.shape[0] > 1 else 0])
        for k in range(6):
            motion[3 + k] = axes[i, k]
        drawn = int(kind[i, 0]), kind[i, 1], kind[i, 2]
        status, collisions[i], (spin, inertia[i]), energies = follow_particle(
            law, population, condition, drawn, motion, storage, audit
        )
        if status != LEFT:
            return i
        state[i, 0], state[i, 1], state[i, 2] = motion[U], motion[V], motion[W]
        state[i, 3], state[i, 4], state[i, 5] = spin
        for k in range(energy.shape[1]):
            energy[i, k] = energies[k]
    return -1
