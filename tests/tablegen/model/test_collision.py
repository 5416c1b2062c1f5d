"""One collision: equations (5)-(7) against the readable reference, and the laws it must keep."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import reference_model as reference
from motion_fixtures import LAW, energy_of, motion_of, random_rotations

from tablegen.model.collision import energy_gain, impulse, impulse_cubic, positive_root
from tablegen.model.jit import kernel
from tablegen.model.rebound import collide
from tablegen.model.rotation import ORDER

# called from Python here
energy_gain = kernel(energy_gain)
impulse_cubic = kernel(impulse_cubic)

SPEED = 200.0
#: A resolution that no bounce of the sample falls below.
NO_FLOOR = 1e-300
TANGENTIAL, NORMAL = [0, 2], 1


@dataclass(frozen=True)
class Impacts:
    """Bodies at the instant of contact; ``point`` and ``moments`` in body axes, the rest in wall.

    ``rotation`` (n, 3, 3) takes body axes to wall axes; the others are (n, 3).
    """

    rotation: np.ndarray
    moments: np.ndarray
    point: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray

    def __len__(self):
        return len(self.moments)

    @property
    def arm(self):
        """Contact point from the centre, wall axes."""
        return np.einsum("nij,nj->ni", self.rotation, self.point)

    @property
    def contact_velocity(self):
        """Contact velocity, equation (2)."""
        return self.velocity + np.cross(self.spin, self.arm)

    def bounce(self):
        """Normal contact velocity after the collision, equation (6)."""
        size, fall = np.linalg.norm(self.contact_velocity, axis=1), -self.contact_velocity[:, 1]
        drop = 1.0 - np.exp(-LAW.coefficient * (SPEED * size) ** LAW.exponent)
        return (1.0 - drop * fall / size) * fall

    def jump(self):
        """Change of the normal contact velocity, first of equations (5)."""
        return self.bounce() - self.contact_velocity[:, NORMAL]

    def friction(self):
        """k = C_f / |V_c| with C_f from equation (7)."""
        cosine = np.sum(self.arm * self.velocity, axis=1)
        cosine /= np.linalg.norm(self.arm, axis=1) * np.linalg.norm(self.velocity, axis=1)
        return np.exp(LAW.strength * cosine) / np.linalg.norm(self.contact_velocity, axis=1)

    def of_reference(self, i):
        """Particle, turn, velocity and contact point of one impact for the reference."""
        moments, point, velocity = (
            tuple(rows[i].tolist()) for rows in (self.moments, self.point, self.velocity)
        )
        particle = reference.Particle((1.0, 1.0, 1.0), np.empty((0, 3)), moments, 1.0)
        axes = [self.rotation[i].T @ self.spin[i], *self.rotation[i]]
        return particle, reference.Turn(*(tuple(a.tolist()) for a in axes)), velocity, point

    def mobility(self):
        """A of each impact, (n, 3, 3), by the reference."""
        rows = []
        for i in range(len(self)):
            particle, turn, _, point = self.of_reference(i)
            rows.append(reference.mobility(particle, turn, reference.to_wall(turn, point)))
        return np.array(rows)


def random_impacts(rng, count):
    """Approaching contacts of ellipsoids and boxes: blunt to needle, normal to grazing impact.

    Aspect ratios are log-uniform down to 0.02 each, impact angles log-uniform from 1e-4 to pi/2,
    spins up to 5 V / a, a third of them zero.
    """
    ratios = np.exp(rng.uniform(np.log(0.02), 0.0, (count, 2)))
    sizes = np.column_stack([np.ones(count), ratios[:, 0], ratios[:, 0] * ratios[:, 1]])
    rotation = random_rotations(rng, count)
    normal = rotation[:, NORMAL]
    box = rng.random(count) < 0.5
    depth = np.linalg.norm(sizes * normal, axis=1, keepdims=True)
    point = np.where(box[:, np.newaxis], -sizes * np.sign(normal), -(sizes**2) * normal / depth)
    second = np.where(box, 1.0 / 3.0, 0.2)[:, np.newaxis] * sizes**2
    moments = second.sum(axis=1, keepdims=True) - second
    angle = np.exp(rng.uniform(np.log(1e-4), np.log(np.pi / 2), count))
    velocity = np.column_stack([np.cos(angle), -np.sin(angle), np.zeros(count)])
    spin = rng.normal(size=(count, 3))
    spin /= np.linalg.norm(spin, axis=1, keepdims=True)
    spin *= np.maximum(rng.uniform(-2.5, 5.0, (count, 1)), 0.0)
    made = Impacts(rotation, moments, point, velocity, spin)
    approaching = made.contact_velocity[:, NORMAL] < -1e-6
    return Impacts(*(rows[approaching] for rows in vars(made).values()))


def mobility_tuple(matrix):
    """A_xx, A_xy, A_xz, A_yy, A_yz, A_zz of a symmetric matrix."""
    return tuple(matrix[np.triu_indices(3)].tolist())


def collide_all(impacts, resolution):
    """Velocity changes (wall), spin changes (body) and energies taken, by the kernel."""
    moved, turned = np.empty((len(impacts), 3)), np.empty((len(impacts), 3))
    taken = np.empty((len(impacts), 2))
    series = np.empty((9, ORDER + 1))
    for i in range(len(impacts)):
        motion = motion_of(impacts.rotation[i], impacts.spin[i], impacts.velocity[i])
        before = motion.copy()
        moments = tuple(impacts.moments[i].tolist())
        point = impacts.point[i].copy()
        taken[i] = collide(LAW, SPEED, resolution, moments, point, motion, series)
        moved[i], turned[i] = motion[9:12] - before[9:12], motion[0:3] - before[0:3]
    return moved, turned, taken


def collide_by_reference(impacts, law):
    """Velocity changes of the centre by the readable reference, which bisects."""
    setup = reference.Setup(0.0, SPEED, resolution=NO_FLOOR)
    made = (reference.collide(law, setup, *impacts.of_reference(i)) for i in range(len(impacts)))
    return np.array([velocity for velocity, _ in made]) - impacts.velocity


@pytest.fixture(scope="module")
def impacts():
    return random_impacts(np.random.default_rng(20240501), 6000)


@pytest.fixture(scope="module")
def collided(impacts):
    return collide_all(impacts, NO_FLOOR)


@pytest.fixture(scope="module")
def mobility(impacts):
    return impacts.mobility()


@pytest.fixture(scope="module")
def equations(impacts, mobility):
    """k, jump, A_xx ... A_zz, u_c and w_c of each impact, as the kernels take them."""
    u, _, w = impacts.contact_velocity.T.tolist()
    matrices = map(mobility_tuple, mobility)
    rows = (impacts.friction().tolist(), impacts.jump().tolist(), matrices, u, w)
    return list(zip(*rows, strict=True))


def test_sample_holds_the_hard_cases(impacts, mobility):
    assert len(impacts) > 3000
    # the edge catches: f falls at first, A_yy < k A_yt . u_t
    slides = impacts.contact_velocity[:, TANGENTIAL]
    coupling = np.sum(mobility[:, NORMAL][:, TANGENTIAL] * slides, axis=1)
    assert np.sum(mobility[:, NORMAL, NORMAL] < impacts.friction() * coupling) > 300
    ratios = np.sqrt(impacts.moments.min(axis=1) / impacts.moments.max(axis=1))
    assert ratios.min() < 0.03
    assert np.linalg.norm(impacts.spin, axis=1).max() > 4.9
    grazing = np.arctan2(-impacts.velocity[:, 1], impacts.velocity[:, 0])
    assert grazing.min() < 2e-4


def test_velocity_change_is_the_root_found_by_bisection(impacts, collided):
    expected = collide_by_reference(impacts, reference.Law())
    size = np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(collided[0] / size, expected / size, rtol=0.0, atol=1e-11)
    # another law gives another root, which the comparison above would see
    other = collide_by_reference(impacts, reference.Law(strength=0.999))
    assert np.abs(collided[0] - other).max() > 1e-4


def test_cubic_is_the_scalar_equation_times_its_determinant(equations, mobility):
    for (k, jump, entries, u, w), matrix in zip(equations, mobility, strict=True):
        columns = tuple(map(tuple, matrix.tolist()))
        block = matrix[np.ix_(TANGENTIAL, TANGENTIAL)]
        for s in (0.1 * jump, jump, 7.0 * jump):
            balance = np.dot(matrix[NORMAL], reference.impulse_for(s, k, columns, u, w)) - jump
            expected = balance * np.linalg.det(np.eye(2) + 0.5 * k * s * block)
            terms = np.array(impulse_cubic(k, jump, entries, u, w)) * s ** np.arange(4)
            assert abs(terms.sum() - expected) <= 1e-11 * np.abs(terms).sum()


def test_cubic_has_exactly_one_positive_root(equations):
    for equation in equations:
        roots = np.roots(impulse_cubic(*equation)[::-1])
        real = roots[np.abs(roots.imag) <= 1e-9 * np.abs(roots)].real
        positive = real[real > 0.0]
        assert positive.size == 1
        assert impulse(*equation)[1] == pytest.approx(positive[0], 1e-9)


def test_equations_5_hold(impacts, collided):
    moved, turned, _ = collided
    spin_change = np.einsum("nij,nj->ni", impacts.rotation, turned)
    change = moved + np.cross(spin_change, impacts.arm)
    mean = impacts.contact_velocity + 0.5 * change
    expected = -(impacts.friction() * moved[:, NORMAL])[:, np.newaxis] * mean[:, TANGENTIAL]
    np.testing.assert_allclose(change[:, NORMAL], impacts.jump(), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(moved[:, TANGENTIAL], expected, rtol=0.0, atol=1e-12)


def test_angular_momentum_change_is_the_torque_of_the_impulse(impacts, collided):
    moved, turned, _ = collided
    gained = np.einsum("nij,nj->ni", impacts.rotation, impacts.moments * turned)
    torque = np.cross(impacts.arm, moved)
    np.testing.assert_allclose(gained, torque, rtol=0.0, atol=1e-13)


def energies_gained(impacts, collided):
    """Kinetic energy after minus before, from the motion alone."""
    moved, turned, _ = collided
    gains = np.empty(len(impacts))
    for i in range(len(impacts)):
        before = motion_of(impacts.rotation[i], impacts.spin[i], impacts.velocity[i])
        after = before.copy()
        after[9:12] += moved[i]
        after[0:3] += turned[i]
        gains[i] = energy_of(impacts.moments[i], after) - energy_of(impacts.moments[i], before)
        gains[i] += 0.5 * (np.sum(after[9:12] ** 2) - np.sum(before[9:12] ** 2))
    return gains


def test_energy_never_grows_and_is_what_the_identity_says(impacts, collided, equations):
    gains = energies_gained(impacts, collided)
    assert gains.max() <= 1e-12
    approach = -impacts.contact_velocity[:, NORMAL]
    for i, (s_x, s_y, s_z) in enumerate(collided[0]):
        k, jump = equations[i][:2]
        gain = energy_gain(k, s_x, s_y, s_z, jump, approach[i])
        assert gain == pytest.approx(gains[i], rel=1e-9, abs=1e-12)


def test_energies_taken_are_those_of_the_laws_and_together_what_is_lost(impacts, collided):
    moved, turned, taken = collided
    fall, s = -impacts.contact_velocity[:, NORMAL], moved[:, NORMAL]
    normal = 0.5 * s * (fall - impacts.bounce())
    spin_change = np.einsum("nij,nj->ni", impacts.rotation, turned)
    change = moved + np.cross(spin_change, impacts.arm)
    slides = (impacts.contact_velocity + 0.5 * change)[:, TANGENTIAL]
    shear = impacts.friction() * s * np.sum(slides**2, axis=1)
    scale = np.sum(impacts.contact_velocity**2, axis=1)
    np.testing.assert_allclose(taken[:, 0] / scale, normal / scale, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(taken[:, 1] / scale, shear / scale, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(taken.sum(axis=1), -energies_gained(impacts, collided), atol=1e-12)
    assert taken.min() >= 0.0
    # Refused: parts that are exchanged, or taken at the velocity before.
    assert np.abs(taken[:, ::-1] - np.column_stack([normal, shear])).max() > 0.1
    assert np.abs(s * fall - normal).max() > 0.1


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
    moved, turned, taken = collided = collide_all(impacts, resolution)
    spin_change = np.einsum("nij,nj->ni", impacts.rotation, turned)
    change = moved + np.cross(spin_change, impacts.arm)
    approach = -impacts.contact_velocity[:, NORMAL]
    leaves = change[:, NORMAL] - approach

    assert impacts.bounce().max() < resolution
    at_floor = np.abs(leaves - resolution) <= 1e-12
    elastic = ~at_floor & (np.abs(leaves - approach) <= 1e-12)
    assert np.all(at_floor | elastic)
    gains = energies_gained(impacts, collided)
    assert gains.max() <= 1e-12
    # what a lifted bounce gives is taken off the tangential part
    np.testing.assert_allclose(taken.sum(axis=1), -gains, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(taken[at_floor & (approach < resolution), 0], 0.0)
    assert taken[:, 0].min() == 0.0
    assert taken[:, 1].min() >= -1e-15
    # both ways out were met, and the elastic one only where the floor would have added energy
    assert np.sum(at_floor) > 500
    assert np.sum(elastic) > 100
    k, mobility = impacts.friction(), impacts.mobility()
    for i in np.flatnonzero(elastic):
        u, v, w = impacts.contact_velocity[i].tolist()
        s_x, s_y, s_z = impulse(k[i], resolution - v, mobility_tuple(mobility[i]), u, w)
        assert energy_gain(k[i], s_x, s_y, s_z, resolution - v, -v) > 0.0


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
