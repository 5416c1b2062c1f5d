"""Support map: for each direction, the few vertices that can lie farthest along it.

Directions are put into the cells of a cube map: a cube around the origin, each side divided into
squares. A cell lists every vertex that supports the body in some direction up to ``slack`` away
from the cell. So the list found for a direction stays complete while the body turns by
``slack``, and a contact search over a grain of a thousand vertices looks at some ten of them.
The lists are made by `tablegen.config.support_map_builder`.
"""

import math
from typing import NamedTuple

import numpy as np

from tablegen.model.jit import kernel, no_refcount_inline_kernel


class SupportMap(NamedTuple):
    """Vertices near the lowest point, by direction.

    ``resolution`` is the number of cells along a side of the cube, 0 for a body that needs no
    map; ``slack`` [rad] is how far a direction may turn from its cell; ``points[starts[i] :
    starts[i + 1]]`` are the vertices of cell i: ``starts`` (6 resolution^2 + 1,) int64,
    ``points`` (k, 3) float64.
    """

    resolution: int
    slack: float
    starts: np.ndarray
    points: np.ndarray


#: Map of a body that needs none. Its slack limits no step.
NO_MAP = SupportMap(0, math.inf, np.zeros(1, dtype=np.int64), np.empty((0, 3)))


@kernel
def empty_map():
    """Make what `NO_MAP` is, with arrays that a kernel may pass on."""
    return SupportMap(0, np.inf, np.zeros(1, dtype=np.int64), np.empty((0, 3)))


def longest_list(support_map: SupportMap) -> int:
    """Vertices in the longest list of a map."""
    return int(np.diff(support_map.starts).max())


@no_refcount_inline_kernel
def _square(along, resolution):
    """Index of the interval of [-1, 1] that holds ``along``."""
    return min(int((along + 1.0) * 0.5 * resolution), resolution - 1)


@no_refcount_inline_kernel
def direction_cell(resolution, d1, d2, d3):
    """Cell of a direction.

    Cells are numbered by side (+x, -x, +y, -y, +z, -z), then along the next axis in cyclic
    order, then along the one after it. The direction needs no unit length.

    Parameters
    ----------
    resolution : int
        Cells along a side, positive.
    d1, d2, d3 : float
        Components, finite and not all zero.

    Returns
    -------
    int
        In 0 .. 6 resolution^2 - 1.
    """
    a1, a2, a3 = abs(d1), abs(d2), abs(d3)
    if a1 >= a2 and a1 >= a3:
        side, main, s, t = 0, d1, d2, d3
    elif a2 >= a3:
        side, main, s, t = 2, d2, d3, d1
    else:
        side, main, s, t = 4, d3, d1, d2
    if main < 0.0:
        side += 1
    scale = 1.0 / abs(main)
    row = _square(s * scale, resolution)
    return (side * resolution + row) * resolution + _square(t * scale, resolution)


@no_refcount_inline_kernel
def support_range(support_map, d1, d2, d3):
    """First and end row in ``support_map.points`` of the vertices to look at for a direction.

    They hold the supporting vertex of every direction up to ``support_map.slack`` away.

    Parameters
    ----------
    support_map : SupportMap
        With a positive resolution.
    d1, d2, d3 : float
        Direction in body axes; minus the wall normal for the lowest vertices.

    Returns
    -------
    tuple of two ints
    """
    cell = direction_cell(support_map.resolution, d1, d2, d3)
    return support_map.starts[cell], support_map.starts[cell + 1]
