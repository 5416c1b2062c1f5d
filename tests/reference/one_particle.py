"""One particle at a time: its rebound by the functions of the model, each step audited.

The model follows eight particles in lanes. Its functions take floats as well, so here they follow
one particle, and `audit` checks each collision and flight against the laws in their defining form.
Results have the bits of the lanes.
"""

import math
from typing import NamedTuple

import numpy as np
from audit import AUDIT_SIZE, PENETRATION, audit_collision, audit_flight

from sampler.library import grains
from tablegen.config.config import load_config
from tablegen.model.contact import contact_point
from tablegen.model.elementary import cosine_and_sine
from tablegen.model.impacts import impact_condition, translates
from tablegen.model.jit import inline_kernel, kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.random_particles import COSINE, PREPARED, SINE, Rows, prepare_particles, spin_of
from tablegen.model.rebound import (
    COLLISION_ALARM,
    HEIGHT,
    MOTION_SIZE,
    U,
    V,
    W,
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
    MAX_VERTICES,
    Body,
    ShapeArguments,
    SupportMap,
    inertia,
    place_vertices,
    population_map,
)
from tablegen.simulation.direct_law import DirectLaw, DirectParts

#: Any laws: grains do not depend on them.
PAIR = load_config("corundum-steel").pair

#: Status that `rebound` returns: the particle has left the wall, or an alarm was reached.
LEFT, UNFINISHED = 0, 1

#: Map of a body that needs none. Its slack is infinite, so it limits no step.
NO_MAP = SupportMap(0, math.inf, np.zeros(1, dtype=np.int64), np.empty((0, 3)))


@no_refcount_inline_kernel
def shaped_body(shape, b, c, truncation, vertices, counts, no_map):
    """Make the body of a shape other than a mesh, with half-sizes (1, b, c).

    Only kernels that count no references may call it. The caller keeps the arrays alive:
    ``vertices`` (MAX_VERTICES, 3), ``counts`` (1,) int64 and an empty map.
    """
    counts[0], bounding_radius = place_vertices(shape, b, c, truncation, vertices)
    moments = inertia(shape, b, c, truncation)
    return Body(moments, vertices[: counts[0]], counts, (1.0, b, c), bounding_radius, no_map)


@no_refcount_inline_kernel
def mesh_body(meshes, i, candidates, counts, support_map):
    """Make the body of mesh number ``i`` of a population, still without candidate vertices.

    Only kernels that count no references may call it. The caller keeps the arrays alive:
    ``candidates`` (meshes.longest, 3), ``counts`` (1,) int64 and ``support_map`` from `mesh_map`.
    """
    moments = (meshes.moments[i, 0], meshes.moments[i, 1], meshes.moments[i, 2])
    half = meshes.reach[i, 0], meshes.reach[i, 1], meshes.reach[i, 2]
    for k in range(candidates.shape[0]):
        candidates[k, 0] = candidates[k, 1] = candidates[k, 2] = 0.0
    counts[0] = 0
    return Body(moments, candidates, counts, half, meshes.sizes[i, 2], support_map)


@no_refcount_kernel
def fly_to_contact(body, top, tolerance, motion, series):
    """Advance ``motion`` to the next contact or departure; tell whether the particle touches."""
    while True:
        touches, left = fly_one_series(body, top, tolerance, motion, series, True)
        if touches or left:
            return touches


@no_refcount_kernel
def _copy_motion(motion, before):
    """Copy the motion by numbers, because a slice assignment would make a temporary array."""
    for i in range(MOTION_SIZE):
        before[i] = motion[i]


@no_refcount_kernel
def rebound(law, condition, body, motion, work, audit):
    """Follow a particle from before its first contact until it has left the wall.

    ``motion`` (13,) is the motion before the rebound, and on return that of the departure. ``work``
    comes from `workspace`. ``audit`` (AUDIT_SIZE,) gets the largest violations of the laws; with an
    array of the shape (0,) nothing is audited. Returns the status, the number of collisions, and
    the energies that the normal and the tangential impulses took.
    """
    series, point, before = work
    collisions = 0
    normal = shear = 0.0
    # a particle without spin starts at its first contact
    touches, top = translates(condition), body.bounding_radius
    while True:
        if not touches:
            _copy_motion(motion, before)
            touches = fly_to_contact(body, top, condition.tolerance, motion, series)
            if audit.size > 0:
                audit_flight(body.moments, before, motion, audit)
            if not touches:
                return LEFT, collisions, (normal, shear)
        if collisions == COLLISION_ALARM:
            return UNFINISHED, collisions, (normal, shear)
        gap = contact_point(body, motion, motion[HEIGHT], motion[V], point)
        motion[HEIGHT] -= min(gap, 0.0)
        _copy_motion(motion, before)
        numbers = condition.speed, condition.resolution
        taken = apply_collision(law, *numbers, body.moments, point, motion, series)
        normal, shear = normal + taken[0], shear + taken[1]
        if has_no_impulse(taken):
            return UNFINISHED, collisions, taken
        top = departure_height(body, condition.instant, motion)
        touches = False
        collisions += 1
        if audit.size > 0:
            audit[PENETRATION] = max(audit[PENETRATION], -gap)
            audit_collision(law, *numbers, body.moments, point, before, motion, audit)


