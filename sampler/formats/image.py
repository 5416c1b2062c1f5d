"""The binary image of a table: its one layout in memory, and the bytes of a .rbt file.

`sampler.formats.binary_layout` describes the image; ``rbt_open_memory`` and ``rbt_open`` of the C
header read it. Equal tables give equal bytes.
"""

import hashlib
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.errors import InputError
from sampler.files import write_bytes
from sampler.formats.binary_layout import (
    ALIGNMENT,
    ARRAYS,
    BINARY_VERSION,
    HEADER_DTYPE,
    MAGIC,
    MOST_BYTES,
    SPEED_INDEPENDENT,
    SPHERES,
    field_offset,
)
from sampler.formats.bounds import (
    ANY_SPEED,
    LANES,
    MOST_SPEED_SCALE,
    N_EXPERTS,
    N_FEATURES,
    expert_stride,
    record_stride,
)
from sampler.formats.channels import CHANNELS, MOST_NAMES, VARIABLES
from sampler.formats.hdf5 import TableContents
from sampler.formats.layout import BY_SPHERE, SPHERE_DATASETS
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES

#: An image in memory: bytes that begin on a cache line.
Image = NDArray[np.uint8]

#: Largest of the 16-bit steps that quantiles are stored in.
_STEPS = 65535

#: Knots that are packed at a time: few enough for the processor's cache.
_BLOCK = 2**13

#: Relative rounding, in single precision, that must not take a draw beyond the largest quantile.
_MARGIN = 1e-6

_CHECKSUM_AT = field_offset("sha256")
_CHECKSUM = slice(_CHECKSUM_AT, _CHECKSUM_AT + 32)


#: Coefficients of the cubics, computed once by tests/sampler/make_normal_cubics.py: computed anew,
#: a few would differ in the last bit between processors, and with them every state.
_CUBICS = Path(__file__).with_name("normal_cubics.npy")


def normal_table() -> NDArray[np.float32]:
    """Load the cubics through the normal quantile function from which a draw takes its normals.

    Returns
    -------
    float32 array, shape (257, 4)
        Row ``8 * octave + piece``, octaves from 1/2 upwards: coefficients of 1, t, t^2, t^3 on
        [0, 1), through the quantile function at the Chebyshev points. The last row, of which only
        t = 0 is met, stands for the middle, 0.
    """
    return np.load(_CUBICS).astype(np.float32)


def aligned(size: int) -> Image:
    """Make zeroed bytes that begin on a cache line."""
    buffer = np.zeros(size + ALIGNMENT - 1, dtype=np.uint8)
    start = -buffer.ctypes.data % ALIGNMENT
    return buffer[start : start + size]


