"""Orientations of particles as quaternions in the lab frame, and how they turn in free flight.

A quaternion, scalar first, rotates vectors from body axes to the lab. Kernels follow a particle by
the wall axes n (normal) and x (along the tangential velocity) in body axes instead; the frame of an
impact, `tablegen.model.frames`, turns one into the other.
"""

import math

from sampler.errors import NOT_FINITE
from tablegen.model.frames import (
    combine,
    cross,
    dot,
    impact_frame,
    is_finite,
    item,
    keys_of_row,
    vector,
)
from tablegen.model.impacts import MANY_TURNS, TURNS_TOO_OFTEN
from tablegen.model.jit import inline_kernel, kernel, no_refcount_inline_kernel, no_refcount_kernel
from tablegen.model.model_bounds import MOST_TURNED
from tablegen.model.rebound import MOTION_SIZE, present_spin
from tablegen.model.rotation import ORDER, evaluate, expand, series_span
from tablegen.model.shapes import FIRST_MESH, inertia
from tablegen.model.simd import (
    WIDTH,
    any_lane,
    lane_array,
    load,
    load_three,
    maximum,
    minimum,
    select,
    select_three,
    sqrt,
    store_three,
)

#: Status code: a quaternion that is no rotation.
ORIENTATION_NOT_USABLE = -105


@inline_kernel
def rotation_status(quaternion):
    """Tell whether a quaternion, of any length but zero, is a rotation: 0 or a code."""
    a, b, c, d = quaternion
    square = a * a + b * b + c * c + d * d
    return 0 if 1e-200 < square < 1e200 else ORIENTATION_NOT_USABLE


@inline_kernel
def to_body(quaternion, v):
    """Components in body axes of a vector in the lab."""
    a, b, c, d = quaternion
    scale = 2.0 / (a * a + b * b + c * c + d * d)
    axis = -b, -c, -d
    first = cross(axis, v)
    return combine(1.0, combine(1.0, v, a * scale, first), scale, cross(axis, first))


@inline_kernel
def quaternion_of(x, y, z):
    """Quaternion, scalar first and not negative, of a body whose axes see lab axes as x, y, z.

    Each of the three is a lab axis in body axes, so a row of the rotation matrix. The largest of
    the four numbers is found first: the others follow from it without loss of digits.
    """
    trace = x[0] + y[1] + z[2]
    if trace >= max(x[0], y[1], z[2]):
        a, b, c, d = 1.0 + trace, z[1] - y[2], x[2] - z[0], y[0] - x[1]
    elif x[0] >= y[1] and x[0] >= z[2]:
        a, b, c, d = z[1] - y[2], 1.0 + x[0] - y[1] - z[2], x[1] + y[0], x[2] + z[0]
    elif y[1] >= z[2]:
        a, b, c, d = x[2] - z[0], x[1] + y[0], 1.0 - x[0] + y[1] - z[2], y[2] + z[1]
    else:
        a, b, c, d = y[0] - x[1], x[2] + z[0], y[2] + z[1], 1.0 - x[0] - y[1] + z[2]
    scale = math.copysign(1.0, a) / math.sqrt(a * a + b * b + c * c + d * d)
    return a * scale, b * scale, c * scale, d * scale


@inline_kernel
def _lab_quaternion(n, x, frame):
    """Quaternion of a particle that sees the wall axes n and x of a frame in body axes."""
    z = cross(x, n)
    e_x, e_y, e_z = frame
    lab_x = combine(1.0, combine(e_x[0], x, e_y[0], n), e_z[0], z)
    lab_y = combine(1.0, combine(e_x[1], x, e_y[1], n), e_z[1], z)
    lab_z = combine(1.0, combine(e_x[2], x, e_y[2], n), e_z[2], z)
    return quaternion_of(lab_x, lab_y, lab_z)


@no_refcount_inline_kernel
def _frame_of_row(impacts, keys, row):
    """Axes of the impact in a row."""
    velocity, normal, _, wall_velocity = impacts
    relative = combine(1.0, vector(velocity, row), -1.0, vector(wall_velocity, row))
    return impact_frame(relative, vector(normal, row), keys_of_row(keys, row))


@no_refcount_inline_kernel
def _quaternion(values, row):
    row = row if values.shape[0] > 1 else 0
    return values[row, 0], values[row, 1], values[row, 2], values[row, 3]


@no_refcount_kernel
def axes_from(orientation, impacts, keys, axes):
    """Write wall axes in body axes, (n, 6).

    ``orientation`` (n, 4) or (1, 4), ``impacts`` and ``keys`` as of
    `tablegen.model.impacts.lab_conditions`. Returns the first bad row, or -1, and its code.
    """
    for k in range(axes.shape[0]):
        quaternion = _quaternion(orientation, k)
        status = rotation_status(quaternion)
        if status != 0:
            return k, status
        e_x, e_y, _ = _frame_of_row(impacts, keys, k)
        n, x = to_body(quaternion, e_y), to_body(quaternion, e_x)
        for i in range(3):
            axes[k, i], axes[k, 3 + i] = n[i], x[i]
    return -1, 0


@no_refcount_kernel
def orientations_from(axes, impacts, keys, orientation):
    """Write the quaternions, (n, 4), of particles with wall axes (n, 6) in body axes."""
    for k in range(axes.shape[0]):
        n, x = (axes[k, 0], axes[k, 1], axes[k, 2]), (axes[k, 3], axes[k, 4], axes[k, 5])
        quaternion = _lab_quaternion(n, x, _frame_of_row(impacts, keys, k))
        for i in range(4):
            orientation[k, i] = quaternion[i]


