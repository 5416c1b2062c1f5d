"""Follow many particles of one shape, WIDTH at a time, through their rebounds.

Nobody needs this file to change the physics; `tablegen.model.rebound` has the steps of a rebound.

Each lane is a slot for one particle. In every round the particles that touch the wall collide, and
all particles fly along one flight series. When a particle has left, its state is stored and its
slot is loaded with the next particle. So the vector registers stay full although rebounds differ in
length, and the result of a particle does not depend on the particles in the other lanes.

Units are those of `tablegen.model.rebound`.
"""

import math
from typing import NamedTuple

import numpy as np

from sampler.errors import OK, REBOUND_NOT_ENDED
from sampler.formats.channels import VARIABLES
from tablegen.model.contact import contact_point
from tablegen.model.impacts import (
    CONDITION_SIZE,
    INSTANT,
    condition_of,
    impact_condition,
    store_condition,
    translates,
)
from tablegen.model.jit import no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.random_particles import COSINE, NORMAL, SINE, spin_of
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
from tablegen.model.shapes import (
    FIRST_MESH,
    Body,
    has_vertices,
    inertia,
    place_vertices,
    population_map,
)
from tablegen.model.simd import (
    WIDTH,
    any_lane,
    extract,
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

#: Numbers of a result: the variables of a state, the inertia about the spin over m a^2, and the
#: kinetic energy before the impact over m V^2 / 2. Energies of rotation are over that energy, works
#: over m V^2 / 2.
OMEGA, ROTATION, COUNT, WORK, INERTIA = 3, 6, 7, 8, len(VARIABLES)
BEFORE, RESULTS = INERTIA + 1, INERTIA + 2


class LaneSlots(NamedTuple):
    """Arrays for WIDTH particles; the last dimension is the slot.

    ``motion`` (13, WIDTH) and ``series`` (9, ORDER + 1, WIDTH) as in `tablegen.model.rebound`;
    ``properties`` (12, WIDTH): moments, half-sizes, bounding radius, energy before the impact,
    collisions so far, energies that the normal and the tangential impulses took, and height at
    which the particle has left; ``condition`` (9, WIDTH) as in `tablegen.model.impacts`;
    ``candidates`` (m, 3, WIDTH) and ``counts`` (WIDTH,) as in `Body`; ``point`` (3, WIDTH): contact
    points; ``result`` (RESULTS, WIDTH): results of particles that have left;
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


class Outcome(NamedTuple):
    """Arrays that are written: ``values`` (n, RESULTS), and the codes (n,) of the rebounds."""

    values: np.ndarray
    codes: np.ndarray


@no_refcount_kernel
def _clear_slots(slots):
    """Fill the slots with a unit body at rest, so that arithmetic on empty slots stays finite.

    The vertices are zero, because rows after those of the particle in a slot are read too.
    """
    for slot in range(WIDTH):
        for k in range(MOTION_SIZE):
            slots.motion[k, slot] = 1.0 if k in (4, 6) else 0.0
        for k in range(PROPERTIES):
            slots.properties[k, slot] = 1.0
        for k in range(CONDITION_SIZE):
            slots.condition[k, slot] = 0.0 if k in (3, 4, 5) else 1.0
        slots.counts[slot] = slots.particle[slot] = 0
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
def _load_slot(population, numerics, rows, prepared, code, particle, slots, slot):
    """Load a particle into a slot; `_load_shape` adds the properties of shapes but meshes."""
    cosine, sine = prepared[particle, COSINE], prepared[particle, SINE]
    moving = cosine, sine, rows.speed[particle], spin_of(rows, particle)
    store_condition(impact_condition(*moving, numerics), slots.condition, slot)
    if code < FIRST_MESH:
        slots.properties[HALF, slot] = 1.0
        slots.properties[HALF + 1, slot] = rows.grain[particle, 1]
        slots.properties[HALF + 2, slot] = rows.grain[particle, 1] * rows.grain[particle, 2]
    else:
        _load_mesh(population, code - FIRST_MESH, slots, slot)
    for k in range(6):
        slots.motion[3 + k, slot] = prepared[particle, NORMAL + k]
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
    """Store the results of the particles that have left, and a code where one is not finite."""
    motion, result = slots.motion, slots.result
    u, v, w = load_three(motion, U)
    store_three(result, 0, (u, v, w))
    spin, about = departing_spin(body.moments, load(slots.condition, INSTANT), motion)
    store_three(result, OMEGA, spin)
    initial = load(slots.properties, INITIAL)
    store(result, ROTATION, rotational_energy(body.moments, motion) / initial)
    store(result, COUNT, load(slots.properties, COLLISIONS))
    for k in range(2):
        store(result, WORK + k, 2.0 * load(slots.properties, TAKEN + k))
    store(result, INERTIA, about)
    store(result, BEFORE, 2.0 * initial)
    for slot in range(WIDTH):
        if extract(finished, slot):
            i = slots.particle[slot]
            total = 0.0
            for k in range(RESULTS):
                outcome.values[i, k] = result[k, slot]
                total += abs(result[k, slot])
            outcome.codes[i] = OK if total < math.inf else REBOUND_NOT_ENDED


@no_refcount_kernel
def _store_alarms(slots, stuck, outcome):
    """Store the code of the particles that met an alarm."""
    for slot in range(WIDTH):
        if extract(stuck, slot):
            outcome.codes[slots.particle[slot]] = REBOUND_NOT_ENDED


@no_refcount_kernel
def follow_particles(law, population, numerics, rows, prepared, code, members, slots, outcome):
    """Follow particles of one shape until they have left, or met an alarm.

    ``numerics`` as of `tablegen.model.impacts.impact_condition`; ``rows`` are the `Rows` of all
    particles, and ``prepared`` what `prepare_particles` wrote; ``code`` is the shape code;
    ``members`` (m,) are the rows of the particles of this shape, which are written to ``outcome``.
    """
    support_map = population_map(population, code)
    _clear_slots(slots)
    candidates = slots.candidates if has_vertices(code) else slots.candidates[:0]
    touching = active = mask_from_bits(0)
    upcoming = 0
    while True:
        loading = 0
        for slot in range(WIDTH):
            if upcoming < members.shape[0] and not extract(active, slot):
                particle = members[upcoming]
                _load_slot(population, numerics, rows, prepared, code, particle, slots, slot)
                upcoming += 1
                loading |= 1 << slot
        loaded = mask_from_bits(loading)
        active = active | loaded
        if not any_lane(active):
            return
        if loading != 0 and code < FIRST_MESH:
            _load_shape(population, code, slots)
        body = _body_of_slots(slots, candidates, support_map)
        if loading != 0:
            touching = touching | _start_rebounds(body, slots, loaded)
        if any_lane(touching):
            stuck = _collide_touching(law, body, slots, touching) & active
            if any_lane(stuck):
                _store_alarms(slots, stuck, outcome)
                active = active & logical_not(stuck)
        flight = load(slots.properties, TOP), condition_of(slots.condition).tolerance
        touches, left = fly_one_series(body, *flight, slots.motion, slots.series, active)
        touching = touches & active
        finished = left & active
        if any_lane(finished):
            _store_departed(body, slots, finished, outcome)
            active = active & logical_not(finished)
