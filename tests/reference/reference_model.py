"""The direct model, written to be read: the reference for tests of the fast model.

Rigid particles rebound from a wall (Panfilov & Tsirkunov 2022; equation numbers are theirs). Of
`tablegen.model` this file uses only the decorator that compiles functions; it shares none of the
physics. Where that model is clever, this one is plain:

    here                                          tablegen.model
    vectors in wall axes at a collision           body axes, unrolled
    bisection of the scalar equation              Newton on a cubic
    Runge-Kutta 4, steps of 0.04 rad              Taylor series of high order
    contact seen at the end of a step, bisected   steps that cannot jump over a contact

So a dip below the wall that begins and ends within one step is missed here: it is at most
step^2 / 8 = 2e-4 of the reach deep. A shorter step makes such particles rarer.

Units: lengths in a, velocities in the impact speed V, angular velocities in V / a, mass one.
Wall axes are x, y, z with y the wall normal; body axes are the principal axes. Vectors are tuples
of three floats.
"""

import math
from typing import NamedTuple

import numpy as np

from tablegen.model.jit import kernel

Vector = tuple[float, float, float]

#: Shape codes of the output files.
SHAPES = {"ellipsoid": 0, "prism": 1, "truncated-prism": 2, "tetrahedron": 3, "sphere": 4}
ELLIPSOID, PRISM, TRUNCATED_PRISM, TETRAHEDRON, SPHERE = range(5)

#: A particle touches when its lowest point is this far below the wall: above rounding, far below
#: every length of the problem.
CONTACT_DEPTH = 1e-12

#: Height over the reach at which the state is taken, as in the model that this one checks.
CLEARANCE = 0.006

#: Uncertainty of the instant of a contact.
TIME_RESOLUTION = 1e-13


class Law(NamedTuple):
    """Coefficient and exponent of the restitution law (6), strength of the resistance law (7)."""

    coefficient: float = 0.1
    exponent: float = 0.61
    strength: float = 1.0


class Setup(NamedTuple):
    """Impact condition and numerical parameters.

    Impact angle [rad], impact speed [m/s], mean angular velocity over the tumbling before the
    impact in wall axes, smallest rebound speed of a contact point over V, Runge-Kutta step [rad].
    """

    alpha1: float
    speed: float
    spin: Vector = (0.0, 0.0, 0.0)
    resolution: float = 1e-3
    step: float = 0.04


class Particle(NamedTuple):
    """Half-sizes, vertices (m, 3), none for an ellipsoid, principal moments, reach."""

    sizes: Vector
    vertices: np.ndarray
    moments: Vector
    reach: float


class Turn(NamedTuple):
    """Rotational state in body axes: the angular velocity and the wall axes x, y, z."""

    spin: Vector
    x: Vector
    y: Vector
    z: Vector


# --- Vectors and frames ---


@kernel
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def norm(a):
    return math.sqrt(dot(a, a))


@kernel
def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def along(a, t, b):
    """a + t b."""
    return (a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2])


@kernel
def times(a, b):
    """Products of the components."""
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


@kernel
def over(a, b):
    """Quotients of the components."""
    return (a[0] / b[0], a[1] / b[1], a[2] / b[2])


@kernel
def to_wall(turn, vector):
    """Wall components of a vector given in body axes."""
    return (dot(turn.x, vector), dot(turn.y, vector), dot(turn.z, vector))


@kernel
def to_body(turn, vector):
    """Body components of a vector given in wall axes."""
    zero = (0.0, 0.0, 0.0)
    return along(along(along(zero, vector[0], turn.x), vector[1], turn.y), vector[2], turn.z)


# --- Shapes ---


@kernel
def make_vertices(shape, sizes, truncation):
    """Corners of the box, of the box with its corners cut off, or every second one of the box."""
    corners = []
    for x in (1.0, -1.0):
        for y in (1.0, -1.0):
            for z in (1.0, -1.0):
                if shape == PRISM or (shape == TETRAHEDRON and x * y * z > 0.0):
                    corners.append((x, y, z))
                elif shape == TRUNCATED_PRISM:
                    left = 1.0 - truncation
                    corners.append((left * x, y, z))
                    corners.append((x, left * y, z))
                    corners.append((x, y, left * z))
    vertices = np.empty((len(corners), 3))
    for i in range(len(corners)):
        for axis in range(3):
            vertices[i, axis] = corners[i][axis] * sizes[axis]
    return vertices


@kernel
def second_moment(shape, truncation):
    """<x^2> / a^2 over the volume; the same number gives <y^2> / b^2 and <z^2> / c^2."""
    if shape == PRISM:
        return 1.0 / 3.0
    if shape == TRUNCATED_PRISM:
        # the box less its corners: each a tetrahedron with edges of f half-edges
        f = truncation
        corner = (3.0 + (1.0 - f) ** 2 + (4.0 - f) ** 2) / 20.0
        return (1.0 / 3.0 - f**3 * corner / 6.0) / (1.0 - f**3 / 6.0)
    return 1.0 / 5.0


