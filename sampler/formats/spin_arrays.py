"""What the kernels need of a spin law: plain numbers and arrays, arranged for few cache misses."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import N_FACTORS, N_FEATURES, N_OUTCOMES
from sampler.formats.grain_law import GrainLaw

#: Numbers of an expert: coefficients of its means and its factor, five cache lines with padding.
EXPERT_STRIDE = -(-(N_FEATURES * N_OUTCOMES + N_FACTORS) // 32) * 32


class SpinArrays(NamedTuple):
    """Spin law of a table; one without has arrays of length 0, and `n_shapes` 0.

    All arrays but those of `grains` are flat. A law has S shapes, N nodes and L leaves; a leaf has
    G groups of E experts, and six quantile functions of K knots.

    Attributes
    ----------
    n_shapes, n_knots : int
        S, K.
    serves_all : int
        1: particles that arrive without spin are drawn from this law too, as in a table that was
        loaded with a population of its own; else 0.
    alpha_first, alpha_last, alpha_low, alpha_high : float
        Ends of the range of impact angles, rad, and what is not outside yet.
    speed_first, speed_last, speed_low, speed_high : float
        The same of the effective speed V_e, m/s.
    speed_scale, speed_exponent : float
        k times the n-th power of the largest V_e, and n, of the speed's coordinate exp(-k V_e^n).
    grains : GrainLaw
    shape_codes : int64 array, S
    ratio_range : float64 array, (S, 2, 2)
        Smallest and largest b/a, then c/b, that were simulated.
    roots : int32 array, S
    node_axis : int8 array, N
    node_cut : float64 array, N
    node_child : int32 array, 2 N
        A later node, or -1 - the number of a leaf.
    inputs : float32 array, L 14
        Middles, then factors, of the seven inputs.
    group_gates : int16 array, L F G
    gates : int16 array, L G F E
        Coefficients of the F features, in units of 1/512; those of one feature side by side.
    experts : int16 array, L G E stride + 8
        Records: coefficients of the F features for the six outcomes, in units of 1/2048, those of
        one feature side by side; then the factor, columns packed, in units of 1/4096; padding.
        Eight zeros follow the last one, because eight numbers are read at once.
    spans : float32 array, L 12
        Least quantile of each outcome, and size of its steps.
    quantiles : uint16 array, L 6 K
        In these steps.
    """

    n_shapes: int
    n_knots: int
    serves_all: int
    alpha_first: float
    alpha_last: float
    alpha_low: float
    alpha_high: float
    speed_first: float
    speed_last: float
    speed_low: float
    speed_high: float
    speed_scale: float
    speed_exponent: float
    grains: GrainLaw
    shape_codes: NDArray[np.int64]
    ratio_range: NDArray[np.float64]
    roots: NDArray[np.int32]
    node_axis: NDArray[np.int8]
    node_cut: NDArray[np.float64]
    node_child: NDArray[np.int32]
    inputs: NDArray[np.float32]
    group_gates: NDArray[np.int16]
    gates: NDArray[np.int16]
    experts: NDArray[np.int16]
    spans: NDArray[np.float32]
    quantiles: NDArray[np.uint16]
