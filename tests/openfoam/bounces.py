"""The wall case without OpenFOAM: free flight in a box, and `Table.rebound` at each wall."""

import numpy as np
import shots

#: Corners of the box [m].
LOWER, UPPER = np.array([-0.4, 0.0, -0.4]), np.array([0.4, 0.4, 0.4])


def _next_wall(position, velocity):
    """Time to the next wall [s], its axis, and whether it is the upper one."""
    upper = velocity > 0.0
    distance = np.where(upper, UPPER, LOWER) - position
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.where(velocity == 0.0, np.inf, distance / velocity)
    axis = times.argmin(axis=1)
    row = np.arange(len(axis))
    return times[row, axis], axis, upper[row, axis]


def _mirror(velocity, omega, rows, axis):
    """Reflect: a velocity's component along the axis turns its sign, a spin's two others."""
    velocity[rows, axis] *= -1.0
    omega[np.ix_(rows, [k for k in range(3) if k != axis])] *= -1.0


def replay(table, started, end, decay=0.0, symmetry_axis=-1):
    """Follow parcels through the box, from wall to wall.

    Parameters
    ----------
    table : sampler.Table
    started : Shots
    end : float
        Time [s].
    decay : float
        Rate [1/s] at which the gas slows the spin down.
    symmetry_axis : {0, 1, 2}, optional
        Axis whose two walls are symmetry planes; -1: none.

    Returns
    -------
    velocity, omega : arrays, shape (n, 3)
        At the end, m/s and rad/s.
    hits : int array, shape (n,)
    """
    position, velocity = started.position.copy(), started.velocity.copy()
    omega = np.zeros_like(velocity)
    left = np.full(len(position), end)
    hits = np.zeros(len(position), dtype=np.int64)
    while True:
        time, axis, upper = _next_wall(position, velocity)
        going = np.flatnonzero(time < left)
        if going.size == 0:
            return velocity, omega * np.exp(-decay * left)[:, None], hits
        time, axis, upper = time[going], axis[going], upper[going]
        position[going] += velocity[going] * time[:, None]
        left[going] -= time
        omega[going] *= np.exp(-decay * time)[:, None]
        # on the wall exactly, so that the next wall is another one
        position[going, axis] = np.where(upper, UPPER[axis], LOWER[axis])
        mirrored = going[axis == symmetry_axis]
        _mirror(velocity, omega, mirrored, symmetry_axis)
        met = axis != symmetry_axis
        going, axis, upper = going[met], axis[met], upper[met]
        normal = np.zeros((going.size, 3))
        normal[np.arange(going.size), axis] = np.where(upper, -1.0, 1.0)
        lid = (axis == 1) & upper
        velocity[going], omega[going] = shots.rebound(
            table,
            velocity[going],
            normal,
            omega[going],
            index=going,
            hit=hits[going],
            wall_velocity=shots.WALL_VELOCITY[lid.astype(int)],
        )
        hits[going] += 1
