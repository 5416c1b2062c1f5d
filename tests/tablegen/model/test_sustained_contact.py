"""Sustained contact: chains of small bounces against a body that never leaves the wall.

In the limit of vanishing bounces a plastic contact (a_nc = 0) neither rises nor sinks: the contact
point glides along the wall, v = h'(theta) omega with the support function h, until the normal force
falls to zero. Without resistance the energy is kept, so the end is known in closed form. The model
bounces instead, at the contact resolution or less, and must tend to this.
"""

import math

import numpy as np
import pytest
from motion_fixtures import PAIR, body_of, run_rebound

from tablegen.config.pairs import ConstantResistance, ConstantRestitution
from tablegen.simulation.simulate import make_condition

#: Half-sizes b and c of ellipsoids, and the principal axis along z.
BODIES = [((0.8, 0.6), 1), ((1.0, 0.3), 0), ((1.0, 0.02), 1), ((0.02, 0.02), 2), ((0.5, 0.25), 2)]

#: Contacts that keep nothing of their normal velocity and slide freely.
_NONE = {"law": "constant", "value": 0.0, "source": "a limit that is known"}
LAWS = {"restitution": ConstantRestitution(**_NONE), "resistance": ConstantResistance(**_NONE)}


def start_angle(p, q):
    """Angle of a section with half-sizes p and q at its first contact.

    Half way from lying flat to where h'' vanishes, tan^2 = q / p for p > q, which ends the glide on
    the other side.
    """
    flat = 0.0 if p > q else 0.5 * math.pi
    return flat + 0.5 * math.atan(math.sqrt(min(p, q) / max(p, q)))


def rotation_of(theta, axis):
    """Rotation, wall from body, that puts the section's first axis at ``theta`` from x."""
    rotation = np.zeros((3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rotation[:2, i] = math.cos(theta), math.sin(theta)
    rotation[:2, j] = -math.sin(theta), math.cos(theta)
    rotation[2, axis] = 1.0
    return rotation


def closed_form(p, q):
    """State (u, v, omega_z) after a glide from normal impact, for a section as of `start_angle`.

    The first collision leaves the part of the motion that is along the constraint,
    omega = -h' V / (J + h'^2); then (J + h'^2) omega^2 stays as it is. The glide ends where h' is
    largest, at h' = p - q for p > q.
    """
    theta = start_angle(p, q)
    sin, cos = math.sin(theta), math.cos(theta)
    first = (p * p - q * q) * sin * cos / math.hypot(p * sin, q * cos)
    last, j = -abs(p - q), 0.2 * (p * p + q * q)
    omega = -first / math.sqrt((j + first**2) * (j + last**2))
    return np.array([0.0, last * omega, omega])


@pytest.mark.parametrize("resolution", [1e-3, 1e-4])
@pytest.mark.parametrize(("sizes", "axis"), BODIES)
def test_a_glide_without_resistance_ends_in_its_closed_form(sizes, axis, resolution):
    section = [(1.0, *sizes)[(axis + k) % 3] for k in (1, 2)]
    condition = make_condition(0.5 * math.pi, 200.0, resolution=resolution)
    rotation = rotation_of(start_angle(*section), axis)
    law = PAIR.model_copy(update=LAWS).kernel_arguments()
    rebound = run_rebound(condition, body_of("ellipsoid", *sizes), rotation, law)
    # a real chain, the longer the finer the resolution, and an error of its order
    assert rebound.collisions > 0.1 / resolution
    expected = closed_form(*section)
    off = np.abs(rebound.state[[0, 1, 5]] - expected) / [1.0, 1.0, 1.0 + abs(expected[2])]
    assert off.max() < 0.2 * resolution
