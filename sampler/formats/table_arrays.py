"""What the kernels need of a table: plain numbers and arrays, arranged for few cache misses."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.channels import MOST_NAMES

#: Least and largest speed, m/s, of a table whose rebounds do not depend on the speed: any that is
#: positive and finite. Not the limits of the numbers, which compilers may take for granted.
ANY_SPEED = (1e-300, 1e300)

#: Rows of a factor that are worked out side by side, those that a table lacks included.
LANES = MOST_NAMES

#: Rounding of a unit conversion: an excess below this, relative, is no excess.
ROUNDING = 1e-12


def record_stride(channels: int) -> int:
    """Numbers of a component's record: a power of two, so that none straddles a cache line."""
    needed = 1 + channels + channels * (channels + 1) // 2
    return 1 << (needed - 1).bit_length()


class Axis(NamedTuple):
    """One axis of the node grid, for look-up in constant time.

    Attributes
    ----------
    first, last : float
        Ends of the axis, rad or m/s.
    low, high : float
        What is not outside yet: the ends with the rounding of a unit conversion, or `ANY_SPEED`.
    origin, scale : float
        First value of the coordinate table, and its steps per rad or m/s; 0 on an axis of one
        value.
    offset, nodes : int
        Number of the first node and how many there are.
    coordinate : float64 array, shape (n_grid,)
        Fractional number of the node at equal steps; in a pruned table it goes beyond the nodes.
    """

    first: float
    last: float
    low: float
    high: float
    origin: float
    scale: float
    offset: int
    nodes: int
    coordinate: NDArray[np.float64]


class TableArrays(NamedTuple):
    """What the kernels need of a table; may be passed to any ``@numba.njit`` function.

    All arrays but `normals` are flat. Below, a table has I x J nodes, max(I - 1, 1) x max(J - 1, 1)
    cells between them, Q classes of rebounds, K components a node, and N channels, of which M have
    marginals. The tuples have a length that the compiler knows.

    Attributes
    ----------
    alpha, speed : Axis
        Axes of the node grid: impact angle in rad, impact speed in m/s.
    variate_max, variate_scale : float
        Knots of the quantile functions: last mixture variate, knots per unit variate.
    n_knots : int
    n_components, n_classes, n_marginals, stride : int
        K (components of the mixture), Q, M, and the numbers of one component's record.
    channels : tuple of N int
        Channel (see `sampler.formats.channels`) that each row of a component's factor stands for.
    marginals : tuple of N int
        Row among the M marginals of each channel; -1 for one that only carries dependence.
    columns : tuple of int
        Component of the state in each column that `Table.sample` returns.
    normals : float32 array, shape (257, 4)
        See `sampler.formats.image.normal_table`.
    alias : uint32 array, I J K
        Upper half: probability to stay in the column, in units of 2**-16; lower half: component
        that takes the rest.
    first_of_class : uint16 array, I J Q
    components : int16 array, I J K stride + 8
        Records: probability of reflection, N means, N (N + 1) / 2 factors (columns packed: L00,
        L10, ..., L11, ...), all in units of 1/4096, then padding. A record of a full table is a
        cache line. Eight zeros follow the last one, because eight rows are read at once.
    spans : float64 array, cells Q M 2
        Smallest quantile of a channel at the four nodes of a cell, and size of its steps.
    quantiles : uint16 array, cells Q M n_knots 4
        In these steps: the four nodes' values at one knot lie side by side, in the order (lower,
        lower), (lower, upper), (upper, lower), (upper, upper) of angle and speed, so that one
        interpolation reads 16 neighbouring bytes.
    valid_speed : tuple of two float
        Impact speeds, m/s, between which the laws of the pair were measured; `ANY_SPEED` where that
        is not known. Draws at others are counted as extrapolated.
    spin : int64 array
        The law of particles that arrive spinning: see `sampler.formats.spin_buffer`.
    experts : int16 array
    spin_quantiles : uint16 array
        Experts and quantiles of the spin law, as of `sampler.formats.bounds.SpinArrays`.
    """

    alpha: Axis
    speed: Axis
    variate_max: float
    variate_scale: float
    n_knots: int
    n_components: int
    n_classes: int
    n_marginals: int
    stride: int
    channels: tuple[int, ...]
    marginals: tuple[int, ...]
    columns: tuple[int, ...]
    normals: NDArray[np.float32]
    alias: NDArray[np.uint32]
    first_of_class: NDArray[np.uint16]
    components: NDArray[np.int16]
    spans: NDArray[np.float64]
    quantiles: NDArray[np.uint16]
    valid_speed: tuple[float, float]
    spin: NDArray[np.int64]
    experts: NDArray[np.int16]
    spin_quantiles: NDArray[np.uint16]


def bytes_of(value: Any) -> int:
    """Bytes of all arrays in nested tuples."""
    if isinstance(value, tuple):
        return sum(bytes_of(part) for part in value)
    return value.nbytes if isinstance(value, np.ndarray) else 0


def same(one: Any, other: Any) -> bool:
    """Whether nested tuples hold equal arrays and values."""
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return np.array_equal(one, other) if isinstance(one, np.ndarray) else one == other
