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
from tablegen.model.frames import cross, dot, to_lab
from tablegen.model.impacts import allowed_angle, lab_condition, wall_condition
from tablegen.model.jit import (
    inline_kernel,
    no_refcount_inline_kernel,
    operation,
    user_kernel,
)
from tablegen.model.orientation import (
    free_turn,
    impact_frame,
    lab_quaternion,
    moments_of,
    rotation_status,
    to_body,
    turning_status,
)
from tablegen.model.particle_run import follow_one
from tablegen.model.random_particles import (
    GRAIN_NOT_USABLE,
    draw_grain,
    draw_orientation,
    grain_fits,
)
from tablegen.model.rebound import LEFT, MOTION_SIZE, U, V, W, present_spin
from tablegen.model.rotation import ORDER
from tablegen.model.shapes import MAX_VERTICES, SupportMap

#: Status code: still in contact after `tablegen.model.rebound.COLLISION_ALARM` collisions.
STILL_IN_CONTACT = -103

#: Parts of the work space: motion now and before, a contact point, the series of a flight, a count
#: of candidate vertices, and the vertices.
_POINT = 2 * MOTION_SIZE
_SERIES = _POINT + 3
_COUNT = _SERIES + 9 * (ORDER + 1)
_CANDIDATES = _COUNT + 1

#: Axes of the wall frame in itself.
_WALL = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


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


def _vector(name):
    def fits(given):
        return isinstance(given, types.BaseTuple) and len(given) == 3

    return _argument(name, fits, "a tuple of three numbers")


_velocity, _normal, _wall, _omega = map(_vector, ("velocity", "normal", "wall_velocity", "omega"))
_seed, _index, _hit = _key("seed"), _key("index"), _key("hit")
_out = _argument("out", _is_vector, "a writable float64 array of one dimension")
_orientation = _argument("orientation", _is_vector, "a writable float64 array of one dimension")
_work = _argument(
    "work",
    lambda given: _is_vector(given) and given.layout == "C",
    "a writable contiguous float64 array of one dimension",
)


class DirectArrays(NamedTuple):
    """Laws, particles and numerical parameters, for kernels; of `tablegen.DirectModel`.

    ``law``: `LawArguments`. ``population``: `PopulationArguments`. ``numerics``: resolution of
    contacts, tolerance of flights, and 0 where angular velocities are means over free tumbling, 1
    where they are those of an instant.
    """

    law: Any
    population: Any
    numerics: tuple[float, float, float]


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


@no_refcount_inline_kernel
def _turn_to_wall(quaternion, frame, keys, motion):
    """Write the wall axes in body axes of an orientation, drawn where it is zero; a status."""
    if quaternion == (0.0, 0.0, 0.0, 0.0):
        draw_orientation(keys[0], keys[1], keys[2], motion)
        return OK
    n, x = to_body(quaternion, frame[1]), to_body(quaternion, frame[0])
    for k in range(3):
        motion[3 + k], motion[6 + k] = n[k], x[k]
    return rotation_status(quaternion)


@user_kernel
def _follow(arrays, condition, grain, orientation, frame, keys, work, out):
    """Write the state and the orientation of a particle after its rebound; a status."""
    population, motion = arrays.population, work[:MOTION_SIZE]
    if not grain_fits(population, grain[0], grain[1], grain[2]):
        return GRAIN_NOT_USABLE
    quaternion = orientation[0], orientation[1], orientation[2], orientation[3]
    status = _turn_to_wall(quaternion, frame, keys, motion)
    if status != OK:
        return status
    kind = int(grain[0]), float(grain[1]), float(grain[2])
    storage = _storage(population, work)
    status, _, spin, _ = follow_one(
        arrays.law, population, condition, kind, motion, storage, work[:0]
    )
    if status != LEFT:
        return STILL_IN_CONTACT
    out[0], out[1], out[2] = motion[U], motion[V], motion[W]
    out[3], out[4], out[5] = spin
    n, x = (motion[3], motion[4], motion[5]), (motion[6], motion[7], motion[8])
    orientation[0], orientation[1], orientation[2], orientation[3] = lab_quaternion(n, x, frame)
    return OK


@no_refcount_inline_kernel
def _check_sizes(arrays, orientation, work, out):
    """Refuse arrays that are too short."""
    if out.size < 6:
        raise ValueError("out: got fewer than 6 numbers, allowed: shape (6,)")
    if orientation.size < 4:
        raise ValueError("orientation: got fewer than 4 numbers, allowed: shape (4,)")
    if work.size < work_size(arrays.population):
        raise ValueError("work: got too few numbers, allowed: the model's work_size or more")


@user_kernel
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


