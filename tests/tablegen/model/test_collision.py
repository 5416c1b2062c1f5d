"""One collision: equations (5)-(7) against matrices and bisection, and the laws it must keep."""

import math
from dataclasses import replace

import numpy as np
import pytest
from collision_reference import NORMAL, TANGENTIAL, normal_balance, random_impacts, solve
from motion_fixtures import LAW, energy_of, motion_of

from sampler.compilation.jit import kernel
from tablegen.model.collision import energy_gain, impulse, impulse_cubic, positive_root
from tablegen.model.contact_laws import exponential_restitution as restitution
from tablegen.model.contact_laws import orientation_resistance as resistance
from tablegen.model.rebound import collide

# called from Python here
energy_gain = kernel(energy_gain)
restitution = kernel(restitution)
impulse_cubic = kernel(impulse_cubic)
resistance = kernel(resistance)

SPEED = 200.0
#: A resolution that no bounce of the sample falls below.
NO_FLOOR = 1e-300


def mobility_tuple(matrix):
    """A_xx, A_xy, A_xz, A_yy, A_yz, A_zz of a symmetric matrix."""
    return tuple(matrix[np.triu_indices(3)].tolist())


def collide_all(impacts, resolution, law=LAW):
    """Velocity changes of the centre (wall) and spin changes (body) by the kernel."""
    moved, turned = np.empty((len(impacts), 3)), np.empty((len(impacts), 3))
    for i in range(len(impacts)):
        motion = motion_of(impacts.rotation[i], impacts.spin[i], impacts.velocity[i])
        before = motion.copy()
        moments = tuple(impacts.moments[i].tolist())
        collide(law, SPEED, resolution, moments, impacts.point[i].copy(), motion)
        moved[i], turned[i] = motion[9:12] - before[9:12], motion[0:3] - before[0:3]
    return moved, turned


@pytest.fixture(scope="module")
def impacts():
    return random_impacts(np.random.default_rng(20240501), 6000)


@pytest.fixture(scope="module")
def collided(impacts):
    return collide_all(impacts, NO_FLOOR)


def catches(impacts):
    """Impacts in which the edge catches: f falls at first, A_yy < k A_yt . u_t."""
    pull = np.sum(
        impacts.mobility[:, TANGENTIAL, NORMAL] * impacts.contact_velocity[:, TANGENTIAL], axis=1
    )
    return impacts.mobility[:, NORMAL, NORMAL] < impacts.friction(LAW) * pull


def test_sample_holds_the_hard_cases(impacts):
    assert len(impacts) > 3000
    assert np.sum(catches(impacts)) > 300
    ratios = np.sqrt(impacts.moments.min(axis=1) / impacts.moments.max(axis=1))
    assert ratios.min() < 0.03
    assert np.linalg.norm(impacts.spin, axis=1).max() > 4.9
    grazing = np.arctan2(-impacts.velocity[:, 1], impacts.velocity[:, 0])
    assert grazing.min() < 2e-4


def test_velocity_change_is_the_root_found_by_bisection(impacts, collided):
    expected = solve(impacts, LAW, SPEED)
    size = np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(collided[0] / size, expected / size, rtol=0.0, atol=1e-11)


def test_another_law_gives_another_root(impacts, collided):
    # the comparison above would see a strength of 0.999 in place of 1
    expected = solve(impacts, LAW._replace(strength=0.999), SPEED)
    assert np.abs(collided[0] - expected).max() > 1e-4


def test_cubic_is_the_scalar_equation_times_its_determinant(impacts):
    k, jump = impacts.friction(LAW), impacts.jump(LAW, SPEED)
    block = impacts.mobility[:, TANGENTIAL][:, :, TANGENTIAL]
    u, _, w = impacts.contact_velocity.T
    for scale in (0.1, 1.0, 7.0):
        s = scale * jump
        half = (0.5 * k * s)[:, np.newaxis, np.newaxis]
        expected = normal_balance(impacts, k, jump, s) * np.linalg.det(np.eye(2) + half * block)
        for i in range(len(impacts)):
            mobility = mobility_tuple(impacts.mobility[i])
            terms = np.array(impulse_cubic(k[i], jump[i], mobility, u[i], w[i]))
            terms *= s[i] ** np.arange(4)
            assert abs(terms.sum() - expected[i]) <= 1e-11 * np.abs(terms).sum()


