"""Random impacts for tests of rebounds in the lab frame."""

import numpy as np


def impacts(n, seed=0):
    """Velocities (n, 3) in m/s towards walls with normals (n, 3) of any length."""
    rng = np.random.default_rng(seed)
    normal = rng.standard_normal((n, 3)) * 10.0 ** rng.uniform(-3, 3, (n, 1))
    velocity = rng.standard_normal((n, 3)) * 100.0
    velocity[np.einsum("nk,nk->n", velocity, normal) > 0.0] *= -1.0
    return velocity, normal
