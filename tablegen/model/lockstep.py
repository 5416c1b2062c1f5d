"""Many particles of one shape, WIDTH at a time.

Each lane is a seat. In every round the particles that touch the wall collide, and all fly along
one flight series; those that have left hand in their state, and the next ones take their seats.
So the vector registers stay full although rebounds differ in length, and a particle's result does
not depend on who sits beside it.
"""

from typing import NamedTuple

import numpy as np

from sampler.compilation.jit import borrowing_inline_kernel, borrowing_kernel, inline_kernel
from tablegen.model.contact import contact_point
from tablegen.model.rebound import (
    COLLISION_ALARM,
    HEIGHT,
    MOTION_SIZE,
    U,
    V,
    W,
    approach_where,
    collide_where,
    fly,
    rotational_energy,
    translates,
    wall_spin,
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
    any_of,
    at,
    lane,
    lane_array,
    least,
    mask_of_bits,
    negated,
    put,
    select,
)

#: Rows of the traits of seated particles.
MOMENTS, B, C, REACH, INITIAL, COLLISIONS = 0, 3, 4, 5, 6, 7
TRAITS = 8


class Seats(NamedTuple):
    """Arrays of WIDTH particles; the last dimension is the seat.

    ``motion`` (13, WIDTH) and ``series`` (9, ORDER + 1, WIDTH) as in `tablegen.model.rebound`;
    ``traits`` (8, WIDTH): moments, b, c, reach, energy before the impact, collisions so far;
    ``held`` (m, 3, WIDTH) and ``counts`` (WIDTH,) as in `Body`; ``point`` (3, WIDTH): contact
    points; ``result`` (8, WIDTH): state and energies to hand in; ``member`` (WIDTH,): who sits
    there.
    """

    motion: np.ndarray
    series: np.ndarray
    traits: np.ndarray
    held: np.ndarray
    counts: np.ndarray
    point: np.ndarray
    result: np.ndarray
    member: np.ndarray


@inline_kernel
def make_seats(vertices):
    """Seats for particles of up to ``vertices`` vertices."""
    return Seats(
        lane_array(MOTION_SIZE),
        lane_array(9 * (ORDER + 1)).reshape(9, ORDER + 1, WIDTH),
        lane_array(TRAITS),
        lane_array(3 * vertices).reshape(vertices, 3, WIDTH),
        np.zeros(WIDTH, dtype=np.int64),
        lane_array(3),
        lane_array(8),
        np.zeros(WIDTH, dtype=np.int64),
    )


@borrowing_kernel
def _clear(seats):
    """Empty all seats: nobody sits there, but the numbers are used, so they are those of a body.

    Rows of vertices after those that a seat holds are read, and must be centres.
    """
    for seat in range(WIDTH):
        for k in range(MOTION_SIZE):
            seats.motion[k, seat] = 1.0 if k in (4, 6) else 0.0
        for k in range(TRAITS):
            seats.traits[k, seat] = 1.0
    for i in range(seats.held.shape[0]):
        for k in range(3):
            for seat in range(WIDTH):
                seats.held[i, k, seat] = 0.0
    for seat in range(WIDTH):
        seats.counts[seat] = 0


@borrowing_kernel
def _seat_mesh(population, mesh, seats, seat):
    """Give a seat the moments and sizes of a mesh; it holds no vertices yet."""
    for k in range(3):
        seats.traits[MOMENTS + k, seat] = population.meshes.moments[mesh, k]
        seats.traits[B + k, seat] = population.meshes.sizes[mesh, k]
    for i in range(seats.counts[seat]):
        for k in range(3):
            seats.held[i, k, seat] = 0.0
    seats.counts[seat] = 0


@borrowing_kernel
def _seat(population, drawn, code, member, seats, seat):
    """Seat a drawn particle; the numbers of a shape other than a mesh follow by `_shape`."""
    axes, kind = drawn
    if code < FIRST_MESH:
        seats.traits[B, seat] = kind[member, 1]
        seats.traits[C, seat] = kind[member, 1] * kind[member, 2]
    else:
        _seat_mesh(population, code - FIRST_MESH, seats, seat)
    for k in range(6):
        seats.motion[3 + k, seat] = axes[member, k]
    seats.traits[COLLISIONS, seat] = 0.0
    seats.member[seat] = member


@borrowing_kernel
def _shape(population, code, seats):
    """Give all seats the moments, reach and vertices of a shape; old ones get what they had."""
    t = seats.traits
    b, c = at(t, B), at(t, C)
    count, reach = place_vertices(code, b, c, population.truncation, seats.held)
    for seat in range(WIDTH):
        seats.counts[seat] = count
    moments = inertia(code, b, c, population.truncation)
    for k in range(3):
        put(t, MOMENTS + k, moments[k])
    put(t, REACH, reach)