@kernel
def make_particle(shape, b_over_a, c_over_b, truncation):
    """Particle of a shape with half-sizes 1, b / a and c / a."""
    sizes = (1.0, b_over_a, b_over_a * c_over_b)
    vertices = make_vertices(shape, sizes, truncation)
    q = second_moment(shape, truncation)
    xx, yy, zz = q * sizes[0] ** 2, q * sizes[1] ** 2, q * sizes[2] ** 2
    reach = 1.0
    for i in range(len(vertices)):
        reach = max(reach, norm(vertices[i]))
    return Particle(sizes, vertices, (yy + zz, zz + xx, xx + yy), reach)


@kernel
def lowest_point(particle, normal):
    """Point of the particle that lies lowest when the wall normal is ``normal``; body axes."""
    vertices = particle.vertices
    if len(vertices) == 0:
        stretched = times(particle.sizes, normal)
        length = -norm(stretched)
        return over(times(particle.sizes, stretched), (length, length, length))
    lowest = 0
    for i in range(1, len(vertices)):
        if dot(vertices[i], normal) < dot(vertices[lowest], normal):
            lowest = i
    return (vertices[lowest, 0], vertices[lowest, 1], vertices[lowest, 2])


@kernel
def gap(particle, turn, height):
    """Height of the lowest point over the wall, for a centre at ``height``."""
    return height + dot(lowest_point(particle, turn.y), turn.y)


# --- One collision ---


@kernel
def response(particle, turn, arm, impulse):
    """Change of the contact velocity by an impulse at the contact, (3) and (4): A impulse."""
    spin = to_wall(turn, over(to_body(turn, cross(arm, impulse)), particle.moments))
    return along(cross(spin, arm), 1.0, impulse)


@kernel
def mobility(particle, turn, arm):
    """Matrix A of dV_c = A dV_p by its columns, which are its rows: it is symmetric."""
    return (
        response(particle, turn, arm, (1.0, 0.0, 0.0)),
        response(particle, turn, arm, (0.0, 1.0, 0.0)),
        response(particle, turn, arm, (0.0, 0.0, 1.0)),
    )


@kernel
def impulse_for(s, k, matrix, u_c, w_c):
    """Impulse whose normal part is s: the tangential equations of (5) are linear, solve them.

    (I + k s A_tt / 2) S_t = -k s (V_t + A_tn s / 2), by Cramer's rule.
    """
    row_x, _, row_z = matrix
    m11 = 1.0 + 0.5 * k * s * row_x[0]
    m12 = 0.5 * k * s * row_x[2]
    m22 = 1.0 + 0.5 * k * s * row_z[2]
    right1 = -k * s * (u_c + 0.5 * s * row_x[1])
    right2 = -k * s * (w_c + 0.5 * s * row_z[1])
    determinant = m11 * m22 - m12 * m12
    s_x = (m22 * right1 - m12 * right2) / determinant
    s_z = (m11 * right2 - m12 * right1) / determinant
    return (s_x, s, s_z)


@kernel
def solve_impulse(k, jump, matrix, u_c, w_c):
    """Impulse that changes the normal contact velocity by ``jump``: f(s) = 0 by bisection.

    f(s) = A_nn s + A_nt . S_t(s) - jump is negative at 0 and grows without bound.
    """
    low, high = 0.0, jump
    while dot(matrix[1], impulse_for(high, k, matrix, u_c, w_c)) < jump:
        high *= 2.0
    while True:
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            return impulse_for(high, k, matrix, u_c, w_c)
        if dot(matrix[1], impulse_for(middle, k, matrix, u_c, w_c)) < jump:
            low = middle
        else:
            high = middle


@kernel
def collide(law, setup, particle, turn, velocity, point):
    """Velocity and ``turn`` after a collision at ``point`` (body axes)."""
    arm = to_wall(turn, point)
    contact = along(velocity, 1.0, cross(to_wall(turn, turn.spin), arm))  # (2)
    size, fall = norm(contact), -contact[1]
    # (6), the speed in m/s
    loss = 1.0 - math.exp(-law.coefficient * (setup.speed * size) ** law.exponent)
    bounce = (1.0 - loss * fall / size) * fall
    # (7), with the velocity before this collision
    c_f = math.exp(law.strength * dot(arm, velocity) / (norm(arm) * norm(velocity)))
    k = c_f / size
    matrix = mobility(particle, turn, arm)
    jump = max(bounce, setup.resolution) + fall
    impulse = solve_impulse(k, jump, matrix, contact[0], contact[2])
    # energy change: S . (V_c + dV_c / 2)
    change = response(particle, turn, arm, impulse)
    if bounce < setup.resolution and dot(impulse, along(contact, 0.5, change)) > 0.0:
        # a nearly rolling contact has not the energy for it; then the bounce is elastic
        impulse = solve_impulse(k, 2.0 * fall, matrix, contact[0], contact[2])
    kick = over(to_body(turn, cross(arm, impulse)), particle.moments)
    spin = along(turn.spin, 1.0, kick)
    return along(velocity, 1.0, impulse), Turn(spin, turn.x, turn.y, turn.z)


