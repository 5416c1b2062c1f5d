"""One collision by other means: matrices in wall axes, and bisection of the scalar equation.

Works on many impacts at once and shares no code with `tablegen.model.collision`. Equation numbers
are those of Panfilov & Tsirkunov 2022.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from motion_fixtures import random_rotations

TANGENTIAL = [0, 2]
NORMAL = 1


def cross_matrices(r):
    """Matrices [r] with [r] v = r x v; r is (n, 3)."""
    zero = np.zeros(len(r))
    x, y, z = r.T
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


@dataclass(frozen=True)
class Impacts:
    """Bodies at the instant of contact; ``point`` and ``moments`` in body axes, the rest in wall.

    Attributes
    ----------
    rotation : (n, 3, 3), moments, point, velocity, spin : (n, 3)
    """

    rotation: np.ndarray
    moments: np.ndarray
    point: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray

    def __len__(self):
        return len(self.moments)

    def __getitem__(self, chosen):
        return Impacts(
            self.rotation[chosen],
            self.moments[chosen],
            self.point[chosen],
            self.velocity[chosen],
            self.spin[chosen],
        )

    @cached_property
    def arm(self):
        """Contact point from the centre, wall axes."""
        return np.einsum("nij,nj->ni", self.rotation, self.point)

    @cached_property
    def inverse_inertia(self):
        """Inverse inertia tensor, wall axes."""
        return np.einsum("nik,nk,njk->nij", self.rotation, 1.0 / self.moments, self.rotation)

    @cached_property
    def mobility(self):
        """A = I - [r] J^-1 [r]: what an impulse does to the contact velocity, (3) and (4)."""
        arms = cross_matrices(self.arm)
        return np.eye(3) - arms @ self.inverse_inertia @ arms

    @cached_property
    def contact_velocity(self):
        """Contact velocity, equation (2)."""
        return self.velocity + np.cross(self.spin, self.arm)

    def restitution(self, law, speed):
        """Restitution coefficient a_nc, equation (6)."""
        size = np.linalg.norm(self.contact_velocity, axis=1)
        drop = 1.0 - np.exp(-law.coefficient * (speed * size) ** law.exponent)
        return 1.0 - drop * np.abs(self.contact_velocity[:, NORMAL]) / size

    def resistance(self, law):
        """Resistance coefficient C_f, equation (7)."""
        product = np.sum(self.arm * self.velocity, axis=1)
        length = np.linalg.norm(self.arm, axis=1) * np.linalg.norm(self.velocity, axis=1)
        return law.factor * np.exp(law.strength * product / length)

    def jump(self, law, speed):
        """Change of the normal contact velocity, first of equations (5)."""
        return -(1.0 + self.restitution(law, speed)) * self.contact_velocity[:, NORMAL]

    def friction(self, law):
        """k = C_f / |V_c|."""
        return self.resistance(law) / np.linalg.norm(self.contact_velocity, axis=1)


def tangential(impacts, k, s):
    """Tangential impulse that goes with normal impulses s: a 2 x 2 linear system each."""
    block = impacts.mobility[:, TANGENTIAL][:, :, TANGENTIAL]
    coupling = impacts.mobility[:, TANGENTIAL, NORMAL]
    ks = (k * s)[:, np.newaxis]
    right = -ks * (impacts.contact_velocity[:, TANGENTIAL] + 0.5 * s[:, np.newaxis] * coupling)
    matrix = np.eye(2) + 0.5 * ks[..., np.newaxis] * block
    return np.linalg.solve(matrix, right[..., np.newaxis])[..., 0]


def normal_balance(impacts, k, jump, s):
    """f(s) of the scalar equation: negative below the root, positive above."""
    coupling = impacts.mobility[:, TANGENTIAL, NORMAL]
    drag = np.sum(coupling * tangential(impacts, k, s), axis=1)
    return impacts.mobility[:, NORMAL, NORMAL] * s + drag - jump


def solve(impacts, law, speed):
    """Velocity change (n, 3) of each impact, by bisection of the scalar equation."""
    k, jump = impacts.friction(law), impacts.jump(law, speed)
    low, high = np.zeros(len(impacts)), jump.copy()
    while np.any(short := normal_balance(impacts, k, jump, high) < 0.0):
        high = np.where(short, 2.0 * high, high)
    for _ in range(200):
        middle = 0.5 * (low + high)
        below = normal_balance(impacts, k, jump, middle) < 0.0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    s = 0.5 * (low + high)
    sides = tangential(impacts, k, s)
    return np.column_stack([sides[:, 0], s, sides[:, 1]])


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
    return impacts[impacts.contact_velocity[:, NORMAL] < -1e-6]
