"""A rebound by direct simulation, for the user's own compiled code.

The kernels count no references and return numbers only, so any compiled function may call them.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.core.errors import TypingError
from numba.core.imputils import impl_ret_borrowed

from sampler.errors import OK
from tablegen.model.elementary import cosine_and_sine
from tablegen.model.frames import to_lab
from tablegen.model.impacts import allowed_angle, lab_condition, wall_condition
from tablegen.model.jit import (
    inline_kernel,
    no_refcount_inline_kernel,
    no_refcount_kernel,
    operation,
)
from tablegen.model.particle_run import follow_one
from tablegen.model.random_particles import draw_grain, draw_orientation, grain_fits
from tablegen.model.rebound import LEFT, MOTION_SIZE, U, V, W, wall_spin
from tablegen.model.rotation import ORDER
from tablegen.model.shapes import MAX_VERTICES, SupportMap

#: Status code: shape code or ratios that are those of no grain.
GRAIN_NOT_USABLE = -102

#: Status code: still in contact after `tablegen.model.rebound.COLLISION_ALARM` collisions.
STILL_IN_CONTACT = -103

#: Parts of the work space: motion now and before, a contact point, the series of a flight, a count
#: of candidate vertices, and the vertices.
_POINT = 2 * MOTION_SIZE
_SERIES = _POINT + 3
_COUNT = _SERIES + 9 * (ORDER + 1)
_CANDIDATES = _COUNT + 1


def _argument(name, fits, allowed):
    """Make a function of kernels that returns its argument, and compiles only for allowed types."""

    @operation
    def checked(typingctx, value):
        if not fits(value):
            raise TypingError(f"{name}: got {value}, allowed: {allowed}")

        def generate(context, builder, sig, args):
            return impl_ret_borrowed(context, builder, sig.return_type, args[0])

        return value(value), generate

    return checked


def _key(name):
    return _argument(name, lambda given: isinstance(given, types.Integer), "an integer")


def _is_vector(given):
    plain = isinstance(given, types.Array) and given.ndim == 1 and given.mutable
    return plain and given.dtype == types.float64


_seed, _index, _hit = _key("seed"), _key("index"), _key("hit")
_out = _argument("out", _is_vector, "a writable float64 array of one dimension")
_work = _argument(
    "work",
    lambda given: _is_vector(given) and given.layout == "C",
    "a writable contiguous float64 array of one dimension",
)


class DirectArrays(NamedTuple):
    """Laws, particles and numerical parameters, for kernels; of `tablegen.DirectModel`.

    ``law``: `LawArguments`. ``population``: `PopulationArguments`. ``numerics``: resolution of
    contacts and tolerance of flights.
    """

    law: Any
    population: Any
    numerics: tuple[float, float]


@inline_kernel
def work_size(population):
    """Numbers of the work space that a rebound of a particle of the population needs."""
    return _CANDIDATES + 3 * max(MAX_VERTICES, population.meshes.longest)


@no_refcount_inline_kernel
def _storage(population, work):
    """Arrays that `follow_one` works in."""
    before, point = work[MOTION_SIZE:_POINT], work[_POINT:_SERIES]
    series = work[_SERIES:_COUNT].reshape(9, ORDER + 1)
    count = work[_COUNT:_CANDIDATES].view(np.int64)
    candidates = work[_CANDIDATES : work_size(population)].reshape(-1, 3)
    meshes = population.meshes
    no_map = SupportMap(0, math.inf, meshes.starts[:0], meshes.points[:0])
    return candidates, count, no_map, (series, point, before)


@inline_kernel
def _keys(seed, index, hit):
    """Keys in their own types, whatever integers they are given as."""
    return np.uint64(_seed(seed)), np.uint64(_index(index)), np.uint32(_hit(hit))


@no_refcount_kernel
def _follow(arrays, condition, grain, keys, work, out):
    """Write the state of a particle after its rebound; a status."""
    population, motion = arrays.population, work[:MOTION_SIZE]
    if not grain_fits(population, grain[0], grain[1], grain[2]):
        return GRAIN_NOT_USABLE
    draw_orientation(keys[0], keys[1], keys[2], motion)
    kind = int(grain[0]), float(grain[1]), float(grain[2])
    storage = _storage(population, work)
    status, _, _ = follow_one(arrays.law, population, condition, kind, motion, storage, work[:0])
    if status != LEFT:
        return STILL_IN_CONTACT
    out[0], out[1], out[2] = motion[U], motion[V], motion[W]
    out[3], out[4], out[5] = wall_spin(motion)
    return OK


@no_refcount_inline_kernel
def _check_sizes(arrays, work, out):
    """Refuse arrays that are too short."""
    if out.size < 6:
        raise ValueError("out: got fewer than 6 numbers, allowed: shape (6,)")
    if work.size < work_size(arrays.population):
        raise ValueError("work: got too few numbers, allowed: the model's work_size or more")


@no_refcount_kernel
def grain(arrays, seed, index, hit):
    """Draw the grain of a particle; callable from the user's own compiled code.

    Parameters
    ----------
    arrays : DirectArrays
        `arrays` of a `tablegen.DirectModel`.
    seed, index, hit : int
        Keys of the random numbers. With ``hit`` 0 at every hit, the grain is the particle's own.

    Returns
    -------
    tuple of three float
        Shape code (`sampler.formats.shape_codes`; FIRST_MESH + k of `tablegen.model.shapes` for the
        mesh number k of the population), b/a and c/b.
    """
    seed, index, hit = _keys(seed, index, hit)
    return draw_grain(arrays.population, seed, index, hit)


@no_refcount_kernel
def draw(arrays, alpha1, speed, spin, grain, seed, index, hit, work, out):
    """State of one particle after its rebound; callable from the user's own compiled code.

    Parameters
    ----------
    arrays : DirectArrays
        `arrays` of a `tablegen.DirectModel`.
    alpha1 : float
        Impact angle from the wall, rad.
    speed : float
        Impact speed, m/s.
    spin : tuple of three float
        Angular velocity before the impact times a/V, wall frame.
    grain : tuple of three float
        Shape code, b/a and c/b, for example from `grain`.
    seed, index, hit : int
        Keys of the random orientation.
    work : contiguous float64 array, shape (n,)
        Work space of at least ``work_size`` numbers of the model, one for each thread.
    out : float64 array, shape (6,), written
        u, v, w over V and omega_x, omega_y, omega_z times a/V, wall frame.

    Returns
    -------
    int
        `OK` (0), or a negative code, and nothing is written: those of `sampler.draw`,
        `TURNS_TOO_OFTEN` (-101), `GRAIN_NOT_USABLE` (-102), `STILL_IN_CONTACT` (-103),
        `OUT_OF_BOUNDS` (-104).

    Raises
    ------
    ValueError
        If `out` or `work` has too few numbers. Wrong types of keys and arrays are refused while
        the code that calls is compiled.
    """
    keys, space, out = _keys(seed, index, hit), _work(work), _out(out)
    _check_sizes(arrays, space, out)
    cosine_sine = cosine_and_sine(allowed_angle(alpha1))
    status, condition = wall_condition(alpha1, cosine_sine, speed, spin, arrays.numerics)
    if status == OK:
        status = _follow(arrays, condition, grain, keys, space, out)
    return status


@no_refcount_kernel
def rebound(
    arrays,
    velocity,
    normal,
    half_size,
    wall_velocity,
    omega,
    grain,
    seed,
    index,
    hit,
    work,
    out,
):
    """Rebound of one particle in the lab frame; callable from the user's own compiled code.

    Parameters
    ----------
    arrays : DirectArrays
        `arrays` of a `tablegen.DirectModel`.
    velocity, wall_velocity : tuple of three float
        Velocities of the particle and of the wall at the contact, m/s.
    normal : tuple of three float
        From the wall into the gas, any length but zero.
    half_size : float
        Largest half-size a of the particle, m.
    omega : tuple of three float
        Angular velocity before the impact, rad/s.
    grain, seed, index, hit, work
        As for `draw`.
    out : float64 array, shape (6,), written
        Velocity in m/s, then angular velocity in rad/s.

    Returns
    -------
    int
        As `draw`, and the codes of `sampler.rebound`.

    Raises
    ------
    ValueError
        As `draw`.
    """
    keys, space, out = _keys(seed, index, hit), _work(work), _out(out)
    _check_sizes(arrays, space, out)
    impact = velocity, normal, half_size, wall_velocity
    status, condition = lab_condition(impact, omega, keys, arrays.numerics)
    if status == OK:
        status = _follow(arrays, condition, grain, keys, space, out)
    if status == OK:
        to_lab(impact, keys, out)
    return status
