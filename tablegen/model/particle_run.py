"""Direct simulation as C calls it: the rebounds of some particles, one impact each.

Nobody needs this file to change the physics. `simulate_rows` takes addresses of arrays, as a
function of C does. It orients the particles, sorts them by shape, so that particles followed in
lockstep have equally many vertices, and follows each shape (`tablegen.model.lockstep`). It
allocates nothing and knows no global state. `tablegen.simulation.direct_law` compiles it for this
process, and `tablegen.simulation.exported_law` into an object file.

A law, a population and the numerical parameters are two arrays, one of floats and one of integers:
`pack_model` makes them, and `_unpack_model` reads them in the same order.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tablegen.model.contact_laws import LawArguments
from tablegen.model.impacts import CONDITION_SIZE
from tablegen.model.jit import no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.lockstep import PROPERTIES, RESULTS, LaneSlots, Outcome, follow_particles
from tablegen.model.memory import array_at, stack_array, stack_integers
from tablegen.model.random_particles import PREPARED, Rows, prepare_particles
from tablegen.model.rebound import MOTION_SIZE
from tablegen.model.rotation import ORDER
from tablegen.model.shapes import MAX_VERTICES, MeshArguments, ShapeArguments
from tablegen.model.simd import WIDTH

#: How many integers and floats stand in front of the arrays of a packed model.
_INTEGERS, _REALS = 9, 9


def pack_model(
    law: LawArguments, population: ShapeArguments, numerics: tuple[float, float, float]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Pack laws, particles and numerical parameters into an array of floats and one of integers.

    ``numerics`` as of `tablegen.model.impacts.impact_condition`.
    """
    meshes = population.meshes
    integers: list[Any] = [
        [law.restitution_law, law.resistance_law, law.numbers.size, law.resistances.size],
        [population.shape_codes.size, meshes.resolutions.size, meshes.starts.size],
        [len(meshes.points), meshes.longest],
        population.shape_codes,
        meshes.firsts,
        meshes.resolutions,
        meshes.starts,
    ]
    reals: list[Any] = [
        [law.coefficient, law.exponent, law.strength, law.factor],
        [population.truncation, meshes.slack, *numerics],
        law.numbers,
        law.resistances,
        meshes.moments,
        meshes.sizes,
        meshes.reach,
        meshes.points,
    ]
    return (
        np.concatenate([np.ravel(part) for part in reals]).astype(np.float64),
        np.concatenate([np.ravel(part) for part in integers]).astype(np.int64),
    )


@no_refcount_inline_kernel
def _unpack_model(reals, integers):
    """Read law, population and numerical parameters from what `pack_model` made."""
    first = array_at(reals, 0, (_REALS,))
    count = array_at(integers, 0, (_INTEGERS,))
    numbers, resistances, shapes = count[2], count[3], count[4]
    meshes, starts, points = count[5], count[6], count[7]
    at = _INTEGERS
    shape_codes = array_at(integers, at, (shapes,))
    at += shapes
    firsts = array_at(integers, at, (meshes + 1, 2))
    at += 2 * (meshes + 1)
    resolutions = array_at(integers, at, (meshes,))
    lists = array_at(integers, at + meshes, (starts,))
    at = _REALS
    law = LawArguments(
        first[0],
        first[1],
        first[2],
        first[3],
        count[0],
        count[1],
        array_at(reals, at, (numbers,)),
        array_at(reals, at + numbers, (resistances,)),
    )
    at += numbers + resistances
    solids = MeshArguments(
        array_at(reals, at, (meshes, 3)),
        array_at(reals, at + 3 * meshes, (meshes, 3)),
        array_at(reals, at + 6 * meshes, (meshes, 3)),
        firsts,
        resolutions,
        first[5],
        count[8],
        lists,
        array_at(reals, at + 9 * meshes, (points, 3)),
    )
    population = ShapeArguments(shape_codes, first[4], solids)
    return law, population, (first[6], first[7], first[8])


@no_refcount_kernel
def _sort_by_shape(shape_codes, grain, order, starts):
    """Write the rows of the particles by the row of their shape, and where each shape begins."""
    shapes = shape_codes.size
    for row in range(shapes + 1):
        starts[row] = 0
    for row in range(shapes):
        for i in range(grain.shape[0]):
            starts[row + 1] += int(grain[i, 0] == shape_codes[row])
        starts[row + 1] += starts[row]
    for row in range(shapes):
        place = starts[row]
        for i in range(grain.shape[0]):
            if grain[i, 0] == shape_codes[row]:
                order[place] = i
                place += 1


def simulate_rows(
    reals, integers, n, alpha1, speed, spin, inertia, grain, index, hit, seed, values, codes
):
    """Simulate one impact of each of n particles, WIDTH at a time.

    All arguments but ``n`` and ``seed`` are addresses of arrays: the packed model, the fields of
    `Rows`, and what is written: ``values`` (n, RESULTS) as in `tablegen.model.lockstep`, and
    ``codes`` (n,) int32. A particle whose rebound does not end has a code and no values.
    """
    law, population, numerics = _unpack_model(reals, integers)
    rows = Rows(
        array_at(alpha1, 0, (n,)),
        array_at(speed, 0, (n,)),
        array_at(spin, 0, (n, 3)),
        array_at(inertia, 0, (n,)),
        array_at(grain, 0, (n, 3)),
        array_at(index, 0, (n,)),
        array_at(hit, 0, (n,)),
        seed,
    )
    prepared, order = stack_array((n, PREPARED)), stack_integers((n,))
    starts = stack_integers((population.shape_codes.size + 1,))
    slots = LaneSlots(
        stack_array((MOTION_SIZE, WIDTH)),
        stack_array((9, ORDER + 1, WIDTH)),
        stack_array((PROPERTIES, WIDTH)),
        stack_array((CONDITION_SIZE, WIDTH)),
        stack_array((max(MAX_VERTICES, population.meshes.longest), 3, WIDTH)),
        stack_integers((WIDTH,)),
        stack_array((3, WIDTH)),
        stack_array((RESULTS, WIDTH)),
        stack_integers((WIDTH,)),
    )
    outcome = Outcome(array_at(values, 0, (n, RESULTS)), array_at(codes, 0, (n,)))
    prepare_particles(population, rows, prepared)
    _sort_by_shape(population.shape_codes, rows.grain, order, starts)
    for row in range(population.shape_codes.size):
        if starts[row] < starts[row + 1]:
            members = order[starts[row] : starts[row + 1]]
            code = population.shape_codes[row]
            follow_particles(
                law, population, numerics, rows, prepared, code, members, slots, outcome
            )
