"""One collision: its change of velocity agrees with the readable reference."""

from dataclasses import dataclass

import numpy as np
import pytest
import reference_model as reference
from motion_fixtures import LAW, motion_of, random_rotations

from tablegen.model.collision import positive_root
from tablegen.model.rebound import apply_collision
from tablegen.model.rotation import ORDER

SPEED = 200.0
#: A resolution that no bounce of the sample falls below.
NO_FLOOR = 1e-300
NORMAL = 1


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
    impacts = Impacts(rotation, moments, point, velocity, spin)
    approaching = impacts.contact_velocity[:, NORMAL] < -1e-6
    return Impacts(*(rows[approaching] for rows in vars(impacts).values()))


def mobility_tuple(matrix):
    """A_xx, A_xy, A_xz, A_yy, A_yz, A_zz of a symmetric matrix."""
    return tuple(matrix[np.triu_indices(3)].tolist())


def collide_all(impacts, resolution):
    """Velocity changes by the kernel, wall axes."""
    moved, series = np.empty((len(impacts), 3)), np.empty((9, ORDER + 1))
    for i in range(len(impacts)):
        motion = motion_of(impacts.rotation[i], impacts.spin[i], impacts.velocity[i])
        before, point = motion.copy(), impacts.point[i].copy()
        moments = tuple(impacts.moments[i].tolist())
        apply_collision(LAW, SPEED, resolution, moments, point, motion, series)
        moved[i] = motion[9:12] - before[9:12]
    return moved


def collide_by_reference(impacts, law):
    """Velocity changes of the centre by the readable reference, which bisects."""
    setup = reference.Setup(0.0, SPEED, resolution=NO_FLOOR)
    collisions = (
        reference.collide(law, setup, *impacts.of_reference(i)) for i in range(len(impacts))
    )
    return np.array([velocity for velocity, _ in collisions]) - impacts.velocity


def test_velocity_change_is_the_root_found_by_bisection():
    impacts = random_impacts(np.random.default_rng(20240501), 2000)
    collided = collide_all(impacts, NO_FLOOR)
    expected = collide_by_reference(impacts, reference.Law())
    size = np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(collided / size, expected / size, rtol=0.0, atol=1e-11)
    # another law gives another root, which the comparison above would see
    other = collide_by_reference(impacts, reference.Law(strength=0.999))
    assert np.abs(collided - other).max() > 1e-4


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
    computed = positive_root(c0, c1, c2, c3, start_over_root * root)
    assert computed == pytest.approx(root, rel=1e-11)
