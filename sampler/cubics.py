"""Cubics through the normal quantile function, from which a draw takes its normals.

They are made while a table is loaded, without anything compiled; `sampler.normal` evaluates them.
"""

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

#: Pieces of an octave, and octaves from 1/2 to 2^31.
PIECES = 8
_OCTAVES = 32


def normal_table() -> NDArray[np.float32]:
    """Cubics for `sampler.normal.normal_of_word`.

    Returns
    -------
    float32 array, shape (257, 4)
        Row ``8 * octave + piece``, octaves from 1/2 upwards: coefficients of 1, t, t^2, t^3 on
        [0, 1), through the quantile function at the Chebyshev points. The last row, of which only
        t = 0 is met, stands for the middle, 0.
    """
    points = 0.5 - 0.5 * np.cos(np.pi * (np.arange(4) + 0.5) / 4)
    inverse = np.linalg.inv(np.vander(points, increasing=True))
    # the same algorithm in plain Python: a first kernel would cost more than the whole loading
    quantile = NormalDist().inv_cdf
    table = np.zeros((_OCTAVES * PIECES + 1, 4))
    for row in range(_OCTAVES * PIECES):
        octave, piece = divmod(row, PIECES)
        # half the distance from the end, in units of 2^-32
        half = 2.0 ** (octave - 1) * (1.0 + (piece + points) / PIECES)
        table[row] = inverse @ [quantile(n * 2.0**-32) for n in half]
    return table.astype(np.float32)
