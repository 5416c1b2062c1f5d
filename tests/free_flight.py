"""Fly particles through a box without gas, from wall to wall, with a rebound at each wall."""

import numpy as np


def _next_wall(position, velocity, lower, upper):
    """Compute time to the next wall [s], axis of its normal, and whether it is the upper wall."""
    upwards = velocity > 0.0
    distance = np.where(upwards, upper, lower) - position
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.where(velocity == 0.0, np.inf, distance / velocity)
    axis = times.argmin(axis=1)
    row = np.arange(len(axis))
    return times[row, axis], axis, upwards[row, axis]


def _mirror(velocity, omega, rows, axes):
    """Mirror at a wall: a velocity changes sign along the axis, a spin along the two other axes."""
    velocity[rows, axes] *= -1.0
    omega[rows] *= -1.0
    omega[rows, axes] *= -1.0


def _keep(rows, omega, inertia, time):
    """Return the spins unchanged."""
    return omega


def fly(start, end, box, rebound, slow=_keep, symmetry_axes=()):
    """Follow particles without spin from ``start``, positions and velocities (n, 3), to a time [s].

    ``box`` is its lower and upper corner; walls normal to ``symmetry_axes`` are symmetry planes.
    ``rebound`` (rows, normal, velocity, omega, inertia, hits) returns velocity, omega and inertia
    after the hits of some particles on walls, whose normals point into the gas. ``slow`` (rows,
    omega, inertia, time) returns the omega that the gas leaves. Inertias are over m a^2, 0 before
    the first wall. Returns velocity and omega (n, 3), inertia and hits (n,) at the end.
    """
    position, velocity = start[0].copy(), start[1].copy()
    omega, inertia = np.zeros_like(velocity), np.zeros(len(velocity))
    rows = np.arange(len(velocity))
    left = np.full(len(position), end)
    hits = np.zeros(len(position), dtype=np.int64)
    while True:
        time, axis, upper = _next_wall(position, velocity, *box)
        going = np.flatnonzero(time < left)
        if going.size == 0:
            return velocity, slow(rows, omega, inertia, left), inertia, hits
        time, axis, upper = time[going], axis[going], upper[going]
        position[going] += velocity[going] * time[:, None]
        left[going] -= time
        omega[going] = slow(going, omega[going], inertia[going], time)
        # on the wall exactly, so that the next wall is another one
        position[going, axis] = np.where(upper, box[1][axis], box[0][axis])
        met = ~np.isin(axis, symmetry_axes)
        _mirror(velocity, omega, going[~met], axis[~met])
        going, axis, upper = going[met], axis[met], upper[met]
        normal = np.zeros((going.size, 3))
        normal[np.arange(going.size), axis] = np.where(upper, -1.0, 1.0)
        velocity[going], omega[going], inertia[going] = rebound(
            going, normal, velocity[going], omega[going], inertia[going], hits[going]
        )
        hits[going] += 1
