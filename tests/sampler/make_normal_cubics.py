"""Cubics through the normal quantile function, which the runtime draws normal numbers from.

    python tests/sampler/make_normal_cubics.py

writes sampler/formats/normal_cubics.npy. The last bits of a few coefficients depend on the
logarithm and the linear algebra of the machine that makes them, so they are made once and shipped:
then the same keys give the same state on every processor. Run this again only when the draw is
meant to change; the known-answer vectors and every image (.rbt) hold the same cubics.
"""

from pathlib import Path
from statistics import NormalDist

import numpy as np

from sampler.formats import image

OCTAVES, PIECES = 32, 8


def cubics():
    """Coefficients (257, 4) in double precision: row 8 octave + piece, lowest power first."""
    points = 0.5 - 0.5 * np.cos(np.pi * (np.arange(4) + 0.5) / 4)
    inverse = np.linalg.inv(np.vander(points, increasing=True))
    quantile = NormalDist().inv_cdf
    table = np.zeros((OCTAVES * PIECES + 1, 4))
    for row in range(OCTAVES * PIECES):
        octave, piece = divmod(row, PIECES)
        # half the distance from the end, in units of 2^-32
        half = 2.0 ** (octave - 1) * (1.0 + (piece + points) / PIECES)
        table[row] = inverse @ [quantile(n * 2.0**-32) for n in half]
    return table


if __name__ == "__main__":
    np.save(Path(image.__file__).with_name("normal_cubics.npy"), cubics().astype("<f4"))
