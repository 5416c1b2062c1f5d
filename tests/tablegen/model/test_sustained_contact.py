"""Sustained contact: chains of small bounces against a body that never leaves the wall.

In the limit of vanishing bounces a plastic contact (a_nc = 0) neither rises nor sinks: the contact
point glides along the wall, v = h'(theta) omega with the support function h, under a normal force
N and a sliding resistance C_f N against its motion, until N falls to zero. Without resistance the
energy is kept, so the end is known in closed form; with it one ordinary differential equation is
left. The model bounces instead, at the contact resolution or less, and must tend to this.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from motion_fixtures import PAIR, body_of, run_rebound

from tablegen.config.pairs import ConstantResistance, ConstantRestitution
from tablegen.simulation.simulate import make_condition

#: Half-sizes b and c of ellipsoids, and the principal axis along z.
BODIES = [((0.8, 0.6), 1), ((1.0, 0.3), 0), ((1.0, 0.02), 1), ((0.02, 0.02), 2), ((0.5, 0.25), 2)]


def plastic_law(resistance):
    """Contacts that keep nothing of their normal velocity and resist sliding by C_f."""
    source = "a limit that is known"
    pair = PAIR.model_copy(
        update={
            "restitution": ConstantRestitution(law="constant", value=0.0, source=source),
            "resistance": ConstantResistance(law="constant", value=resistance, source=source),
        }
    )
    return pair.kernel_arguments()


class Section(NamedTuple):
    """Cross-section: half-sizes along its two principal axes, moment about z."""

    sizes: tuple[float, float]
    moment: float


def section_of(b, c, axis):
    """Section of an ellipsoid with half-sizes (1, b, c) across its principal ``axis``."""
    sizes = (1.0, b, c)
    p, q = sizes[(axis + 1) % 3], sizes[(axis + 2) % 3]
    return Section((p, q), 0.2 * (p * p + q * q))


def rotation_of(theta, axis):
    """Rotation, wall from body, that puts the section's first axis at ``theta`` from x."""
    rotation = np.zeros((3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rotation[:2, i] = math.cos(theta), math.sin(theta)
    rotation[:2, j] = -math.sin(theta), math.cos(theta)
    rotation[2, axis] = 1.0
    return rotation


def start_angle(section):
    """Angle of the section at its first contact.

    Half way from lying flat to where h'' vanishes, tan^2 = q / p for half-sizes p > q, which ends
    the glide on the other side.
    """
    p, q = section.sizes
    flat = 0.0 if p > q else 0.5 * math.pi
    return flat + 0.5 * math.atan(math.sqrt(min(p, q) / max(p, q)))


def slopes(section, theta):
    """Support function h and its derivatives h', h''."""
    p, q = section.sizes
    sin, cos = math.sin(theta), math.cos(theta)
    h = math.hypot(p * sin, q * cos)
    first = (p * p - q * q) * sin * cos / h
    second = ((p * p - q * q) * (cos * cos - sin * sin) - first * first) / h
    return h, first, second


def bounced(sizes, axis, alpha, resistance, resolution):
    """State (u, v, omega_z) and collisions of the model."""
    section = section_of(*sizes, axis)
    condition = make_condition(alpha, 200.0, resolution=resolution)
    rotation = rotation_of(start_angle(section), axis)
    made = run_rebound(condition, body_of("ellipsoid", *sizes), rotation, plastic_law(resistance))
    return made.state[[0, 1, 5]], made.collisions


def closed_form(section):
    """State after a glide without resistance from normal impact.

    The first collision leaves the part of the motion that is along the constraint,
    omega = -h' V / (J + h'^2); then (J + h'^2) omega^2 stays as it is. The glide ends where h' is
    largest, at h' = p - q for half-sizes p > q.
    """
    _, first, _ = slopes(section, start_angle(section))
    last = -abs(section.sizes[0] - section.sizes[1])
    j = section.moment
    omega = -first / math.sqrt((j + first**2) * (j + last**2))
    return np.array([0.0, last * omega, omega])


def miss(state, expected):
    """Largest error, relative to a spin that is large."""
    return np.max(np.abs(state - expected) / [1.0, 1.0, 1.0 + abs(expected[2])])


@pytest.mark.parametrize("resolution", [1e-3, 1e-4])
@pytest.mark.parametrize(("sizes", "axis"), BODIES)
def test_a_glide_without_resistance_ends_in_its_closed_form(sizes, axis, resolution):
    expected = closed_form(section_of(*sizes, axis))
    state, collisions = bounced(sizes, axis, 0.5 * math.pi, 0.0, resolution)
    # a real chain, the longer the finer the resolution, and an error of its order
    assert collisions > 0.1 / resolution
    assert miss(state, expected) < 0.2 * resolution
