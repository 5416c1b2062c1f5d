"""Direct simulation of long paths that keeps the orientation of a grain and lets it tumble.

It stands beside `DirectModel`, which keeps spin and inertia and draws the phases of the tumbling.
Grains bounce in a cylinder without gas, and their speed is set back after each hit.
"""

import numpy as np
from one_particle import LEFT, rebound, workspace

from tablegen.model.impacts import impact_condition
from tablegen.model.jit import kernel
from tablegen.model.rebound import U, V, W, departing_spin, place_before_impact
from tablegen.model.rotation import ORDER, advance_motion, expand_motion, series_span
from tablegen.model.vectors import combine, cross, dot, unit

#: Speed before each hit [m/s], and angle of the first [rad].
SPEED, FIRST = 50.0, np.radians(14.0)


@kernel
def impact_frame(velocity, normal):
    """Wall axes x, y and z of an impact that is not exactly normal."""
    e_x = unit(combine(1.0, velocity, -dot(velocity, normal), normal))
    e_x = unit(combine(1.0, e_x, -dot(e_x, normal), normal))
    return e_x, normal, cross(e_x, normal)


@kernel
def next_normal(velocity, normal):
    """Normal where a particle that leaves a cylinder about z at a point of it meets it again."""
    across = velocity[0], velocity[1], 0.0
    chord = 2.0 * dot(velocity, normal) / dot(across, across)
    return unit(combine(1.0, normal, -chord, across))


@kernel
def tumble(moments, motion, angle):
    """Turn ``motion`` freely, by an angle [rad] of its present rate."""
    series = np.empty((9, ORDER + 1))
    left = angle / np.sqrt(motion[0] ** 2 + motion[1] ** 2 + motion[2] ** 2)
    while left > 0.0:
        expand_motion(moments, motion, series)
        step = min(left, series_span(series, 1e-10))
        advance_motion(moments, series, step, motion)
        left -= step


@kernel
def turn_wall(motion, old, new):
    """Turn from one wall, whose axes are ``old``, to another: both axes in body axes, and spins."""
    n, x = (motion[3], motion[4], motion[5]), (motion[6], motion[7], motion[8])
    z = cross(x, n)
    for row, axis in ((3, new[1]), (6, new[0])):
        in_body = combine(dot(axis, old[0]), x, dot(axis, old[1]), n)
        in_body = combine(1.0, in_body, dot(axis, old[2]), z)
        for k in range(3):
            motion[row + k] = in_body[k]


@kernel
def kept_chain(law, body, numerics, motion, angles, energies):
    """Follow a grain for some hits: impact angles [rad], and shares of its energy that it keeps.

    ``motion`` holds its first orientation. ``angles`` (hits,) holds the angle [rad] by which it
    tumbles after each hit. Returns whether it has left every wall.
    """
    velocity = np.cos(FIRST), -np.sin(FIRST), 0.0
    normal, spin = (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)
    before = impact_frame(velocity, normal)
    for hit in range(len(angles)):
        turned = angles[hit]
        frame = impact_frame(velocity, normal)
        turn_wall(motion, before, frame)
        sine = min(-dot(velocity, frame[1]), 1.0)
        in_wall = dot(spin, frame[0]), dot(spin, frame[1]), dot(spin, frame[2])
        cosine = dot(velocity, frame[0])
        condition = impact_condition(cosine, sine, SPEED, in_wall, numerics)
        place_before_impact(condition, body, motion)
        status, _, _ = rebound(law, condition, body, motion, workspace(), np.zeros(0))
        if status != LEFT:
            return False
        u, v, w = motion[U], motion[V], motion[W]
        size = np.sqrt(u * u + v * v + w * w)
        angles[hit], energies[hit] = np.arcsin(sine), size * size
        m, _ = departing_spin(body.moments, 0.0, motion)
        spin = combine(m[0] / size, frame[0], m[1] / size, frame[1])
        spin = combine(1.0, spin, m[2] / size, frame[2])
        velocity = combine(u / size, frame[0], v / size, frame[1])
        velocity = unit(combine(1.0, velocity, w / size, frame[2]))
        normal, before = next_normal(velocity, normal), frame
        tumble(body.moments, motion, turned)
    return True