# --- Free flight ---


@kernel
def turning_rate(moments, turn):
    """Time derivative of ``turn``: Euler's equations, and axes that rest in space."""
    spin = turn.spin
    torque = cross(times(moments, spin), spin)
    return Turn(
        over(torque, moments), cross(turn.x, spin), cross(turn.y, spin), cross(turn.z, spin)
    )


@kernel
def advanced(turn, dt, rate):
    return Turn(
        along(turn.spin, dt, rate.spin),
        along(turn.x, dt, rate.x),
        along(turn.y, dt, rate.y),
        along(turn.z, dt, rate.z),
    )


@kernel
def turned(moments, turn, dt):
    """``turn`` a time ``dt`` later, by one classical Runge-Kutta step."""
    k1 = turning_rate(moments, turn)
    k2 = turning_rate(moments, advanced(turn, 0.5 * dt, k1))
    k3 = turning_rate(moments, advanced(turn, 0.5 * dt, k2))
    k4 = turning_rate(moments, advanced(turn, dt, k3))
    ends = advanced(advanced(turn, dt / 6.0, k1), dt / 6.0, k4)
    return advanced(advanced(ends, dt / 3.0, k2), dt / 3.0, k3)


@kernel
def contact_time(particle, turn, height, v, dt):
    """Instant within (0, dt) at which the gap falls below -CONTACT_DEPTH, by bisection."""
    low, high = 0.0, dt
    while high - low > TIME_RESOLUTION:
        middle = 0.5 * (low + high)
        later = turned(particle.moments, turn, middle)
        if gap(particle, later, height + v * middle) < -CONTACT_DEPTH:
            high = middle
        else:
            low = middle
    return high


@kernel
def fly(particle, step, turn, height, v):
    """Fly to the next contact, or until the centre is clear of the wall: CLEARANCE above the reach.

    The last step is shortened so that it ends there: the centre flies straight, so the instant
    is known, and with it the angular velocity of the state. Returns whether the particle touches,
    and ``turn``.
    """
    rate = norm(turn.spin)
    if rate == 0.0 and v < 0.0:
        return True, turn  # falls without turning
    while True:
        dt = step / rate if rate > 0.0 else math.inf
        leaves = v > 0.0 and (particle.reach + CLEARANCE - height) / v <= dt
        if leaves:
            dt = (particle.reach + CLEARANCE - height) / v
        later = turned(particle.moments, turn, dt)
        if gap(particle, later, height + v * dt) < -CONTACT_DEPTH:
            dt = contact_time(particle, turn, height, v, dt)
            return True, turned(particle.moments, turn, dt)
        if leaves:
            return False, later
        turn = later
        height += v * dt
        rate = norm(turn.spin)


# --- Whole rebounds ---


@kernel
def spin_now(moments, mean):
    """Angular velocity of the momentum L = k M, whose energy is k M^2 / 2, in body axes."""
    square = dot(mean, mean)
    if square == 0.0:
        return mean
    inertia = square / dot(mean, over(mean, moments))
    return over(times((inertia, inertia, inertia), mean), moments)


@kernel
def rebound(law, setup, particle, rotation, height):
    """State and number of collisions of one particle: (velocity, spin, collisions), wall axes.

    ``rotation`` (3, 3) takes body axes to wall axes, as the centre is at ``height``.
    """
    velocity = (math.cos(setup.alpha1), -math.sin(setup.alpha1), 0.0)
    x = (rotation[0, 0], rotation[0, 1], rotation[0, 2])
    y = (rotation[1, 0], rotation[1, 1], rotation[1, 2])
    z = (rotation[2, 0], rotation[2, 1], rotation[2, 2])
    turn = Turn(spin_now(particle.moments, to_body(Turn(x, x, y, z), setup.spin)), x, y, z)
    collisions = 0
    while True:
        touches, turn = fly(particle, setup.step, turn, height, velocity[1])
        if not touches:
            return velocity, to_wall(turn, turn.spin), collisions
        point = lowest_point(particle, turn.y)
        height = -dot(point, turn.y)
        velocity, turn = collide(law, setup, particle, turn, velocity, point)
        collisions += 1


@kernel
def rebounds(law, setup, shapes, ratios, rotations, heights, truncation):
    """States (n, 6) and numbers of collisions (n,) of many particles.

    ``shapes`` (n,) are codes of `SHAPES`, ``ratios`` (n, 2) b / a and c / b, ``rotations``
    (n, 3, 3) from body to wall axes as the centres are at ``heights`` (n,); ``truncation`` is the
    fraction of each half-edge at which a truncated prism is cut.
    """
    states = np.empty((len(shapes), 6))
    collisions = np.empty(len(shapes), dtype=np.int64)
    for i in range(len(shapes)):
        particle = make_particle(shapes[i], ratios[i, 0], ratios[i, 1], truncation)
        velocity, spin, collisions[i] = rebound(law, setup, particle, rotations[i], heights[i])
        for axis in range(3):
            states[i, axis], states[i, 3 + axis] = velocity[axis], spin[axis]
    return states, collisions
