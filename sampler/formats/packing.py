"""From the contents of a table file to the arrays of the kernels."""

import math

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import (
    ANY_SPEED,
    LANES,
    ROUNDING,
    Axis,
    TableArrays,
    record_stride,
)
from sampler.formats.channels import CHANNELS, VARIABLES
from sampler.formats.hdf5 import TableContents
from sampler.formats.image import normal_table, spin_arrays
from sampler.formats.packing_memory import aligned
from sampler.formats.spin_buffer import packed

#: Numbers of a cache line of 64 bytes, in 16 bits each.
_LINE = 32

#: Steps of the quantiles of a cell.
_STEPS = 65535

#: Knots of cells that are packed at a time: few enough for the cache, however large the table is.
_BLOCK = 2**13

#: Relative rounding, in single precision, that must not take a draw beyond the largest quantile.
_MARGIN = 1e-6


def _axis(
    nodes: NDArray[np.float64],
    span: NDArray[np.float64],
    coordinate: NDArray[np.float64],
    limits: tuple[float, float] | None = None,
) -> Axis:
    first, last = float(nodes[0]), float(nodes[-1])
    low, high = limits or (first * (1.0 - ROUNDING), last * (1.0 + ROUNDING))
    origin, end = ends = float(span[0]), float(span[1])
    scale = (coordinate.size - 1) / (end - origin) if end > origin else 0.0
    # the numbers of a pruned table's nodes go on from those that were left out
    offset = round(float(np.interp(first, np.linspace(*ends, coordinate.size), coordinate)))
    return Axis(first, last, low, high, origin, scale, offset, len(nodes), coordinate)


def _records(contents: TableContents) -> NDArray[np.int16]:
    """Reflection probability, means and factors of each component side by side."""
    mean, factor = contents["dependence/mean"], contents["dependence/cholesky"]
    channels = mean.shape[-1]
    stride = record_stride(channels)
    nodes = mean.size // channels
    flat = aligned((nodes * stride + LANES,), np.int16)
    records = flat[: nodes * stride].reshape(*mean.shape[:-1], stride)
    records[..., 0] = contents["dependence/reflection"]
    records[..., 1 : 1 + channels] = mean
    # the file has the triangle row by row, a draw wants it column by column
    rows, columns = np.tril_indices(channels)
    by_column = np.lexsort((rows, columns))
    records[..., 1 + channels : 1 + channels + len(rows)] = factor[..., by_column]
    return flat


def _corners(n_alpha: int, n_speed: int) -> NDArray[np.int64]:
    """Numbers of the four nodes of each cell: (cells, 4)."""
    numbers = np.arange(n_alpha * n_speed).reshape(n_alpha, n_speed)
    pairs = [numbers[np.ix_(i, j)] for i in _ends(n_alpha) for j in _ends(n_speed)]
    return np.stack(pairs, axis=-1).reshape(-1, 4)


def _ends(nodes: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Lower and upper node of each interval; an axis of one node has one, with equal ends."""
    lower = np.arange(max(nodes - 1, 1))
    return lower, np.minimum(lower + 1, nodes - 1)


def pack_quantiles(
    quantiles: NDArray[np.float32],
) -> tuple[NDArray[np.float64], NDArray[np.uint16]]:
    """Quantiles of the nodes as 16-bit steps between least and largest of each cell.

    Parameters
    ----------
    quantiles : float32 array, shape (n_alpha, n_speed, n_classes, n_marginals, n_knots)

    Returns
    -------
    spans : float64 array, shape (n_cells, n_classes, n_marginals, 2)
        Least quantile, and the size of a step.
    steps : uint16 array, shape (n_cells, n_classes, n_marginals, n_knots, 4)
    """
    n_alpha, n_speed, *per_node, knots = quantiles.shape
    corners, functions = _corners(n_alpha, n_speed), math.prod(per_node)
    cells = (len(corners), *per_node)
    spans, steps = np.empty((*cells, 2)), aligned((*cells, knots, 4), np.uint16)
    all_spans, all_steps = spans.reshape(-1, 2), steps.reshape(-1, knots, 4)
    rows, block = quantiles.reshape(-1, knots), max(1, _BLOCK // knots)
    for start in range(0, len(all_spans), block):
        part = slice(start, min(start + block, len(all_spans)))
        cell, function = np.divmod(np.arange(part.start, part.stop), functions)
        four = rows[corners[cell] * functions + function[:, None]]
        all_spans[part], all_steps[part] = _in_steps(four.transpose(0, 2, 1).astype(np.float64))
    return spans, steps


def _in_steps(
    quantiles: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Spans (n, 2) and steps (n, n_knots, 4) of functions at the corners of their cells."""
    least, largest = quantiles.min(axis=(1, 2)), quantiles.max(axis=(1, 2))
    # a little short, so that rounding in a draw cannot lead beyond the largest quantile
    step = (largest - least) * (1.0 - _MARGIN) / _STEPS
    safe = np.where(step > 0.0, step, 1.0)[:, None, None]
    steps = np.minimum(np.rint((quantiles - least[:, None, None]) / safe), _STEPS)
    return np.stack([least, step], axis=-1), steps


def table_arrays(contents: TableContents) -> TableArrays:
    """Arrange the contents of a table for the kernels.

    Parameters
    ----------
    contents : TableContents

    Returns
    -------
    TableArrays
    """
    variate = contents["marginals/variate_knots"]
    spans, steps = pack_quantiles(contents["marginals/quantiles"])
    probability = contents["dependence/alias_probability"].astype(np.uint32)
    alias = (probability << np.uint32(16)) | contents["dependence/alias_index"]
    channels, held = contents.channels, contents.marginals
    law = spin_arrays(contents)
    return TableArrays(
        alpha=_axis(
            np.deg2rad(contents["axes/alpha_deg"]),
            np.deg2rad(contents["axes/alpha_span_deg"]),
            contents["axes/alpha_coordinate"],
        ),
        speed=_axis(
            contents["axes/speed"],
            contents["axes/speed_span"],
            contents["axes/speed_coordinate"],
            ANY_SPEED if contents.speed_independent else None,
        ),
        variate_max=float(variate[-1]),
        variate_scale=(variate.size - 1) / (2.0 * float(variate[-1])),
        n_knots=variate.size,
        n_components=probability.shape[-1],
        n_classes=steps.shape[1],
        n_marginals=len(held),
        stride=record_stride(len(channels)),
        channels=tuple(CHANNELS.index(name) for name in channels),
        marginals=tuple(held.index(name) if name in held else -1 for name in channels),
        columns=tuple(VARIABLES.index(name) for name in contents.variables),
        normals=normal_table(),
        alias=alias.astype(np.uint32).reshape(-1),
        first_of_class=contents["dependence/first_of_class"].reshape(-1),
        components=_records(contents),
        spans=spans.reshape(-1),
        quantiles=steps.reshape(-1),
        valid_speed=contents.valid_speed or ANY_SPEED,
        spin=packed(law),
        experts=law.experts,
        spin_quantiles=law.quantiles,
    )


def kept_beside(contents: TableContents) -> dict[str, NDArray]:
    """Datasets that a loaded table keeps as they are: axes and measured accuracy."""
    paths = (
        path
        for path in contents.datasets
        if path.startswith(("axes/", "accuracy/", "spin_accuracy/"))
    )
    return {path: contents[path] for path in paths}
