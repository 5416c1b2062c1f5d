"""Cubics through the normal quantile function, from which a draw takes its normals.

`sampler.drawing.normal` evaluates them. tests/sampler/make_normal_cubics.py wrote their
coefficients. Computed anew while a table is loaded, a few would differ in the last bit between
processors, and with them every state.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

#: Pieces of an octave, and octaves from 1/2 to 2^31.
PIECES = 8
OCTAVES = 32

#: File of the coefficients.
CUBICS = Path(__file__).with_name("normal_cubics.npy")


def normal_table() -> NDArray[np.float32]:
    """Cubics for `sampler.drawing.normal.normal_of_word`, the same bits on every machine.

    Returns
    -------
    float32 array, shape (257, 4)
        Row ``8 * octave + piece``, octaves from 1/2 upwards: coefficients of 1, t, t^2, t^3 on
        [0, 1), through the quantile function at the Chebyshev points. The last row, of which only
        t = 0 is met, stands for the middle, 0.
    """
    return np.load(CUBICS).astype(np.float32)