@user_kernel
def draw(arrays, alpha1, speed, spin, grain, orientation, seed, index, hit, work, out):
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
    orientation : float64 array, shape (4,), read and written
        Quaternion, scalar first, from body axes to the wall frame; `tumble` turns it between walls.
        Zeros: uniformly random by the keys, as of a particle that has not met a wall.
    seed, index, hit : int
        Keys of the random orientation.
    work : contiguous float64 array, shape (n,)
        Work space of at least ``work_size`` numbers of the model, one for each thread.
    out : float64 array, shape (6,), written
        u, v, w over V and omega_x, omega_y, omega_z times a/V, wall frame.

    Returns
    -------
    int
        `OK` (0), or a negative code, and nothing is written: those of `sampler.errors`,
        `TURNS_TOO_OFTEN` (-101), `GRAIN_NOT_USABLE` (-102), `STILL_IN_CONTACT` (-103),
        `OUT_OF_BOUNDS` (-104), `ORIENTATION_NOT_USABLE` (-105).

    Raises
    ------
    ValueError
        If `out` or `work` has too few numbers. Wrong types of keys and arrays are refused while
        the code that calls is compiled.
    """
    keys, space, out = _keys(seed, index, hit), _work(work), _out(out)
    turned = _orientation(orientation)
    _check_sizes(arrays, turned, space, out)
    cosine_sine = cosine_and_sine(allowed_angle(alpha1))
    status, condition = wall_condition(alpha1, cosine_sine, speed, spin, arrays.numerics)
    if status == OK:
        status = _follow(arrays, condition, grain, turned, _WALL, keys, space, out)
    return status


@user_kernel
def rebound(
    arrays,
    velocity,
    normal,
    half_size,
    wall_velocity,
    omega,
    grain,
    orientation,
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
        Largest half-size a of the particle, 1e-9 to 0.1 m.
    omega : tuple of three float
        Angular velocity before the impact, rad/s.
    grain, seed, index, hit, work
        As for `draw`.
    orientation
        As for `draw`, but from body axes to the lab.
    out : float64 array, shape (6,), written
        Velocity in m/s, then angular velocity in rad/s.

    Returns
    -------
    int
        As `draw`, and the codes of `sampler.numba.rebound`.

    Raises
    ------
    ValueError
        As `draw`.
    """
    keys, space, out = _keys(seed, index, hit), _work(work), _out(out)
    turned = _orientation(orientation)
    _check_sizes(arrays, turned, space, out)
    impact = _velocity(velocity), _normal(normal), half_size, _wall(wall_velocity)
    status, condition = lab_condition(impact, _omega(omega), keys, arrays.numerics)
    if status == OK:
        frame = impact_frame(impact, keys)
        status = _follow(arrays, condition, grain, turned, frame, keys, space, out)
    if status == OK:
        to_lab(impact, keys, out)
    return status


@user_kernel
def tumble(arrays, orientation, omega, grain, time, work):
    """Turn a particle between walls by free rotation; callable from compiled code.

    Parameters
    ----------
    arrays : DirectArrays
        `arrays` of a `tablegen.DirectModel`.
    orientation : float64 array, shape (4,), read and written
        Quaternion, scalar first, from body axes to the lab.
    omega : tuple of three float
        Angular velocity, as after `rebound`, rad/s.
    grain : tuple of three float
        Shape code, b/a and c/b.
    time : float
        Of the flight, s, 0 or more.
    work
        As for `draw`.

    Returns
    -------
    status : int
        `OK` (0), or a negative code as of `draw`, and nothing is written.
    omega : tuple of three float
        Angular velocity after the flight: the same, unless it is that of an instant.
    """
    population, space, turned = arrays.population, _work(work), _orientation(orientation)
    quaternion = turned[0], turned[1], turned[2], turned[3]
    status = turning_status(population, grain, omega, time, quaternion)
    if status != OK:
        return status, omega
    motion, series = space[:MOTION_SIZE], space[_SERIES:_COUNT].reshape(9, ORDER + 1)
    moments = moments_of(population, grain[0], grain[1], grain[2])
    spin = present_spin(moments, arrays.numerics[2], to_body(quaternion, omega))
    lab = to_body(quaternion, _WALL[1]), to_body(quaternion, _WALL[0])
    for k in range(3):
        motion[k], motion[3 + k], motion[6 + k] = spin[k], lab[0][k], lab[1][k]
    free_turn(moments, motion, series, time, arrays.numerics[1])
    n, x = (motion[3], motion[4], motion[5]), (motion[6], motion[7], motion[8])
    turned[0], turned[1], turned[2], turned[3] = lab_quaternion(n, x, _WALL)
    if arrays.numerics[2] > 0.0:
        w = motion[0], motion[1], motion[2]
        omega = dot(w, x), dot(w, n), dot(w, cross(x, n))
    return OK, omega
