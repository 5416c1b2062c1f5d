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


def replay(table, started, end):
    """Follow parcels through the box, from wall to wall.

    Parameters
    ----------
    table : sampler.Table
    started : Shots
    end : float
        Time [s].

    Returns
    -------
    velocity : array, shape (n, 3)
        At the end, m/s.
    hits : int array, shape (n,)
    """
    position, velocity = started.position.copy(), started.velocity.copy()
    left = np.full(len(position), end)
    hits = np.zeros(len(position), dtype=np.int64)
    while True:
        time, axis, upper = _next_wall(position, velocity)
        going = np.flatnonzero(time < left)
        if going.size == 0:
            return velocity, hits
        time, axis, upper = time[going], axis[going], upper[going]
        position[going] += velocity[going] * time[:, None]
        left[going] -= time
        # on the wall exactly, so that the next wall is another one
        position[going, axis] = np.where(upper, UPPER[axis], LOWER[axis])
        normal = np.zeros((going.size, 3))
        normal[np.arange(going.size), axis] = np.where(upper, -1.0, 1.0)
        lid = (axis == 1) & upper
        velocity[going], _ = table.rebound(
            velocity[going],
            normal,
            0.5 * shots.DIAMETER,
            seed=shots.SEED,
            index=going,
            hit=hits[going],
            wall_velocity=shots.WALL_VELOCITY[lid.astype(int)],
        )
        hits[going] += 1