def table_image(contents: TableContents) -> Image:
    """Arrange the contents of a table file as the draw reads them.

    Parameters
    ----------
    contents : TableContents

    Returns
    -------
    uint8 array
        The bytes of a binary table, but for their checksum, of zeros; `write_binary_table` has it.

    Raises
    ------
    InputError
        If the table does not fit into the format, 2 GiB.
    """
    header, stored = _header(contents), _arrays(contents)
    end = HEADER_DTYPE.itemsize
    for array in ARRAYS:
        if array.name in stored:
            header[f"at_{array.name}"] = start = -(-end // ALIGNMENT) * ALIGNMENT
            end = start + stored[array.name].nbytes
    if end >= MOST_BYTES:
        raise InputError("table", f"{end} bytes", f"below {MOST_BYTES} in a binary table")
    header["file_bytes"] = end
    image = aligned(end)
    image[: HEADER_DTYPE.itemsize] = np.frombuffer(header.tobytes(), np.uint8)
    for name, values in stored.items():
        start = int(header[f"at_{name}"])
        image[start : start + values.nbytes] = values.reshape(-1).view(np.uint8)
    return image


def checksum(image: Image) -> bytes:
    """Compute the SHA-256 of everything in an image but its own field."""
    digest = hashlib.sha256(image[: _CHECKSUM.start].data)
    digest.update(image[_CHECKSUM.stop :].data)
    return digest.digest()


def header_of(image: Image) -> Any:
    """View the header of an image: a record with the fields of `HEADER`."""
    return image[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)[0]


def write_binary_table(path: str | Path, contents: TableContents) -> None:
    """Write a binary table (.rbt), whole or not at all.

    Raises
    ------
    InputError
        If the table does not fit into the format, or the path cannot be written.
    """
    image = table_image(contents)
    image[_CHECKSUM] = np.frombuffer(checksum(image), np.uint8)
    write_bytes(path, image.tobytes())


def _header(contents: TableContents) -> Any:
    """Fill the header but for offsets, size and checksum."""
    header = np.zeros((), HEADER_DTYPE)
    header["magic"], header["pair"] = MAGIC, contents.pair.encode()
    header["major"], header["minor"] = BINARY_VERSION
    header["header_bytes"] = HEADER_DTYPE.itemsize
    header["content_sha256"] = np.frombuffer(bytes.fromhex(contents.content_sha256), np.uint8)
    header["valid_speed"] = contents.valid_speed or (0.0, ANY_SPEED[1])
    header["least_inertia"] = contents.least_inertia
    spheres, channels, stored = contents.of_spheres, contents.channels, contents.marginals
    header["flags"] = SPEED_INDEPENDENT * contents.speed_independent + SPHERES * spheres
    header["n_columns"] = len(contents.variables)
    header["columns"] = _padded([VARIABLES.index(name) for name in contents.variables])
    header["channels"] = _padded([] if spheres else [CHANNELS.index(name) for name in channels])
    numbers = [stored.index(name) if name in stored else -1 for name in channels]
    header["marginals"] = _padded([] if spheres else numbers)
    fields: dict[str, Any] = {"n_law_parameters": _laws(contents).size}
    for axis in ("alpha", "speed"):
        fields |= axis_fields(contents, axis)
    fields |= _spin_fields(contents) if contents.has_spin else {}
    fields |= {} if spheres else _node_fields(contents)
    for name, value in fields.items():
        header[name] = value
    return header


def _padded(numbers: list[int]) -> list[int]:
    return [*numbers, *[-1] * (MOST_NAMES - len(numbers))]


def _node_fields(contents: TableContents) -> dict[str, Any]:
    """Make the fields of the nodes but those of their axes."""
    return {
        "n_knots": contents["marginals/variate_knots"].size,
        "n_components": contents["dependence/alias_index"].shape[-1],
        "n_classes": contents["dependence/first_of_class"].shape[-1],
        "n_marginals": len(contents.marginals),
        "n_channels": len(contents.channels),
        "stride": record_stride(len(contents.channels)),
        "variate_max": contents["marginals/variate_knots"][-1],
    }


def axis_fields(contents: TableContents, name: str) -> dict[str, Any]:
    """Make the fields of an axis, "alpha" or "speed", in rad or m/s; of spheres only its ends."""
    nodes, span = contents["axes/alpha_deg" if name == "alpha" else "axes/speed"], "speed_span"
    if name == "alpha":
        nodes, span = np.deg2rad(nodes), "alpha_span_deg"
    fields = {f"{name}_first": nodes[0], f"{name}_last": nodes[-1]}
    if contents.of_spheres:
        return fields
    ends, coordinate = contents[f"axes/{span}"], contents[f"axes/{name}_coordinate"]
    origin, end = map(float, np.deg2rad(ends) if name == "alpha" else ends)
    grid = np.linspace(origin, end, coordinate.size)
    return fields | {
        f"n_{name}": nodes.size,
        f"n_{name}_grid": coordinate.size,
        f"{name}_origin": origin,
        f"{name}_scale": (coordinate.size - 1) / (end - origin) if end > origin else 0.0,
        # the nodes of a pruned table keep the numbers that they had in the full one
        f"{name}_offset": round(float(np.interp(nodes[0], grid, coordinate))),
    }


def _arrays(contents: TableContents) -> dict[str, NDArray[Any]]:
    """Arrange all arrays that the table has."""
    stored = {} if contents.of_spheres else _node_arrays(contents)
    if contents.has_spin:
        stored |= _grain_arrays(contents)
        stored |= {} if contents.of_spheres else _spin_arrays(contents)
    laws = _laws(contents)
    return stored | ({"laws": laws} if laws.size else {})


def _laws(contents: TableContents) -> NDArray[np.float64]:
    """Find the laws of contact of a table; empty if it has none."""
    paths = (SPHERE_DATASETS[0].path, BY_SPHERE.path)
    return next((contents[path] for path in paths if path in contents.datasets), np.empty(0))


def _node_arrays(contents: TableContents) -> dict[str, NDArray[Any]]:
    """Arrange the arrays of the law of particles that arrive without spin."""
    spans, steps = pack_quantiles(contents["marginals/quantiles"])
    probability = contents["dependence/alias_probability"].astype(np.uint32)
    alias = (probability << np.uint32(16)) | contents["dependence/alias_index"]
    return {
        "alpha_coordinate": contents["axes/alpha_coordinate"],
        "speed_coordinate": contents["axes/speed_coordinate"],
        "normals": normal_table(),
        "alias": alias.astype(np.uint32),
        "first_of_class": contents["dependence/first_of_class"],
        "components": _records(contents),
        "spans": spans,
        "quantiles": steps,
    }


def _records(contents: TableContents) -> NDArray[np.int16]:
    """Put reflection probability, means and factors of each component side by side."""
    mean, factor = contents["dependence/mean"], contents["dependence/cholesky"]
    channels = mean.shape[-1]
    stride = record_stride(channels)
    nodes = mean.size // channels
    flat = np.zeros(nodes * stride + LANES, np.int16)
    records = flat[: nodes * stride].reshape(*mean.shape[:-1], stride)
    records[..., 0] = contents["dependence/reflection"]
    records[..., 1 : 1 + channels] = mean
    records[..., 1 + channels : 1 + channels + factor.shape[-1]] = factor[..., _by_column(channels)]
    return flat


def _by_column(rows: int) -> NDArray[np.int64]:
    """Order of a lower triangle by columns, as a draw reads it; the file has it by rows."""
    return np.lexsort(np.tril_indices(rows))


def _corners(n_alpha: int, n_speed: int) -> NDArray[np.int64]:
    """Find the four nodes of each cell: (cells, 4)."""
    numbers = np.arange(n_alpha * n_speed).reshape(n_alpha, n_speed)
    pairs = [numbers[np.ix_(i, j)] for i in _ends(n_alpha) for j in _ends(n_speed)]
    return np.stack(pairs, axis=-1).reshape(-1, 4)


def _ends(nodes: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Give lower and upper node of each interval; an axis of one node has one, with equal ends."""
    lower = np.arange(max(nodes - 1, 1))
    return lower, np.minimum(lower + 1, nodes - 1)


def pack_quantiles(
    quantiles: NDArray[np.float32],
) -> tuple[NDArray[np.float64], NDArray[np.uint16]]:
    """Round the quantiles of the nodes to 16-bit steps between least and largest of each cell.

    Parameters
    ----------
    quantiles : float32 array, shape (n_alpha, n_speed, n_classes, n_marginals, n_knots)

    Returns
    -------
    spans : float64 array, shape (n_cells, n_classes, n_marginals, 2)
        Least quantile, and the size of a step.
    steps : uint16 array, shape (n_cells, n_classes, n_marginals, n_knots, 4)
        The values at the four nodes of a cell lie side by side: one interpolation reads 16
        neighbouring bytes.
    """
    n_alpha, n_speed, *per_node, knots = quantiles.shape
    corners, functions = _corners(n_alpha, n_speed), math.prod(per_node)
    cells = (len(corners), *per_node)
    spans, steps = np.empty((*cells, 2)), np.empty((*cells, knots, 4), np.uint16)
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
    """Compute spans (n, 2) and steps (n, n_knots, 4) of functions at the corners of their cells."""
    least, largest = quantiles.min(axis=(1, 2)), quantiles.max(axis=(1, 2))
    # a little short, so that rounding in a draw cannot lead beyond the largest quantile
    step = (largest - least) * (1.0 - _MARGIN) / _STEPS
    safe = np.where(step > 0.0, step, 1.0)[:, None, None]
    steps = np.minimum(np.rint((quantiles - least[:, None, None]) / safe), _STEPS)
    return np.stack([least, step], axis=-1), steps


def _drawn_shapes(contents: TableContents) -> NDArray[np.bool_]:
    """Mark the shapes that grains of the population have."""
    weights = contents["spin/shape_weights"]
    return np.asarray(weights > 0.0)


def _grain_arrays(contents: TableContents) -> dict[str, NDArray[Any]]:
    """Arrange the grains of the population: shapes of positive weight, and their fixed ratios."""
    drawn = _drawn_shapes(contents)
    codes, shares = contents["spin/shape_codes"][drawn], contents["spin/shape_weights"][drawn]
    own = (codes == SHAPE_CODES["sphere"]) | (codes >= FIRST_MESH)
    return {
        "shape_codes": codes,
        "shape_shares": np.cumsum(shares) / np.cumsum(shares)[-1],  # the last is exactly 1
        "shape_ratios": np.where(own[:, None], contents["spin/ratio_range"][drawn, :, 0], 0.0),
        "ratio_range": contents["spin/ratio_range"][drawn],
        "shape_geometry": contents["spin/shape_geometry"][drawn],
    }


def _spin_fields(contents: TableContents) -> dict[str, Any]:
    """Make the fields of the grains and of the spin law."""
    grains = {
        "n_shapes": np.count_nonzero(contents["spin/shape_weights"]),
        "aspect": contents["spin/aspect"].reshape(-1),
    }
    if contents.of_spheres:
        return grains
    coefficient, exponent = contents["spin/speed_coordinate"]
    last = contents["spin/speed_range"][1]
    with np.errstate(over="ignore"):  # where the product is large the coordinate is 0 either way
        scale = min(float(coefficient * last**exponent), MOST_SPEED_SCALE)
    leaves, outcomes, knots = contents["spin/quantiles"].shape
    return grains | {
        "n_nodes": contents["spin/node_axis"].size,
        "n_leaves": leaves,
        "n_outcomes": outcomes,
        "n_spin_knots": knots,
        "n_features": N_FEATURES,
        "n_experts": N_EXPERTS,
        "spin_alpha": np.deg2rad(contents["spin/alpha_range_deg"]),
        "spin_speed": contents["spin/speed_range"],
        "spin_size": contents["spin/spin_range"],
        "spin_coordinate": (scale, float(exponent)),
    }


def _spin_arrays(contents: TableContents) -> dict[str, NDArray[Any]]:
    """Arrange the arrays of the spin law; those by shape are of the shapes that grains have."""
    spans, quantiles = _pack_spin_quantiles(contents["spin/quantiles"])
    drawn = _drawn_shapes(contents)
    return {
        "shape_inertia": contents["spin/shape_inertia"][drawn],
        "kappa_quantiles": contents["spin/kappa_quantiles"][drawn],
        "roots": contents["spin/roots"][drawn],
        "node_axis": contents["spin/node_axis"],
        "node_cut": contents["spin/node_cut"],
        "node_child": contents["spin/node_child"],
        "inputs": np.concatenate([contents["spin/centre"], contents["spin/scale"]], axis=1),
        "spin_spans": spans,
        "spin_quantiles": quantiles,
        "group_gates": contents["spin/group_gate"],
        "gates": contents["spin/gate"],
        "experts": expert_records(contents["spin/mean"], contents["spin/factor"]),
    }


def expert_records(mean: NDArray[np.int16], factor: NDArray[np.int16]) -> NDArray[np.int16]:
    """Put means and factors of each expert side by side, with eight zeros behind the last one.

    `mean` has the shape (..., N_FEATURES, n_outcomes), `factor` (..., number of factors), rows
    packed; the result is flat, records of `expert_stride` numbers. A draw reads eight at once.
    """
    outcomes, factors = mean.shape[-1], factor.shape[-1]
    count, stride = factor.size // factors, expert_stride(outcomes)
    flat = np.zeros(count * stride + LANES, np.int16)
    records = flat[: count * stride].reshape(count, stride)
    means = N_FEATURES * outcomes
    records[:, :means] = mean.reshape(count, means)
    records[:, means : means + factors] = factor.reshape(count, -1)[:, _by_column(outcomes)]
    return flat


def _pack_spin_quantiles(quantiles: NDArray[np.float32]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Compute spans (float32) and 16-bit steps of the quantile functions of all leaves.

    The second knot of p_v is rounded up: it must stay above 0.
    """
    values = quantiles.astype(np.float64)
    least, largest = values[..., 0], values[..., -1]
    step = ((largest - least) * (1.0 - _MARGIN) / _STEPS).astype(np.float32).astype(np.float64)
    safe = np.where(step > 0.0, step, 1.0)[..., None]
    steps = np.minimum(np.rint((values - least[..., None]) / safe), _STEPS)
    steps[:, 1, 1:] = np.maximum(steps[:, 1, 1:], 1.0)
    spans = np.stack([least, step], axis=-1)
    return spans.astype(np.float32), steps.astype(np.uint16)
