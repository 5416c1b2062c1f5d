"""Collisions under Coulomb friction: closed forms, small steps, and the audit."""

import math

import contact_law_samples as samples
import numpy as np
import pytest
from motion_fixtures import POPULATION
from test_collision import mobility_tuple, random_impacts

from tablegen.config.pairs import MaterialPair
from tablegen.model.audit import AUDIT_SIZE, NORMAL, TANGENTIAL, audit_collision, followed
from tablegen.model.coulomb import Ending, coulomb_impulse
from tablegen.model.rotation import ORDER
from tablegen.model.sliding import Friction
from tablegen.simulation.simulate import make_condition, simulate_condition

#: A resolution that no contact falls below.
NO_FLOOR = 1e-12

#: Mobility, velocity and friction of rare kinds of collisions, found at random.
RARE = {
    "jams": ([4.4, 0.5, 1.0, 2.4, -1.5, 3.5], [0.2, -1.1, -0.2], 1.6),
    "slips anew": ([3.5, 0.4, -2.6, 1.5, 0.4, 6.3], [-1.0, -1.6, -0.6], 0.2),
    "is compressed again": ([2.4, -1.9, 0.6, 3.7, -0.7, 2.8], [-1.6, -0.2, 2.7], 4.2),
}


def matrix_of(entries):
    """Symmetric matrix of A_xx, A_xy, A_xz, A_yy, A_yz, A_zz."""
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = entries
    return matrix + np.triu(matrix, 1).T


def collision(matrix, velocity, friction, e, resolution=NO_FLOOR, static=None):
    """Impulse by the kernel, and the energy that its normal part takes."""
    pair = Friction(friction if static is None else static, friction)
    ending = Ending((1.0 - e) * (1.0 + e), resolution)
    entries, velocity = mobility_tuple(np.asarray(matrix)), tuple(map(float, velocity))
    series = np.full((9, ORDER + 1), np.nan)
    made, taken = coulomb_impulse(pair, ending, entries, velocity, series, True)
    return np.array(made), taken


def energy_gained(matrix, velocity, made):
    """Change of the kinetic energy by an impulse."""
    return made @ np.asarray(velocity) + 0.5 * made @ matrix @ made


def miss_of_small_steps(matrix, velocity, static, friction, e, resolution):
    """Largest miss of the kernel's outcome from small steps along the defining equations."""
    made, taken = collision(matrix, velocity, friction, e, resolution, static)
    assert energy_gained(matrix, velocity, made) <= 1e-13
    given = mobility_tuple(matrix), tuple(map(float, velocity)), made[1]
    *after, work, least = followed(static, friction, *given)
    found = velocity + matrix @ made
    # the collision ends with its share of the work, at the resolution, or elastically
    end = min(abs(work - (1.0 - e * e) * least), abs(found[1] - resolution), abs(work))
    return max(np.abs(found - after).max(), abs(work + taken), end)


def test_impulses_are_those_of_small_steps():
    rng = np.random.default_rng(20261122)
    impacts = random_impacts(rng, 90)
    for matrix, velocity in zip(impacts.mobility(), impacts.contact_velocity, strict=True):
        friction, e = float(np.exp(rng.uniform(-5.0, 3.0))), float(rng.choice([0.0, 0.5, 1.0]))
        static = friction * float(rng.choice([1.0, 1.5]))
        miss = miss_of_small_steps(matrix, velocity, static, friction, e, 1e-3)
        assert miss <= 1e-9 * np.linalg.norm(velocity)


@pytest.mark.parametrize("case", RARE)
def test_rare_collisions_are_those_of_small_steps(case):
    entries, velocity, friction = RARE[case]
    matrix, velocity = matrix_of(entries), np.array(velocity)
    assert miss_of_small_steps(matrix, velocity, friction, friction, 0.5, 1e-6) <= 1e-9


def test_another_friction_is_seen():
    entries, velocity, friction = RARE["slips anew"]
    matrix = matrix_of(entries)
    made, _ = collision(matrix, velocity, 1.001 * friction, 0.5)
    *after, _, _ = followed(friction, friction, tuple(entries), tuple(velocity), made[1])
    assert np.abs(np.array(velocity) + matrix @ made - after).max() > 1e-6


def test_without_friction_only_the_normal_velocity_changes():
    for entries, velocity, _ in RARE.values():
        matrix = matrix_of(entries)
        made, _ = collision(matrix, velocity, 0.0, 0.7)
        expected = [0.0, -1.7 * velocity[1] / matrix[1, 1], 0.0]
        np.testing.assert_allclose(made, expected, atol=1e-12)


def pair_of(e, static, dynamic):
    """A pair with constant restitution and Coulomb friction."""
    resistance = {"law": "coulomb", "static": static, "dynamic": dynamic}
    laws = {
        "restitution": samples.SOURCE | {"law": "constant", "value": e},
        "resistance": samples.SOURCE | resistance,
    }
    return MaterialPair.from_tree({"particle": "any", "wall": "any", **laws})


@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.0), (0.4, -1.0, -0.9), (-2.0, 3.0, 1.0)])
@pytest.mark.parametrize("friction", [0.05, 0.2, 1.0])
def test_spheres_follow_their_closed_form_with_any_spin(friction, spin):
    alpha = math.radians(40.0)
    made = simulate_condition(
        pair_of(0.8, 2.0 * friction, friction),
        POPULATION.restricted_to("sphere"),
        make_condition(alpha, 100.0, spin),
        10,
        seed=1,
    )
    # a point a below the centre slides at v + Omega x r, and 7/2 is its mobility along the wall
    slide = np.array([math.cos(alpha) + spin[2], -spin[0]])
    s = 1.8 * math.sin(alpha)
    side = -slide * min(friction * s / np.linalg.norm(slide), 2.0 / 7.0)
    expected = [
        math.cos(alpha) + side[0],
        0.8 * math.sin(alpha),
        side[1],
        spin[0] - 2.5 * side[1],
        spin[1],
        spin[2] + 2.5 * side[0],
    ]
    np.testing.assert_allclose(made.state, np.tile(expected, (10, 1)), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("alpha_deg", [2.0, 45.0, 90.0])
def test_lanes_have_the_bits_of_single_particles_and_pass_the_audit(alpha_deg):
    for friction in (0.1, 2.0):
        given = pair_of(0.6, 1.2 * friction, friction), POPULATION
        condition = make_condition(math.radians(alpha_deg), 100.0)
        single = simulate_condition(*given, condition, 40, seed=3, audited=True)
        lanes = simulate_condition(*given, condition, 40, seed=3)
        np.testing.assert_array_equal(lanes.state, single.state)
        assert single.audit.max() < 1e-9


def test_audit_reports_another_friction_and_another_restitution():
    law = pair_of(0.6, 0.3, 0.3).kernel_arguments()
    # a sphere that slides throughout, with an impulse of 0.29 instead of 0.3
    before = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.9, -0.1, 0.0, 1.0])
    point, moments = np.array([0.0, -1.0, 0.0]), (0.4, 0.4, 0.4)
    for normal, side, wrong in ((0.16, 0.3, None), (0.16, 0.29, TANGENTIAL), (0.17, 0.3, NORMAL)):
        after, audit = before.copy(), np.zeros(AUDIT_SIZE)
        after[10] += normal
        after[9] -= side * normal
        # axes x, n = y, z = x times n of the body and of the wall agree
        after[2] -= 2.5 * side * normal
        audit_collision(law, 100.0, 1e-3, moments, point, before, after, audit)
        if wrong is None:
            assert audit.max() < 1e-12
        else:
            assert audit[wrong] > 1e-4
