"""From the spin law of a table file to the arrays of the kernels."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import (
    EXPERT_STRIDE,
    LANES,
    MOST_SPEED_SCALE,
    N_FACTORS,
    N_FEATURES,
    N_INPUTS,
    N_OUTCOMES,
    ROUNDING,
    SpinArrays,
)
from sampler.formats.grain_law import grain_law, no_grains
from sampler.formats.hdf5 import TableContents
from sampler.formats.packing_memory import aligned

#: Steps of the quantiles of a leaf.
_STEPS = 65535

#: Relative rounding, in single precision, that must not take a draw beyond the largest quantile.
_MARGIN = 1e-6


def _flat(values: NDArray[Any], dtype: type) -> NDArray[Any]:
    """Copy of an array, flat and beginning on a cache line."""
    flat = aligned((values.size,), dtype)
    flat[:] = values.reshape(-1)
    return flat


def expert_records(mean: NDArray[np.int16], factor: NDArray[np.int16]) -> NDArray[np.int16]:
    """Means and factors of each expert side by side."""
    count = mean.shape[0] * mean.shape[1]
    flat = aligned((count * EXPERT_STRIDE + LANES,), np.int16)
    records = flat[: count * EXPERT_STRIDE].reshape(count, EXPERT_STRIDE)
    means = N_FEATURES * N_OUTCOMES
    records[:, :means] = mean.reshape(count, means)
    # the file has the triangle row by row, a draw wants it column by column
    rows, columns = np.tril_indices(N_OUTCOMES)
    by_column = np.lexsort((rows, columns))
    records[:, means : means + N_FACTORS] = factor.reshape(count, N_FACTORS)[:, by_column]
    return flat


def _quantiles(quantiles: NDArray[np.float32]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Spans and 16-bit steps of the quantile functions of all leaves.

    The second knot of p_v is rounded up: it must stay above 0.
    """
    values = quantiles.astype(np.float64)
    least, largest = values[..., 0], values[..., -1]
    step = ((largest - least) * (1.0 - _MARGIN) / _STEPS).astype(np.float32).astype(np.float64)
    safe = np.where(step > 0.0, step, 1.0)[..., None]
    steps = np.minimum(np.rint((values - least[..., None]) / safe), _STEPS)
    steps[:, 1, 1:] = np.maximum(steps[:, 1, 1:], 1.0)
    spans = np.stack([least, step], axis=-1)
    return _flat(spans, np.float32), _flat(steps, np.uint16)


def _inputs(contents: TableContents) -> NDArray[np.float32]:
    both = np.concatenate([contents["spin/centre"], contents["spin/scale"]], axis=1)
    return _flat(both.reshape(-1, 2 * N_INPUTS), np.float32)


def _no_law() -> SpinArrays:
    """Spin law of a table that has none."""
    reals, shorts = np.zeros(0, np.float32), np.zeros(0, np.int16)
    return SpinArrays(
        *(0, 0, 0),
        *(0.0,) * 10,
        no_grains(),
        np.zeros(0, np.int64),
        np.zeros((0, 2, 2)),
        np.zeros(0, np.int32),
        np.zeros(0, np.int8),
        np.zeros(0),
        np.zeros(0, np.int32),
        reals,
        shorts,
        shorts,
        shorts,
        reals,
        np.zeros(0, np.uint16),
    )


def _speed_scale(coefficient: float, exponent: float, largest: float) -> float:
    """Give k V_e^n of the largest V_e; where it is large the coordinate is 0 either way."""
    with np.errstate(over="ignore"):
        return min(float(coefficient * largest**exponent), MOST_SPEED_SCALE)


def spin_arrays(contents: TableContents) -> SpinArrays:
    """Arrange the spin law of a table for the kernels.

    Parameters
    ----------
    contents : TableContents

    Returns
    -------
    SpinArrays
    """
    if not contents.has_spin:
        return _no_law()
    alpha = np.deg2rad(contents["spin/alpha_range_deg"])
    speed = contents["spin/speed_range"]
    low, high = 1.0 - ROUNDING, 1.0 + ROUNDING
    coefficient, exponent = contents["spin/speed_coordinate"]
    spans, quantiles = _quantiles(contents["spin/quantiles"])
    return SpinArrays(
        n_shapes=len(contents["spin/shape_codes"]),
        n_knots=contents["spin/quantiles"].shape[-1],
        serves_all=0,
        alpha_first=float(alpha[0]),
        alpha_last=float(alpha[1]),
        alpha_low=float(alpha[0] * low),
        alpha_high=float(alpha[1] * high),
        speed_first=float(speed[0]),
        speed_last=float(speed[1]),
        speed_low=float(speed[0] * low),
        speed_high=float(speed[1] * high),
        speed_scale=_speed_scale(coefficient, exponent, speed[1]),
        speed_exponent=float(exponent),
        grains=grain_law(
            contents["spin/shape_codes"],
            contents["spin/shape_weights"],
            contents["spin/aspect"],
            contents["spin/ratio_range"],
        ),
        shape_codes=contents["spin/shape_codes"].astype(np.int64),
        ratio_range=contents["spin/ratio_range"].copy(),
        roots=contents["spin/roots"].copy(),
        node_axis=contents["spin/node_axis"].copy(),
        node_cut=contents["spin/node_cut"].copy(),
        node_child=contents["spin/node_child"].reshape(-1).copy(),
        inputs=_inputs(contents),
        group_gates=_flat(contents["spin/group_gate"], np.int16),
        gates=_flat(contents["spin/gate"], np.int16),
        experts=expert_records(contents["spin/mean"], contents["spin/factor"]),
        spans=spans,
        quantiles=quantiles,
    )