@borrowing_inline_kernel
def _body(seats, held, near):
    """Body of the seated particles."""
    t = seats.traits
    moments = at(t, MOMENTS), at(t, MOMENTS + 1), at(t, MOMENTS + 2)
    return Body(moments, held, seats.counts, at(t, B), at(t, C), at(t, REACH), near)


@borrowing_kernel
def _start(condition, body, seats, fresh):
    """Set up the rebound of those who have just sat down."""
    approach_where(condition, body, seats.motion, fresh)
    energy = 0.5 + rotational_energy(body.moments, seats.motion)
    put(seats.traits, INITIAL, select(fresh, energy, at(seats.traits, INITIAL)))


@borrowing_kernel
def _collide(law, condition, body, seats, touching):
    """Collide those who touch the wall; whether one of them raises the alarm."""
    motion = seats.motion
    gap = contact_point(body, motion, at(motion, HEIGHT), at(motion, V), seats.point)
    lift = select(touching, least(gap, 0.0), 0.0)
    put(motion, HEIGHT, at(motion, HEIGHT) - lift)
    collide_where(
        law, condition.speed, condition.resolution, body.moments, seats.point, motion, touching
    )
    count = at(seats.traits, COLLISIONS) + select(touching, 1.0, 0.0)
    put(seats.traits, COLLISIONS, count)
    return count > COLLISION_ALARM


@borrowing_kernel
def _hand_in(body, seats, gone, outcome):
    """Write the states of those who have left."""
    motion, result = seats.motion, seats.result
    state, collisions, energy = outcome
    u, v, w = at(motion, U), at(motion, V), at(motion, W)
    spin = wall_spin(motion)
    put(result, 0, u)
    put(result, 1, v)
    put(result, 2, w)
    for k in range(3):
        put(result, 3 + k, spin[k])
    initial = at(seats.traits, INITIAL)
    put(result, 6, 0.5 * (u * u + v * v + w * w) / initial)
    put(result, 7, rotational_energy(body.moments, motion) / initial)
    for seat in range(WIDTH):
        if lane(gone, seat):
            i = seats.member[seat]
            for k in range(6):
                state[i, k] = result[k, seat]
            energy[i, 0], energy[i, 1] = result[6, seat], result[7, seat]
            collisions[i] = int(seats.traits[COLLISIONS, seat])


@inline_kernel
def _first_of(where, member):
    """Member in the first seat for which a mask holds."""
    seat = 0
    while not lane(where, seat):
        seat += 1
    return member[seat]


@borrowing_kernel
def follow(law, population, condition, drawn, code, no_map, members, seats, outcome):
    """Follow particles of one shape from before their first contact until they have left.

    Parameters
    ----------
    law : LawArguments
    population : PopulationArguments
    condition : Condition
    drawn : tuple ((n, 6) float64, (n, 3) float64)
        Wall axes n and x in body axes, and kind (shape code, b / a, c / b) of all particles.
    code : int
        Shape code; of mesh number k, FIRST_MESH + k.
    no_map : SupportMap
        That of a body that needs none.
    members : (m,) int64
        Which of the particles have the shape.
    seats : Seats
    outcome : tuple ((n, 6) float64, (n,) int64, (n, 2) float64)
        State, collisions, translational and rotational energy; the members' rows are written.

    Returns
    -------
    int
        A member that raised the collision alarm, or -1.
    """
    near = mesh_map(population.meshes, code - FIRST_MESH) if code >= FIRST_MESH else no_map
    _clear(seats)
    held = seats.held if has_vertices(code) else seats.held[:0]
    touching = seated = mask_of_bits(0)
    waiting = 0
    while True:
        arrivals = 0
        for seat in range(WIDTH):
            if waiting < members.shape[0] and not lane(seated, seat):
                _seat(population, drawn, code, members[waiting], seats, seat)
                waiting += 1
                arrivals |= 1 << seat
        fresh = mask_of_bits(arrivals)
        seated = seated | fresh
        if not any_of(seated):
            return -1
        if arrivals != 0 and code < FIRST_MESH:
            _shape(population, code, seats)
        body = _body(seats, held, near)
        if arrivals != 0:
            _start(condition, body, seats, fresh)
            if translates(condition):
                touching = touching | fresh
        if any_of(touching):
            alarm = _collide(law, condition, body, seats, touching)
            if any_of(alarm):
                return _first_of(alarm, seats.member)
        touches, left = fly(body, condition.tolerance, seats.motion, seats.series, seated)
        touching = touches & seated
        gone = left & seated
        if any_of(gone):
            _hand_in(body, seats, gone, outcome)
            seated = seated & negated(gone)
