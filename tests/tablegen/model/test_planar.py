"""Rebounds in the impact plane, flat-on and edge-on contact, against a planar reference.

A prism with an axis along z never touches with one corner alone: its edges strike as a whole and
its faces where they lie flat, so that every contact is a tie whose point is the centre of the edge
or face.
"""

import numpy as np
import planar_reference
import pytest
from motion_fixtures import body_of, run_rebound
from planar_reference import impact, paper_law, rebound, rotation_of_section, section_of

from tablegen.simulation.simulate import make_condition

SPEED = 200.0

#: Half-sizes b and c: default, cube, needle, disc, blade.
FORMS = [(0.8, 0.6), (1.0, 1.0), (0.02, 0.02), (1.0, 0.02), (0.02, 0.0004)]


def both(name, sizes, axis, theta, alpha_deg):
    """States (u, v, omega_z) of model and reference, and their numbers of collisions."""
    alpha, body = np.radians(alpha_deg), body_of(name, *sizes)
    made = run_rebound(make_condition(alpha, SPEED), body, rotation_of_section(theta, axis))
    np.testing.assert_allclose(made.state[2:5], 0.0, atol=1e-12)
    section = section_of(name, *sizes, axis)._replace(moment=body.moments[axis])
    expected, collisions = rebound(section, paper_law(SPEED), impact(section, theta, alpha))
    return made.state[[0, 1, 5]], expected, made.collisions, collisions


def differs(one, other):
    """Largest difference of two states, that of omega relative where omega is large."""
    return np.max(np.abs(one - other) / [1.0, 1.0, 1.0 + abs(other[2])])


def assert_equal_rebounds(*case):
    state, expected, hits, collisions = both(*case)
    assert hits == collisions
    # The model finds a contact 1e-12 above the wall. In a chain of hundreds of bounces, each some
    # 1e-6 high, that adds up: to 2e-4 in the blade, and in proportion to the 1e-12.
    assert differs(state, expected) < (1e-7 if hits <= 50 else 5e-4)
    return hits


@pytest.mark.parametrize("alpha_deg", [0.5, 20.0, 60.0, 90.0])
@pytest.mark.parametrize("sizes", FORMS)
@pytest.mark.parametrize("name", ["prism", "ellipsoid", "truncated-prism"])
def test_edges_and_ellipses_follow_the_planar_reference(name, sizes, alpha_deg):
    # a truncated prism turned about an axis is as wide as the prism: two corners lead, at +-z
    rng = np.random.default_rng(int(1000.0 * sum(sizes) + alpha_deg))
    for axis in range(3):
        for theta in rng.uniform(0.0, 2.0 * np.pi, 3):
            assert assert_equal_rebounds(name, sizes, axis, theta, alpha_deg) >= 1


@pytest.mark.parametrize("alpha_deg", [0.5, 5.0, 20.0, 45.0, 80.0, 90.0])
@pytest.mark.parametrize("sizes", FORMS)
def test_faces_that_land_flat_follow_the_planar_reference(sizes, alpha_deg):
    for axis in range(3):
        for quarter in range(4):
            hits = assert_equal_rebounds("prism", sizes, axis, quarter * 0.5 * np.pi, alpha_deg)
            # at normal impact the centre of the face is below that of mass
            assert alpha_deg != 90.0 or hits == 1


def test_faces_strike_again_with_an_edge_where_sliding_turns_them():
    # the kick of the first contact turns the body faster than it rises
    hits = [both("prism", (1.0, 1.0), 2, 0.0, alpha)[2] for alpha in (5.0, 45.0, 90.0)]
    assert hits[0] > 1
    assert hits[2] == 1


@pytest.mark.parametrize(("tilt", "lands_flat"), [(1e-10, True), (1e-7, False)])
def test_a_face_lands_flat_within_the_tie_height_only(tilt, lands_flat):
    flat = both("prism", (0.8, 0.6), 1, 0.0, 45.0)[0]
    state, expected, _, _ = both("prism", (0.8, 0.6), 1, tilt, 45.0)
    assert differs(state, expected) < 1e-7
    # a corner that leads gives another rebound, so that the tie is seen above
    if lands_flat:
        assert differs(state, flat) < 1e-7
    else:
        assert differs(state, flat) > 0.1


def test_the_reference_is_at_rest_with_its_own_grid(monkeypatch):
    case = ("ellipsoid", (1.0, 0.02), 1, 4.75, 90.0)
    _, coarse, _, collisions = both(*case)
    assert collisions > 100
    monkeypatch.setattr(planar_reference, "DENSITY", 4 * planar_reference.DENSITY)
    _, fine, _, again = both(*case)
    assert again == collisions
    assert differs(coarse, fine) < 1e-6


def test_the_reference_keeps_the_closed_form_of_a_flat_landing():
    # r = (0, -c) couples nothing: A_yy = 1, A_xx = 1 + c^2 / J
    section, alpha = section_of("prism", 0.8, 0.6, 2), np.radians(70.0)
    after = planar_reference.collide(
        section, paper_law(SPEED), impact(section, 0.0, alpha), np.array([0.0, -0.8])
    )
    a_nc = 1.0 - (1.0 - np.exp(-0.1 * SPEED**0.61)) * np.sin(alpha)
    s = (1.0 + a_nc) * np.sin(alpha)
    k = np.exp(np.sin(alpha))
    side = -k * s * np.cos(alpha) / (1.0 + 0.5 * k * s * (1.0 + 0.8**2 / section.moment))
    expected = [np.cos(alpha) + side, a_nc * np.sin(alpha), 0.8 * side / section.moment]
    np.testing.assert_allclose([after.u, after.v, after.omega], expected, atol=1e-14)
