"""The wall case without OpenFOAM: free flight in a box, and `Table.rebound` at each wall."""

import numpy as np
import shots
from free_flight import fly

#: Corners of the box [m].
LOWER, UPPER = np.array([-0.4, 0.0, -0.4]), np.array([0.4, 0.4, 0.4])


def replay(table, started, end, decay=0.0, symmetry_axes=(), roughness=None):
    """Follow parcels through the box, from wall to wall.

    Parameters
    ----------
    table : sampler.Table
    started : Shots
    end, decay, symmetry_axes
        As in `free_flight.fly`, which also says what is returned.
    roughness : float, optional
        As of `Table.rebound`.
    """

    def rebound(rows, normal, velocity, omega, hits):
        lid = normal[:, 1] < 0.0
        return shots.rebound(
            table,
            velocity,
            normal,
            omega,
            index=rows,
            hit=hits,
            wall_velocity=shots.WALL_VELOCITY[lid.astype(int)],
            roughness=roughness,
        )

    start = started.position, started.velocity
    return fly(start, end, (LOWER, UPPER), rebound, decay, symmetry_axes)
