"""Grazing impacts in which an edge catches: A_nn < k A_nt . u_t.

As the impact angle falls to zero the normal velocity that a collision has to turn round vanishes,
and with it the impulse, unless the edge catches. Then sliding itself drives the contact point into
the wall, the scalar equation falls before it rises, and its root tends to a positive number: the
particle is thrown off the wall with a velocity of the order of V.
"""

import math

import numpy as np
import pytest
from motion_fixtures import body_of, run_rebound
from planar_reference import impact, mobility, paper_law, rebound, rotation_of_section, section_of
from scipy.optimize import brentq

from tablegen.model.collision import impulse
from tablegen.model.impact_condition import GRAZING
from tablegen.simulation.simulate import make_condition

SECTION = section_of("prism", 1.0, 1.0, 2)


def contact(theta):
    """Arm of the lowest corner, mobility, and k = C_f / V for a body that slides along x."""
    r = SECTION.lowest(theta)[0]
    return r, mobility(SECTION, r), math.exp(r[0] / math.hypot(*r))


def balance(theta):
    """A_nn - k u_t A_nt for u_t = V: below zero the edge catches."""
    _, (_, a_xy, a_yy), k = contact(theta)
    return a_yy - k * a_xy


def limit(theta):
    """Normal impulse as the impact angle falls to zero.

    With no jump the scalar equation divided by s is linear:
    A_nn (1 + k s A_tt / 2) = k A_nt (u_t + s A_nt / 2).
    """
    _, (a_xx, a_xy, a_yy), k = contact(theta)
    return max(0.0, 2.0 * (k * a_xy - a_yy) / (k * (a_xx * a_yy - a_xy**2)))


def kernel_impulse(theta, jump):
    """Tangential and normal impulse of the kernel for a wanted jump of v_c."""
    _, (a_xx, a_xy, a_yy), k = contact(theta)
    # in the plane nothing couples to z; A_zz is any positive number
    s_x, s_y, s_z = impulse(k, jump, (a_xx, a_xy, 0.0, a_yy, 0.0, 2.0), 1.0, 0.0)
    assert s_z == 0.0
    return s_x, s_y


#: Angles of the section: a corner well ahead of the centre catches, one right below it slips.
CATCHES, SLIPS = math.radians(75.0), math.radians(45.0)


def test_the_sample_has_an_edge_that_catches_and_one_that_does_not():
    assert balance(CATCHES) < -0.1
    assert balance(SLIPS) > 0.1


@pytest.mark.parametrize("jump", [1e-4, 1e-8, 1e-12])
def test_impulse_tends_to_its_closed_form_where_the_edge_catches(jump):
    s_x, s = kernel_impulse(CATCHES, jump)
    assert limit(CATCHES) > 0.1
    # the root moves in proportion to the jump
    assert abs(s - limit(CATCHES)) < 5.0 * jump + 1e-14
    _, (a_xx, a_xy, _), k = contact(CATCHES)
    side = -k * s * (1.0 + 0.5 * a_xy * s) / (1.0 + 0.5 * k * s * a_xx)
    assert s_x == pytest.approx(side, rel=1e-14)


@pytest.mark.parametrize("jump", [1e-4, 1e-8, 1e-12])
def test_impulse_vanishes_with_the_jump_where_the_edge_slips(jump):
    _, s = kernel_impulse(SLIPS, jump)
    assert limit(SLIPS) == 0.0
    # to first order f(s) = (A_nn - k u_t A_nt) s - jump
    assert s == pytest.approx(jump / balance(SLIPS), rel=10.0 * jump + 1e-13)


@pytest.mark.parametrize("shift", [-1e-3, 1e-3])
def test_impulse_follows_the_threshold_from_both_sides(shift):
    threshold = brentq(balance, SLIPS, CATCHES, xtol=1e-15)
    _, s = kernel_impulse(threshold + shift, 1e-13)
    assert s == pytest.approx(limit(threshold + shift), abs=1e-9)
    assert (s > 1e-4) == (shift > 0.0)


def test_impulse_goes_with_the_root_of_the_jump_at_the_threshold():
    # there f(s) + jump begins with the square of s
    threshold = brentq(balance, SLIPS, CATCHES, xtol=1e-15)
    _, (a_xx, a_xy, a_yy), k = contact(threshold)
    curvature = 0.5 * k * (a_xx * a_yy - a_xy**2)
    _, s = kernel_impulse(threshold, 1e-10)
    assert s == pytest.approx(math.sqrt(1e-10 / curvature), rel=1e-3)


def thrown(theta, alpha):
    """State (u, v, omega_z) of the model after a rebound without a floor to the bounce."""
    resolution = 1e-9 * min(1.0, math.sin(alpha) / GRAZING)
    condition = make_condition(0.5, 200.0)._replace(
        cosine=math.cos(alpha), sine=math.sin(alpha), resolution=resolution
    )
    made = run_rebound(condition, body_of("prism", 1.0, 1.0), rotation_of_section(theta, 2))
    return made.state[[0, 1, 5]], made.collisions


@pytest.mark.parametrize("theta_deg", [10.0, 20.0, 70.0, 75.0, 85.0])
def test_a_particle_that_catches_is_thrown_off_at_any_grazing_angle(theta_deg):
    # below 25 degrees the corner behind slips first and the one ahead catches in its turn
    theta, alphas, states = math.radians(theta_deg), (1e-3, 1e-5, 1e-7), []
    for alpha in alphas:
        state, collisions = thrown(theta, alpha)
        law = paper_law(200.0, resolution=1e-9)
        expected, hits = rebound(SECTION, law, impact(SECTION, theta, alpha))
        assert collisions == hits
        np.testing.assert_allclose(state, expected, atol=1e-7)
        states.append(state)
    assert states[-1][1] > 0.07
    # the limit is reached in proportion to the angle
    steps = [np.abs(state - states[-1]).max() for state in states[:-1]]
    assert steps[0] < 20.0 * alphas[0]
    assert steps[1] < 20.0 * alphas[1]


def test_a_particle_that_slips_leaves_as_it_came_at_grazing_angles():
    for alpha in (1e-3, 1e-5, 1e-7):
        state, _ = thrown(SLIPS, alpha)
        np.testing.assert_allclose(state, [1.0, 0.0, 0.0], atol=20.0 * alpha)
        assert state[1] > 0.0


def test_one_collision_that_catches_gives_the_state_in_closed_form():
    # a cube whose leading corner strikes once and leaves
    r, (a_xx, a_xy, _), k = contact(CATCHES)
    s = limit(CATCHES)
    side = -k * s * (1.0 + 0.5 * a_xy * s) / (1.0 + 0.5 * k * s * a_xx)
    turn = (r[0] * s - r[1] * side) / SECTION.moment
    state, collisions = thrown(CATCHES, 1e-9)
    assert collisions == 1
    np.testing.assert_allclose(state, [1.0 + side, s, turn], atol=1e-7)
