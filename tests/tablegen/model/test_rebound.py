"""Whole rebounds: laws of every collision and flight, audited violations, known answers."""

import numpy as np
import pytest
from audit import (
    ANGULAR,
    AUDIT_SIZE,
    FLIGHT_MOMENTUM,
    NORMAL,
    PENETRATION,
    TANGENTIAL,
    audit_collision,
    audit_flight,
)
from free_rotation import FreeRotation
from motion_fixtures import (
    ALLOWED,
    LAW,
    PAIR,
    POPULATION,
    SHAPES,
    angular_momentum_of,
    body_of,
    energy_of,
    kernel_condition,
    motion_of,
    random_rotations,
    rebound,
    rotation_of,
    run_rebound,
    workspace,
)
from one_particle import simulate_alone

from tablegen.model.contact import contact_point
from tablegen.model.reach import MARGIN
from tablegen.model.rebound import (
    HEIGHT,
    U,
    V,
    apply_collision,
    place_before_impact,
)
from tablegen.model.rotation import ORDER
from tablegen.model.shapes import support_depth
from tablegen.simulation.simulate import CONTACT_RESOLUTION, make_condition, simulate_condition

#: An impact with a spin.
SPINNING = kernel_condition(make_condition(0.3, 200.0, (1.0, 2.0, 3.0)))

#: Work space of a collision.
SERIES = np.empty((9, ORDER + 1))

#: Impact angle [deg], speed [m/s], spin: grazing, usual, nearly normal, normal, with spin.
CONDITIONS = [
    (0.01, 200.0, (0.0, 0.0, 0.0)),
    (20.0, 50.0, (0.0, 0.0, 0.0)),
    (60.0, 300.0, (0.0, 0.0, 0.0)),
    (89.99, 200.0, (0.0, 0.0, 0.0)),
    (90.0, 200.0, (0.0, 0.0, 0.0)),
    (2.0, 200.0, (2.0, -1.0, -5.0)),
    (30.0, 200.0, (1.0, -2.0, 3.0)),
    (90.0, 100.0, (0.0, 0.0, 4.0)),
]


@pytest.mark.parametrize(("alpha_deg", "speed", "spin"), CONDITIONS)
@pytest.mark.parametrize("name", SHAPES)
def test_every_collision_and_flight_keeps_its_laws(name, alpha_deg, speed, spin):
    population = POPULATION.restricted_to(name)
    condition = make_condition(np.radians(alpha_deg), speed, spin)
    values, _, audit = simulate_alone(PAIR, population, condition, 5000, seed=41)
    assert np.all(audit <= ALLOWED), audit
    assert np.all(np.isfinite(values))
    assert values[:, 1].min() > 0.0
    assert values[:, 7].min() >= 1
    assert values[:, 6].min() >= 0.0
    kept = np.square(values[:, :3]).sum(axis=1) / values[:, 11] + values[:, 6]
    assert kept.max() <= 1.0 + 1e-9


@pytest.fixture
def collision():
    body = body_of("prism", 0.8, 0.6)
    rotation = random_rotations(np.random.default_rng(42), 1)[0]
    before = motion_of(rotation, [0.3, 0.5, -0.2], [0.8, -0.6, 0.0])
    before[HEIGHT] = support_depth(body, *before[3:6])
    point = np.empty(3)
    contact_point(body, before, before[HEIGHT], before[V], point)
    after = before.copy()
    apply_collision(LAW, 200.0, CONTACT_RESOLUTION, body.moments, point, after, SERIES)
    return body, point, before, after


def audited(collision, law=LAW, after=None, speed=200.0):
    body, point, before, truth = collision
    audit = np.zeros(AUDIT_SIZE)
    outcome = truth if after is None else after
    audit_collision(law, speed, CONTACT_RESOLUTION, body.moments, point, before, outcome, audit)
    return audit


@pytest.mark.parametrize(
    ("change", "entry"),
    [
        ({"coefficient": 0.101}, NORMAL),
        ({"exponent": 0.611}, NORMAL),
        ({"strength": 0.99}, TANGENTIAL),
    ],
)
def test_audit_reports_another_law(collision, change, entry):
    assert audited(collision).max() <= 1e-14
    audit = audited(collision, LAW._replace(**change))
    assert audit[entry] > 1e-4
    assert np.all(np.delete(audit, entry) <= 1e-14)


@pytest.mark.parametrize("row", [0, 1, 2, U, V, U + 2])
def test_audit_reports_a_wrong_spin_or_impulse(collision, row):
    after = collision[3].copy()
    after[row] += 1e-8
    audit = audited(collision, after=after)
    assert audit[[NORMAL, TANGENTIAL] if row >= U else ANGULAR].max() > 1e-10


