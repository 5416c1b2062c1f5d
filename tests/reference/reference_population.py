"""Random particles of the paper's population, drawn with numpy.

Nothing is shared with `tablegen.model.random_particles`: other random numbers, rejection in place
of quantiles, quaternions in place of Shoemake's formula.
"""

import numpy as np
from numpy.typing import NDArray
from reference_model import SHAPES, SPHERE

Particles = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]


def draw_particles(rng: np.random.Generator, shape: str, count: int) -> Particles:
    """Shapes, aspect ratios and orientations of the paper's population.

    Parameters
    ----------
    rng : numpy.random.Generator
    shape : str
        A name of `reference_model.SHAPES`, or "mixture": the non-spherical ones in equal parts.
    count : int

    Returns
    -------
    tuple ((n,) int64, (n, 2) float64, (n, 3, 3) float64)
        Shape codes, b / a and c / b, rotations: as `reference_model.rebounds` takes them.
    """
    mixed = shape == "mixture"
    shapes = rng.integers(0, 4, count) if mixed else np.full(count, SHAPES[shape])
    # normal(0.8, 0.2), what falls outside [0.5, 1] drawn again
    ratios = rng.normal(0.8, 0.2, (count, 2))
    while np.any(outside := (ratios < 0.5) | (ratios > 1.0)):
        ratios[outside] = rng.normal(0.8, 0.2, np.count_nonzero(outside))
    ratios[shapes == SPHERE] = 1.0
    # a normally distributed quaternion has a uniform direction, so a uniform rotation
    quaternions = rng.normal(size=(4, count))
    w, x, y, z = quaternions / np.linalg.norm(quaternions, axis=0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return shapes, ratios, np.ascontiguousarray(np.transpose(rows, (2, 0, 1)))
