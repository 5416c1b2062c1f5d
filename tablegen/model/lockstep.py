"""Follow many particles of one shape, WIDTH at a time, through their rebounds.

Nobody needs this file to change the physics; `tablegen.model.rebound` has the steps of a rebound.

Each lane is a slot for one particle. In every round the particles that touch the wall collide, and
all particles fly along one flight series. When a particle has left, its state is stored and its
slot is loaded with the next particle. So the vector registers stay full although rebounds differ in
length, and the result of a particle does not depend on the particles in the other lanes.

Units are those of `tablegen.model.rebound`.
"""

from typing import NamedTuple

import numpy as np

from tablegen.model.contact import contact_point
from tablegen.model.impacts import CONDITION_SIZE, INSTANT, condition_of, translates
from tablegen.model.jit import inline_kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.rebound import (
    COLLISION_ALARM,
    HEIGHT,
    MOTION_SIZE,
    U,
    V,
    apply_collision,
    departing_spin,
    departure_height,
    fly_one_series,
    has_no_impulse,
    place_before_impact,
    rotational_energy,
)
from tablegen.model.rotation import ORDER
from tablegen.model.shapes import (
    FIRST_MESH,
    Body,
    has_vertices,
    inertia,
    mesh_map,
    place_vertices,
)
from tablegen.model.simd import (
    WIDTH,
    any_lane,
    extract,
    lane_array,
    load,
    load_three,
    logical_not,
    mask_from_bits,
    minimum,
    select,
    store,
    store_three,
)

#: Rows of the properties of the particles in the slots.
MOMENTS, HALF, RADIUS, INITIAL, COLLISIONS, TAKEN, TOP = 0, 3, 6, 7, 8, 9, 11
PROPERTIES = 12

#: Rows of a result: state, energies, and the inertia about the spin.
ENERGIES, INERTIA = 6, 10
RESULTS = 11


class LaneSlots(NamedTuple):
    """Arrays for WIDTH particles; the last dimension is the slot.

    ``motion`` (13, WIDTH) and ``series`` (9, ORDER + 1, WIDTH) as in `tablegen.model.rebound`;
    ``properties`` (12, WIDTH): moments, half-sizes, bounding radius, energy before the impact,
    collisions so far, energies that the normal and the tangential impulses took, and height at
    which the particle has left; ``condition`` (10, WIDTH) as in `tablegen.model.impacts`;
    ``candidates`` (m, 3, WIDTH) and ``counts`` (WIDTH,) as in `Body`; ``point`` (3, WIDTH): contact
    points; ``result`` (11, WIDTH): states, energies and inertia of particles that have left;
    ``particle`` (WIDTH,): row of the particle in each slot.
    """

    motion: np.ndarray
    series: np.ndarray
    properties: np.ndarray
    condition: np.ndarray
    candidates: np.ndarray
    counts: np.ndarray
    point: np.ndarray
    result: np.ndarray
    particle: np.ndarray


@inline_kernel
def make_slots(vertices):
    """Make slots for particles of up to ``vertices`` vertices."""
    return LaneSlots(
        lane_array(MOTION_SIZE),
        lane_array(9 * (ORDER + 1)).reshape(9, ORDER + 1, WIDTH),
        lane_array(PROPERTIES),
        lane_array(CONDITION_SIZE),
        lane_array(3 * vertices).reshape(vertices, 3, WIDTH),
        np.zeros(WIDTH, dtype=np.int64),
        lane_array(3),
        lane_array(RESULTS),
        np.zeros(WIDTH, dtype=np.int64),
    )


