"""Sustained contact: chains of small bounces against a body that never leaves the wall.

In the limit of vanishing bounces a plastic contact (a_nc = 0) neither rises nor sinks: the contact
point glides along the wall, v = h'(theta) omega with the support function h, under a normal force
N and a sliding resistance C_f N against its motion, until N falls to zero. Without resistance the
energy is kept, so the end is known in closed form; with it one ordinary differential equation is
left. The model bounces instead, at the contact resolution or less, and must tend to this.
"""

import math

import numpy as np
import planar_reference
import pytest
from motion_fixtures import PAIR, body_of, run_rebound
from planar_reference import impact, mobility, rotation_of_section, section_of
from scipy.integrate import solve_ivp

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
    section = section_of("ellipsoid", *sizes, axis)
    condition = make_condition(alpha, 200.0, resolution=resolution)
    rotation = rotation_of_section(start_angle(section), axis)
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


def glide(section, alpha, resistance):
    """State after a glide with resistance, by scipy's integrator."""
    theta = start_angle(section)
    start = impact(section, theta, alpha)
    r = section.lowest(theta)[0]
    matrix = mobility(section, r)
    size = math.hypot(start.u, start.v)
    s_x, s_y = planar_reference.solve(matrix, start.u, resistance / size, -start.v)
    omega = (r[0] * s_y - r[1] * s_x) / section.moment

    theta_of, u_of, omega_of = range(3)
    way = math.copysign(1.0, start.u + s_x + omega * slopes(section, theta)[0])

    def slide(y):
        return way * (y[u_of] + y[omega_of] * slopes(section, y[theta_of])[0])

    def rates(_, y):
        h, first, second = slopes(section, y[theta_of])
        lever = first + way * resistance * h
        load = second * y[omega_of] ** 2 / (1.0 + first * lever / section.moment)
        return [y[omega_of], -way * resistance * load, -load * lever / section.moment]

    def lifts(_, y):
        return slopes(section, y[theta_of])[2]

    def sticks(_, y):
        return slide(y)

    lifts.terminal = sticks.terminal = True
    path = solve_ivp(
        rates,
        (0.0, 100.0),
        [theta, start.u + s_x, omega],
        events=(lifts, sticks),
        rtol=1e-11,
        atol=1e-13,
    )
    # the load ended it, and the contact slid one way all along
    assert path.t_events[0].size == 1
    assert path.t_events[1].size == 0
    theta, u, omega = path.y[:, -1]
    return np.array([u, slopes(section, theta)[1] * omega, omega])


def miss(state, expected):
    """Largest error, relative to a spin that is large."""
    return np.max(np.abs(state - expected) / [1.0, 1.0, 1.0 + abs(expected[2])])


@pytest.mark.parametrize("resolution", [1e-3, 1e-4])
@pytest.mark.parametrize(("sizes", "axis"), BODIES)
def test_a_glide_without_resistance_ends_in_its_closed_form(sizes, axis, resolution):
    expected = closed_form(section_of("ellipsoid", *sizes, axis))
    state, collisions = bounced(sizes, axis, 0.5 * math.pi, 0.0, resolution)
    # a real chain, the longer the finer the resolution, and an error of its order
    assert collisions > 0.1 / resolution
    assert miss(state, expected) < 0.2 * resolution


@pytest.mark.parametrize("resolution", [1e-3, 1e-4])
@pytest.mark.parametrize("resistance", [0.1, 0.3])
@pytest.mark.parametrize(("sizes", "axis"), BODIES)
def test_a_glide_with_resistance_ends_as_its_equation_says(sizes, axis, resistance, resolution):
    alpha = math.radians(30.0)
    expected = glide(section_of("ellipsoid", *sizes, axis), alpha, resistance)
    state, collisions = bounced(sizes, axis, alpha, resistance, resolution)
    assert collisions > 0.1 / resolution
    assert miss(state, expected) < 0.8 * resolution


def test_the_two_truths_agree_where_nothing_resists():
    section = section_of("ellipsoid", 0.8, 0.6, 1)
    np.testing.assert_allclose(glide(section, 0.5 * math.pi, 0.0), closed_form(section), atol=1e-9)


def test_another_resistance_and_a_coarse_resolution_are_seen():
    (sizes, axis), alpha = BODIES[0], math.radians(30.0)
    expected = glide(section_of("ellipsoid", *sizes, axis), alpha, 0.3)
    assert miss(bounced(sizes, axis, alpha, 0.31, 1e-3)[0], expected) > 5e-3
    assert miss(bounced(sizes, axis, alpha, 0.3, 0.1)[0], expected) > 5e-3
