"""Rebounds that the simulation must not return: those that do not end, and those not finite."""

import numpy as np

from tablegen.model.coulomb import PIECE_ALARM
from tablegen.model.float_array import FloatArray
from tablegen.model.rebound import COLLISION_ALARM


def unfinished_error(particle: str) -> RuntimeError:
    """Make the error for a particle, described in words, that does not leave the wall."""
    return RuntimeError(
        f"{particle} is still in contact after {COLLISION_ALARM:,} collisions, or "
        f"{PIECE_ALARM:,} pieces of one; a larger contact_resolution ends a chain of collisions"
    )


def first_not_finite(*arrays: FloatArray) -> int:
    """Find the first row, in any of several arrays (n, k), with NaN or infinity; -1 if none."""
    bad_rows = [np.flatnonzero(~np.isfinite(array).all(axis=1)) for array in arrays]
    return min((int(rows[0]) for rows in bad_rows if rows.size), default=-1)