@no_refcount_kernel
def free_turn(moments, motion, series, time, tolerance):
    """Turn the axes and the angular velocity of ``motion`` (13,) by free rotation over a time.

    ``series`` (9, ORDER + 1) is work space. The tolerance of flights shrinks with many turns. Lanes
    that have arrived stay as they are, so that none depends on the others.
    """
    w = load_three(motion, 0)
    rate = sqrt(dot(w, w))
    # in units of 1 / rate powers of any angular velocity are numbers
    scale = select(rate > 0.0, rate, 1.0)
    store_three(motion, 0, (w[0] / scale, w[1] / scale, w[2] / scale))
    left = rate * time
    tolerance = tolerance / maximum(left / MANY_TURNS, 1.0)
    going = left > 0.0
    while any_lane(going):
        expand(moments, motion, series)
        span = select(going, minimum(series_span(series, tolerance), left), 0.0)
        w, n, x = load_three(motion, 0), load_three(motion, 3), load_three(motion, 6)
        evaluate(moments, series, span, motion)
        store_three(motion, 0, select_three(going, load_three(motion, 0), w))
        store_three(motion, 3, select_three(going, load_three(motion, 3), n))
        store_three(motion, 6, select_three(going, load_three(motion, 6), x))
        left = left - span
        going = left > 0.0
    w = load_three(motion, 0)
    store_three(motion, 0, (w[0] * scale, w[1] * scale, w[2] * scale))


@no_refcount_inline_kernel
def _moments_of(population, shape, b_over_a, c_over_b):
    """Principal moments of inertia of a grain, over m a^2."""
    if shape >= FIRST_MESH:
        moments = population.meshes.moments
        mesh = int(shape) - FIRST_MESH
        return moments[mesh, 0], moments[mesh, 1], moments[mesh, 2]
    return inertia(int(shape), b_over_a, b_over_a * c_over_b, population.truncation)


@kernel
def tumble_all(population, numerics, grain, omega, time, orientation):
    """Turn particles by free rotation, WIDTH at a time.

    ``numerics`` as of `tablegen.model.impacts.impact_condition`; ``grain`` (n, 3) or (1, 3): shape
    code, b / a, c / b, of the population; ``time`` (n,) or (1,). Quaternions, ``orientation``
    (n, 4), are read and written, and so is ``omega`` (n, 3) where it is that of an instant. Returns
    the first row that cannot be turned, or -1, and its code.
    """
    motion, moments = lane_array(MOTION_SIZE), lane_array(3)
    series, times = lane_array(9 * (ORDER + 1)).reshape(9, ORDER + 1, WIDTH), lane_array(1)
    instant = numerics[2]
    for start in range(0, orientation.shape[0], WIDTH):
        count = min(WIDTH, orientation.shape[0] - start)
        for i in range(WIDTH):
            row = start + min(i, count - 1)
            turning = vector(omega, row), item(time, row), _quaternion(orientation, row)
            status = _turning_status(*turning)
            if status != 0:
                return row, status
            _put_turning(
                population, vector(grain, row), omega, orientation, row, motion, moments, i
            )
            times[0, i] = item(time, row)
        own = load_three(moments, 0)
        store_three(motion, 0, present_spin(own, instant, load_three(motion, 0)))
        free_turn(own, motion, series, load(times, 0), numerics[1])
        for i in range(count):
            _take_turned(motion, i, start + i, instant, omega, orientation)
    return -1, 0


@no_refcount_inline_kernel
def _turning_status(omega, time, quaternion):
    """Tell whether a particle can be turned by free rotation over a time: 0 or a code."""
    if not (is_finite(omega) and math.isfinite(time)):
        return NOT_FINITE
    if time < 0.0 or not math.sqrt(dot(omega, omega)) * time <= MOST_TURNED:
        return TURNS_TOO_OFTEN
    return rotation_status(quaternion)


@no_refcount_inline_kernel
def _put_turning(population, grain, omega, orientation, row, motion, moments, lane):
    """Put a particle into a lane: lab axes y and x, and the angular velocity, in body axes."""
    quaternion = _quaternion(orientation, row)
    n, x = to_body(quaternion, (0.0, 1.0, 0.0)), to_body(quaternion, (1.0, 0.0, 0.0))
    w, own = to_body(quaternion, vector(omega, row)), _moments_of(population, *grain)
    for k in range(3):
        motion[k, lane], motion[3 + k, lane], motion[6 + k, lane] = w[k], n[k], x[k]
        moments[k, lane] = own[k]


@no_refcount_inline_kernel
def _take_turned(motion, lane, row, instant, omega, orientation):
    """Write the orientation of a lane to a row, and its angular velocity if that is of now."""
    w = motion[0, lane], motion[1, lane], motion[2, lane]
    n = motion[3, lane], motion[4, lane], motion[5, lane]
    x = motion[6, lane], motion[7, lane], motion[8, lane]
    quaternion = quaternion_of(x, n, cross(x, n))
    for k in range(4):
        orientation[row, k] = quaternion[k]
    if instant > 0.0:
        omega[row, 0], omega[row, 1], omega[row, 2] = dot(w, x), dot(w, n), dot(w, cross(x, n))