def test_cubic_has_exactly_one_positive_root(impacts):
    k, jump = impacts.friction(LAW), impacts.jump(LAW, SPEED)
    u, _, w = impacts.contact_velocity.T
    for i in range(len(impacts)):
        mobility = mobility_tuple(impacts.mobility[i])
        cubic = impulse_cubic(k[i], jump[i], mobility, u[i], w[i])
        roots = np.roots(cubic[::-1])
        real = roots[np.abs(roots.imag) <= 1e-9 * np.abs(roots)].real
        positive = real[real > 0.0]
        assert positive.size == 1
        assert impulse(k[i], jump[i], mobility, u[i], w[i])[1] == pytest.approx(positive[0], 1e-9)


def test_equations_5_hold(impacts, collided):
    moved, turned = collided
    spin_change = np.einsum("nij,nj->ni", impacts.rotation, turned)
    change = moved + np.cross(spin_change, impacts.arm)
    k, jump = impacts.friction(LAW), impacts.jump(LAW, SPEED)
    mean = impacts.contact_velocity + 0.5 * change
    expected = -(k * moved[:, NORMAL])[:, np.newaxis] * mean[:, TANGENTIAL]
    np.testing.assert_allclose(change[:, NORMAL], jump, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(moved[:, TANGENTIAL], expected, rtol=0.0, atol=1e-12)


def test_angular_momentum_change_is_the_torque_of_the_impulse(impacts, collided):
    moved, turned = collided
    gained = np.einsum("nij,nj->ni", impacts.rotation, impacts.moments * turned)
    torque = np.cross(impacts.arm, moved)
    np.testing.assert_allclose(gained, torque, rtol=0.0, atol=1e-13)


def energies_gained(impacts, collided):
    """Kinetic energy after minus before, from the motion alone."""
    moved, turned = collided
    gains = np.empty(len(impacts))
    for i in range(len(impacts)):
        before = motion_of(impacts.rotation[i], impacts.spin[i], impacts.velocity[i])
        after = before.copy()
        after[9:12] += moved[i]
        after[0:3] += turned[i]
        gains[i] = energy_of(impacts.moments[i], after) - energy_of(impacts.moments[i], before)
        gains[i] += 0.5 * (np.sum(after[9:12] ** 2) - np.sum(before[9:12] ** 2))
    return gains


def test_energy_never_grows_and_is_what_the_identity_says(impacts, collided):
    gains = energies_gained(impacts, collided)
    assert gains.max() <= 1e-12
    k, jump = impacts.friction(LAW), impacts.jump(LAW, SPEED)
    approach = -impacts.contact_velocity[:, NORMAL]
    for i, (s_x, s_y, s_z) in enumerate(collided[0]):
        gain = energy_gain(k[i], s_x, s_y, s_z, jump[i], approach[i])
        assert gain == pytest.approx(gains[i], rel=1e-9, abs=1e-12)


def sustained_contacts(rng, count):
    """Contacts of a chain of tiny bounces: sliding, and nearly rolling.

    The centre's velocity is changed so that the contact point approaches at 1e-7..1e-3 and, in
    half of the contacts, slides at 1e-7..1e-1 only.
    """
    impacts = random_impacts(rng, count)
    wanted = impacts.contact_velocity.copy()
    wanted[:, NORMAL] = -(10.0 ** rng.uniform(-7.0, -3.0, len(impacts)))
    rolls = rng.random(len(impacts)) < 0.5
    slide = 10.0 ** rng.uniform(-7.0, -1.0, (len(impacts), 1)) * rng.normal(size=(len(impacts), 2))
    wanted[:, TANGENTIAL] = np.where(rolls[:, np.newaxis], slide, wanted[:, TANGENTIAL])
    velocity = impacts.velocity + wanted - impacts.contact_velocity
    return replace(impacts, velocity=velocity)


def test_below_the_resolution_the_contact_leaves_at_the_floor_or_elastically():
    resolution = 1e-3
    impacts = sustained_contacts(np.random.default_rng(77), 3000)
    moved, turned = collided = collide_all(impacts, resolution)
    spin_change = np.einsum("nij,nj->ni", impacts.rotation, turned)
    change = moved + np.cross(spin_change, impacts.arm)
    approach = -impacts.contact_velocity[:, NORMAL]
    leaves = change[:, NORMAL] - approach

    bounce = impacts.restitution(LAW, SPEED) * approach
    assert bounce.max() < resolution
    at_floor = np.abs(leaves - resolution) <= 1e-12
    elastic = ~at_floor & (np.abs(leaves - approach) <= 1e-12)
    assert np.all(at_floor | elastic)
    assert energies_gained(impacts, collided).max() <= 1e-12
    # both ways out were met, and the elastic one only where the floor would have added energy
    assert np.sum(at_floor) > 500
    assert np.sum(elastic) > 100
    k = impacts.friction(LAW)
    for i in np.flatnonzero(elastic):
        u, v, w = impacts.contact_velocity[i].tolist()
        s_x, s_y, s_z = impulse(k[i], resolution - v, mobility_tuple(impacts.mobility[i]), u, w)
        assert energy_gain(k[i], s_x, s_y, s_z, resolution - v, -v) > 0.0


def test_restitution_follows_equation_6():
    speeds = np.geomspace(1e-3, 1e4, 40)
    cosines = np.linspace(0.0, 1.0, 21)
    for speed in speeds:
        for cosine in cosines:
            expected = 1.0 - (1.0 - math.exp(-0.1 * speed**0.61)) * cosine
            assert restitution(0.1, 0.61, speed, cosine) == pytest.approx(expected, abs=1e-15)


def test_restitution_lies_above_zero_and_up_to_one_and_falls():
    speeds = np.geomspace(1e-6, 1e3, 60)
    along = np.array([restitution(0.1, 0.61, speed, 1.0) for speed in speeds])
    assert np.all(along > 0.0)
    assert np.all(along <= 1.0)
    assert np.all(np.diff(along) < 0.0)
    across = np.array([restitution(0.1, 0.61, 200.0, c) for c in np.linspace(0.0, 1.0, 60)])
    assert np.all(np.diff(across) < 0.0)
    assert restitution(0.1, 0.61, 0.0, 1.0) == 1.0
    assert restitution(0.1, 0.61, 200.0, 0.0) == 1.0


def test_resistance_follows_equation_7(impacts):
    arm, velocity = impacts.arm, impacts.velocity
    factors = np.array(
        [
            resistance(1.0, float(r @ v), float(np.linalg.norm(r)), float(np.linalg.norm(v)))
            for r, v in zip(arm, velocity, strict=True)
        ]
    )
    np.testing.assert_allclose(factors, impacts.resistance(LAW), rtol=1e-14)
    assert factors.min() >= math.exp(-1.0)
    assert factors.max() <= math.e


def test_resistance_limits():
    # contact straight ahead of the centre, straight behind, abreast
    assert resistance(1.0, 0.3 * 2.0, 0.3, 2.0) == pytest.approx(math.e, rel=1e-15)
    assert resistance(1.0, -0.3 * 2.0, 0.3, 2.0) == pytest.approx(1.0 / math.e, rel=1e-15)
    assert resistance(1.0, 0.0, 0.3, 2.0) == 1.0
    # a resting centre has no direction
    assert resistance(1.0, 0.0, 0.3, 0.0) == 1.0
    assert resistance(0.0, 0.3 * 2.0, 0.3, 2.0) == 1.0


@pytest.mark.parametrize("root", [1e-12, 3e-5, 0.7, 1.0, 40.0, 1e9])
@pytest.mark.parametrize("start_over_root", [1e-6, 0.3, 1.0, 5.0, 1e6])
@pytest.mark.parametrize(
    ("p", "q"),
    [
        (3.0, 1.0),  # the others negative
        (0.0, 4.0),  # the others imaginary
        (-3.9, 4.0),  # two extrema near the root
        (2.0, 1.0),  # a double negative root
    ],
)
def test_positive_root_of_scripted_cubics(root, start_over_root, p, q):
    # (x - 1) (x^2 + p x + q) in x = s / root
    c0, c1, c2, c3 = np.array([-q, q - p, p - 1.0, 1.0]) / root ** np.arange(4.0)
    found = positive_root(c0, c1, c2, c3, start_over_root * root)
    assert found == pytest.approx(root, rel=1e-11)


def test_positive_root_without_cubic_and_quadratic_terms():
    assert positive_root(-3.0, 4.0, 0.0, 0.0, 1e-3) == pytest.approx(0.75, rel=1e-15)
    assert positive_root(-3.0, 0.0, 0.0, 24.0, 100.0) == pytest.approx(0.5, rel=1e-15)