@no_refcount_kernel
def _clear_slots(conditions, slots):
    """Fill the slots with a unit body, so that arithmetic on slots without a particle stays finite.

    Their condition is the first one, which may be that of all particles. The vertices are zero,
    because rows after those of the particle in a slot are read too.
    """
    for slot in range(WIDTH):
        for k in range(MOTION_SIZE):
            slots.motion[k, slot] = 1.0 if k in (4, 6) else 0.0
        for k in range(PROPERTIES):
            slots.properties[k, slot] = 1.0
        for k in range(CONDITION_SIZE):
            slots.condition[k, slot] = conditions[0, k]
        slots.counts[slot] = 0
        for i in range(slots.candidates.shape[0]):
            for k in range(3):
                slots.candidates[i, k, slot] = 0.0


@no_refcount_kernel
def _load_mesh(population, mesh, slots, slot):
    """Load the moments and sizes of a mesh into a slot; it has no candidate vertices yet."""
    for k in range(3):
        slots.properties[MOMENTS + k, slot] = population.meshes.moments[mesh, k]
        slots.properties[HALF + k, slot] = population.meshes.reach[mesh, k]
    slots.properties[RADIUS, slot] = population.meshes.sizes[mesh, 2]
    for i in range(slots.counts[slot]):
        for k in range(3):
            slots.candidates[i, k, slot] = 0.0
    slots.counts[slot] = 0


@no_refcount_kernel
def _load_slot(population, conditions, drawn, code, particle, slots, slot):
    """Load a random particle into a slot.

    `_load_shape` adds the properties of shapes other than meshes.
    """
    axes, kind = drawn
    if conditions.shape[0] > 1:
        for k in range(CONDITION_SIZE):
            slots.condition[k, slot] = conditions[particle, k]
    if code < FIRST_MESH:
        slots.properties[HALF, slot] = 1.0
        slots.properties[HALF + 1, slot] = kind[particle, 1]
        slots.properties[HALF + 2, slot] = kind[particle, 1] * kind[particle, 2]
    else:
        _load_mesh(population, code - FIRST_MESH, slots, slot)
    for k in range(6):
        slots.motion[3 + k, slot] = axes[particle, k]
    for k in range(COLLISIONS, PROPERTIES):
        slots.properties[k, slot] = 0.0
    slots.particle[slot] = particle


@no_refcount_kernel
def _load_shape(population, code, slots):
    """Load moments, bounding radius and vertices of a shape into all slots.

    Slots that were loaded before get the same numbers again.
    """
    t = slots.properties
    _, b, c = load_three(t, HALF)
    count, bounding_radius = place_vertices(code, b, c, population.truncation, slots.candidates)
    for slot in range(WIDTH):
        slots.counts[slot] = count
    store_three(t, MOMENTS, inertia(code, b, c, population.truncation))
    store(t, RADIUS, bounding_radius)


@no_refcount_inline_kernel
def _body_of_slots(slots, candidates, support_map):
    """Make the body of the particles in the slots."""
    t = slots.properties
    moments, half, radius = load_three(t, MOMENTS), load_three(t, HALF), load(t, RADIUS)
    return Body(moments, candidates, slots.counts, half, radius, support_map)


@no_refcount_kernel
def _start_rebounds(body, slots, loaded):
    """Set up the rebounds of the particles in the lanes ``loaded``; tell which touch the wall."""
    condition = condition_of(slots.condition)
    place_before_impact(condition, body, slots.motion, loaded)
    energy = 0.5 + rotational_energy(body.moments, slots.motion)
    store(slots.properties, INITIAL, select(loaded, energy, load(slots.properties, INITIAL)))
    return loaded & translates(condition)


@no_refcount_kernel
def _collide_touching(law, body, slots, touching):
    """Collide the particles that touch the wall; tell which of them met an alarm."""
    motion, condition = slots.motion, condition_of(slots.condition)
    gap = contact_point(body, motion, load(motion, HEIGHT), load(motion, V), slots.point)
    lift = select(touching, minimum(gap, 0.0), 0.0)
    store(motion, HEIGHT, load(motion, HEIGHT) - lift)
    numbers = condition.speed, condition.resolution
    taken = apply_collision(
        law, *numbers, body.moments, slots.point, motion, slots.series, touching
    )
    for k in range(2):
        store(slots.properties, TAKEN + k, load(slots.properties, TAKEN + k) + taken[k])
    top = departure_height(body, condition.instant, motion)
    store(slots.properties, TOP, select(touching, top, load(slots.properties, TOP)))
    count = load(slots.properties, COLLISIONS) + select(touching, 1.0, 0.0)
    store(slots.properties, COLLISIONS, count)
    return (count > COLLISION_ALARM) | has_no_impulse(taken)