def test_audit_reports_a_body_that_does_not_tumble():
    body = body_of("prism", 0.8, 0.6)
    before = motion_of(np.eye(3), [0.0, 0.5, 0.2], [0.0, 0.3, 0.0])
    after, frozen = before.copy(), before.copy()
    turned = FreeRotation(body.moments, before, 0.5).rotation([0.5])[0]
    # the orientation moves on, the spin in body axes stays
    frozen[3:6], frozen[6:9] = turned[1], turned[0]
    after[0:3] = FreeRotation(body.moments, before, 0.5).spin([0.5])[0]
    after[3:9] = frozen[3:9]
    right, wrong = np.zeros(AUDIT_SIZE), np.zeros(AUDIT_SIZE)
    audit_flight(body.moments, before, after, right)
    audit_flight(body.moments, before, frozen, wrong)
    assert right.max() <= 1e-11
    assert wrong[FLIGHT_MOMENTUM] > 1e-3


def test_audit_reports_a_start_inside_the_wall():
    body = body_of("prism", 0.8, 0.6)
    motion = motion_of(random_rotations(np.random.default_rng(43), 1)[0])
    audit = np.zeros(AUDIT_SIZE)
    condition = kernel_condition(make_condition(0.5, 200.0))
    place_before_impact(condition, body, motion)
    motion[HEIGHT] -= 1e-6
    rebound(LAW, condition, body, motion, workspace(), audit)
    assert audit[PENETRATION] == pytest.approx(1e-6, rel=1e-6)


@pytest.mark.parametrize("speed", [50.0, 200.0, 300.0])
@pytest.mark.parametrize("alpha_deg", [0.01, 0.5, 10.0, 45.0, 80.0, 90.0])
def test_sphere_follows_its_closed_form(alpha_deg, speed):
    alpha = np.radians(alpha_deg)
    sin, cos = np.sin(alpha), np.cos(alpha)
    # r = (0, -a, 0) couples nothing: A_yy = 1, A_xx = 1 + a^2 / J = 7 / 2
    a_nc = 1.0 - (1.0 - np.exp(-0.1 * speed**0.61)) * sin
    s = (1.0 + a_nc) * sin
    k = np.exp(sin)  # C_f: the centre moves along r . V = sin, |V_c| = 1
    side = -k * s * cos / (1.0 + 0.5 * k * s * 3.5)
    expected = [cos + side, a_nc * sin, 0.0, 0.0, 0.0, side / 0.4]

    population = POPULATION.restricted_to("sphere")
    simulation = simulate_condition(PAIR, population, make_condition(alpha, speed), 20, seed=44)
    np.testing.assert_array_equal(simulation.collisions, 1)
    np.testing.assert_allclose(simulation.state, np.tile(expected, (20, 1)), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("speed", [50.0, 300.0])
@pytest.mark.parametrize("face", range(6))
@pytest.mark.parametrize("name", ["prism", "truncated-prism"])
def test_flat_on_prism_leaves_straight_up(name, face, speed):
    # all corners of a face strike together: the contact is its centre, below the centre of mass
    axes = np.roll(np.eye(3), face, axis=1) * (-1.0 if face >= 3 else 1.0)
    rotation = axes * np.array([[np.linalg.det(axes)], [1.0], [1.0]])
    rebound = run_rebound(make_condition(np.pi / 2, speed), body_of(name, 0.8, 0.6), rotation)
    assert rebound.collisions == 1
    a_nc = np.exp(-0.1 * speed**0.61)
    np.testing.assert_allclose(rebound.state, [0.0, a_nc, 0.0, 0.0, 0.0, 0.0], atol=1e-14)


def test_a_particle_without_spin_starts_at_its_contact_and_another_within_its_bounding_radius():
    body = body_of("prism", 0.7, 0.5)
    motion = motion_of(random_rotations(np.random.default_rng(48), 1)[0])
    rotation = rotation_of(motion)
    place_before_impact(kernel_condition(make_condition(0.3, 200.0)), body, motion)
    assert motion[HEIGHT] == support_depth(body, *motion[3:6])
    np.testing.assert_array_equal(motion[0:3], 0.0)
    np.testing.assert_allclose(motion[9:12], [np.cos(0.3), -np.sin(0.3), 0.0], rtol=1e-15)
    place_before_impact(SPINNING, body, motion)
    assert support_depth(body, *motion[3:6]) < motion[HEIGHT] <= body.bounding_radius + MARGIN
    np.testing.assert_array_equal(rotation_of(motion), rotation)


def test_the_mean_spin_before_a_rebound_is_2t_over_l2_times_l():
    body = body_of("prism", 0.7, 0.5)
    motion = motion_of(random_rotations(np.random.default_rng(49), 1)[0])
    place_before_impact(SPINNING, body, motion)
    momentum = angular_momentum_of(body.moments, motion)
    mean = 2.0 * energy_of(body.moments, motion) / (momentum @ momentum) * momentum
    np.testing.assert_allclose(mean, [1.0, 2.0, 3.0], rtol=1e-14)
    assert np.abs(rotation_of(motion) @ motion[0:3] - mean).max() > 0.1