@inline_kernel
def workspace():
    """Make the arrays that `rebound` works in."""
    return np.empty((9, ORDER + 1)), np.empty(3), np.empty(MOTION_SIZE)


def kernel_condition(condition):
    """Condition of the kernels from that of `make_condition`."""
    cosine, sine = cosine_and_sine(condition.alpha1)
    numerics = condition.numerics.contact_resolution, condition.numerics.tolerance
    given = cosine, sine, condition.speed, condition.spin
    return impact_condition(*given, (*numerics, float(condition.instant)))


@kernel
def _follow(law, population, numerics, rows, prepared, values, audit):
    """Follow particles one at a time; return one that does not finish, or -1."""
    motion, vertices = np.empty(MOTION_SIZE), max(MAX_VERTICES, population.meshes.longest)
    storage = np.zeros((vertices, 3)), np.zeros(1, dtype=np.int64), workspace()
    for i in range(rows.alpha1.size):
        grain = int(rows.grain[i, 0]), rows.grain[i, 1], rows.grain[i, 2]
        given = prepared[i, COSINE], prepared[i, SINE], rows.speed[i], spin_of(rows, i)
        condition = impact_condition(*given, numerics)
        for k in range(6):
            motion[3 + k] = prepared[i, k]
        model = law, population, condition
        if not _follow_one(*model, grain, motion, storage, values[i], audit):
            return i
    return -1


@no_refcount_kernel
def _follow_one(law, population, condition, grain, motion, storage, values, audit):
    """Follow a particle, and write its numbers as `tablegen.model.lockstep` does."""
    shape, ba, cb = grain
    points, counts, work = storage
    map_ = population_map(population, shape)
    if shape < FIRST_MESH:
        body = shaped_body(shape, ba, ba * cb, population.truncation, points, counts, map_)
    else:
        body = mesh_body(population.meshes, shape - FIRST_MESH, points, counts, map_)
    place_before_impact(condition, body, motion)
    initial = 0.5 + rotational_energy(body.moments, motion)
    status, collisions, taken = rebound(law, condition, body, motion, work, audit)
    spin, values[10] = departing_spin(body.moments, condition.instant, motion)
    values[0], values[1], values[2] = motion[U], motion[V], motion[W]
    values[3], values[4], values[5] = spin
    values[6] = rotational_energy(body.moments, motion) / initial
    values[7] = collisions
    values[8], values[9], values[11] = 2.0 * taken[0], 2.0 * taken[1], 2.0 * initial
    return status == LEFT


class Alone(NamedTuple):
    """Particles that were followed one at a time: numbers as of `Simulated`, grains, audit."""

    values: np.ndarray
    grain: np.ndarray
    audit: np.ndarray


def prepared_rows(population, condition, count, seed, stream=0):
    """Impacts of the particles of `simulate_condition`, and what is prepared for each."""
    law = DirectLaw(DirectParts.from_parts(PAIR, population, condition.numerics))
    index, hit = np.arange(count, dtype=np.uint64), np.full(count, stream, np.uint32)
    grain = grains(law, seed, index, count, hit)
    spin = np.tile(np.array(condition.spin, dtype=np.float64), (count, 1))
    numbers = (np.full(count, x) for x in (condition.alpha1, condition.speed, condition.inertia))
    alpha1, speed, about = numbers
    rows = Rows(alpha1, speed, spin, about, grain, index, hit, np.uint64(seed))
    prepared = np.empty((count, PREPARED))
    prepare_particles(shapes_of(population), rows, prepared)
    return rows, prepared


def shapes_of(population):
    """Shapes of a population as kernels take them."""
    arguments = population.kernel_arguments()
    return ShapeArguments(arguments.shape_codes, arguments.truncation, arguments.meshes)


def simulate_alone(pair, population, condition, count, seed):
    """Simulate the particles of `simulate_condition` one at a time, and audit each."""
    rows, prepared = prepared_rows(population, condition, count, seed)
    numerics = condition.numerics.contact_resolution, condition.numerics.tolerance
    values, audit = np.empty((count, 12)), np.zeros(AUDIT_SIZE)
    given = pair.kernel_arguments(population.only_spheres), shapes_of(population)
    stuck = _follow(*given, (*numerics, float(condition.instant)), rows, prepared, values, audit)
    if stuck >= 0:
        raise RuntimeError(f"particle {stuck} is still in contact")
    return Alone(values, rows.grain, audit)