@no_refcount_kernel
def _store_departed(body, slots, finished, outcome):
    """Store states, energies, inertia and collisions of the particles that have left."""
    motion, result = slots.motion, slots.result
    state, collisions, energy, inertias = outcome
    u, v, w = load_three(motion, U)
    store_three(result, 0, (u, v, w))
    spin, about = departing_spin(body.moments, load(slots.condition, INSTANT), motion)
    store_three(result, 3, spin)
    store(result, INERTIA, about)
    initial = load(slots.properties, INITIAL)
    store(result, ENERGIES, 0.5 * (u * u + v * v + w * w) / initial)
    store(result, ENERGIES + 1, rotational_energy(body.moments, motion) / initial)
    for k in range(2):
        store(result, ENERGIES + 2 + k, load(slots.properties, TAKEN + k) / initial)
    for slot in range(WIDTH):
        if extract(finished, slot):
            i = slots.particle[slot]
            for k in range(6):
                state[i, k] = result[k, slot]
            inertias[i] = result[INERTIA, slot]
            for k in range(energy.shape[1]):
                energy[i, k] = result[ENERGIES + k, slot]
            collisions[i] = int(slots.properties[COLLISIONS, slot])


@inline_kernel
def _particle_of_first_lane(where, particle):
    """Return the particle in the first slot in which a mask is true."""
    slot = 0
    while not extract(where, slot):
        slot += 1
    return particle[slot]


@no_refcount_kernel
def follow_particles(law, population, conditions, drawn, code, no_map, members, slots, outcome):
    """Follow particles of one shape until they have left; return one that met an alarm, or -1.

    ``drawn`` are the wall axes n and x in body axes (n, 6) and the kinds (n, 3) of all particles;
    ``code`` is the shape code, FIRST_MESH + k of mesh k; ``no_map`` is an empty support map;
    ``members`` (m,) are the rows of the particles of this shape; ``outcome`` are the arrays state,
    collisions, energies and inertia of `tablegen.model.particle_run.simulate_batch`, in which the
    rows of ``members`` are written.
    """
    support_map = mesh_map(population.meshes, code - FIRST_MESH) if code >= FIRST_MESH else no_map
    _clear_slots(conditions, slots)
    candidates = slots.candidates if has_vertices(code) else slots.candidates[:0]
    touching = active = mask_from_bits(0)
    upcoming = 0
    while True:
        loading = 0
        for slot in range(WIDTH):
            if upcoming < members.shape[0] and not extract(active, slot):
                _load_slot(population, conditions, drawn, code, members[upcoming], slots, slot)
                upcoming += 1
                loading |= 1 << slot
        loaded = mask_from_bits(loading)
        active = active | loaded
        if not any_lane(active):
            return -1
        if loading != 0 and code < FIRST_MESH:
            _load_shape(population, code, slots)
        body = _body_of_slots(slots, candidates, support_map)
        if loading != 0:
            touching = touching | _start_rebounds(body, slots, loaded)
        if any_lane(touching):
            alarm = _collide_touching(law, body, slots, touching)
            if any_lane(alarm):
                return _particle_of_first_lane(alarm, slots.particle)
        flight = load(slots.properties, TOP), condition_of(slots.condition).tolerance
        touches, left = fly_one_series(body, *flight, slots.motion, slots.series, active)
        touching = touches & active
        finished = left & active
        if any_lane(finished):
            _store_departed(body, slots, finished, outcome)
            active = active & logical_not(finished)
