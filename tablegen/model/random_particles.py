"""The orientations in which particles meet the wall, from counter-based random numbers.

A grain is given; `sampler/c/src/grains.h` draws it. Its orientation is a pure function of (seed,
index, hit). Words 2 and 3 of block 0 and word 0 of block 1 give three uniform numbers; the grain
takes the other words. If the grain tumbles, the numbers are its phases
(`tablegen.model.tumbling`), otherwise they give a uniform orientation
(`tablegen.model.rotation.set_orientation`).

The ratios are dimensionless; moments of inertia are over m a^2.
"""

from typing import NamedTuple

import numpy as np

from tablegen.model.elementary import cosine_and_sine
from tablegen.model.jit import no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.memory import stack_array
from tablegen.model.random_numbers import philox_block, uniform
from tablegen.model.rotation import set_orientation
from tablegen.model.shapes import FIRST_MESH, inertia
from tablegen.model.simd import WIDTH, load, store
from tablegen.model.tumbling import axes_of_tumbling, is_round

#: Combined with the seed, so that direct simulation uses other random numbers than a table's draw.
SIMULATION_KEY = np.uint64(0x5349_4D55_4C41_5445)

#: Columns of what is prepared for a particle: wall axes n and x in body axes, and the cosine and
#: the sine of the impact angle.
NORMAL, AXIS, COSINE, SINE, PREPARED = 0, 3, 6, 7, 8


class Rows(NamedTuple):
    """Impacts of n particles in wall axes, with their grains and keys.

    ``alpha1`` (n,) [rad], ``speed`` (n,) [m/s], ``spin`` (n, 3) times a / V, ``inertia`` (n,) about
    it over m a^2, 0 if it is not known, ``grain`` (n, 3): shape code, b / a and c / b, ``index``
    (n,) uint64, ``hit`` (n,) uint32, and ``seed`` uint64.
    """

    alpha1: np.ndarray
    speed: np.ndarray
    spin: np.ndarray
    inertia: np.ndarray
    grain: np.ndarray
    index: np.ndarray  # type: ignore[assignment]  # hides tuple.index
    hit: np.ndarray
    seed: np.uint64


@no_refcount_inline_kernel
def spin_of(rows, k):
    """Read the spin of a row."""
    return rows.spin[k, 0], rows.spin[k, 1], rows.spin[k, 2]


@no_refcount_inline_kernel
def _phases(rows, k):
    """Draw the three uniform numbers of the orientation of a row."""
    key, index, hit = rows.seed ^ SIMULATION_KEY, rows.index[k], rows.hit[k]
    _, _, u, v = philox_block(key, index, hit, np.uint32(0))
    w, _, _, _ = philox_block(key, index, hit, np.uint32(1))
    return uniform(u), uniform(v), uniform(w)


@no_refcount_inline_kernel
def moments_of(population, shape, b_over_a, c_over_b):
    """Compute the principal moments of inertia of a grain over m a^2, in rising order."""
    if shape >= FIRST_MESH:
        moments, mesh = population.meshes.moments, int(shape) - FIRST_MESH
        return moments[mesh, 0], moments[mesh, 1], moments[mesh, 2]
    return inertia(int(shape), b_over_a, b_over_a * c_over_b, population.truncation)


@no_refcount_kernel
def _tumble(population, rows, k, phases, prepared):
    """Orient a particle that arrives tumbling, if its spin and its inertia are known."""
    known, spin = rows.inertia[k], spin_of(rows, k)
    if known == 0.0 or spin == (0.0, 0.0, 0.0):
        return
    moments = moments_of(population, rows.grain[k, 0], rows.grain[k, 1], rows.grain[k, 2])
    if is_round(moments):
        return
    n, x = axes_of_tumbling(moments, known, spin, phases)
    for j in range(3):
        prepared[k, NORMAL + j], prepared[k, AXIS + j] = n[j], x[j]


@no_refcount_kernel
def prepare_particles(population, rows, prepared):
    """Orient particles, and compute cosine and sine of their impact angles.

    ``prepared`` (n, PREPARED) is written. The orientations are those of free tumbling with the spin
    and the inertia of the particles. They are uniform for particles without spin, or with an
    inertia that is not known, and for grains that are round.
    """
    count = prepared.shape[0]
    lanes, motion = stack_array((6, WIDTH)), stack_array((9, WIDTH))
    for start in range(0, count, WIDTH):
        for i in range(WIDTH):
            # lanes without a particle repeat the last one
            k = min(start + i, count - 1)
            lanes[0, i], lanes[1, i], lanes[2, i] = _phases(rows, k)
            lanes[3, i] = rows.alpha1[k]
        set_orientation(load(lanes, 0), load(lanes, 1), load(lanes, 2), motion)
        cosine, sine = cosine_and_sine(load(lanes, 3))
        store(lanes, 4, cosine)
        store(lanes, 5, sine)
        for i in range(min(WIDTH, count - start)):
            k = start + i
            for j in range(6):
                prepared[k, j] = motion[3 + j, i]
            prepared[k, COSINE], prepared[k, SINE] = lanes[4, i], lanes[5, i]
            _tumble(population, rows, k, (lanes[0, i], lanes[1, i], lanes[2, i]), prepared)
