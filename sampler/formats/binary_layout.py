"""The layout of a binary table (.rbt): the one description that writer, reader and pages follow.

A binary table is what a draw reads, so that a program in C maps the file and draws. It begins
with a header of fixed size, `HEADER`; the arrays of `ARRAYS` follow, each at an offset that is a
multiple of `ALIGNMENT`. All numbers are little-endian. `tools/generated_code.py` writes
the parts of the C header and of the Fortran module that follow from it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sampler.formats.bounds import (
    GROUP_SIZE,
    N_EXPERTS,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_KAPPA_QUANTILES,
    N_OUTCOMES,
    N_OUTCOMES_WITH_WORKS,
    PAIR_BYTES,
    expert_stride,
)
from sampler.formats.channels import MOST_NAMES
from sampler.formats.shape_codes import FIRST_MESH

#: Begins every file; its line ends show a transfer as text, its first byte one of seven bits.
MAGIC = b"\x89RBT\r\n\x1a\n"
#: Major and minor version of the format. A reader takes any minor version of its major version.
BINARY_VERSION = (1, 0)
#: Bytes to which every array is aligned: a cache line.
ALIGNMENT = 64
#: Files are smaller than this, so that 32-bit indices reach everything in them.
MOST_BYTES = 2**31


@dataclass(frozen=True)
class Field:
    """One field of the header.

    Attributes
    ----------
    name : str
    dtype : str
        As numpy's ``dtype.str``; ``S`` types are text in UTF-8 with zeros behind.
    count : int
        How many of them, side by side.
    meaning : str
    """

    name: str
    dtype: str
    count: int
    meaning: str


@dataclass(frozen=True)
class StoredArray:
    """One array of a binary table.

    Attributes
    ----------
    name : str
        Its offset is the header field ``at_`` + name.
    count : str
        Header field, a count: where it is 0 the table has no such array, whose offset is 0.
    dtype : str
    dims : tuple of str or int
        Names of header fields; ``n_cells`` is made from the numbers of nodes, ``expert_stride``
        from the number of outcomes.
    meaning : str
    extra : int
        Further numbers behind the last, which a draw may read but not use.
    """

    name: str
    count: str
    dtype: str
    dims: tuple[str | int, ...]
    meaning: str
    extra: int = 0


_NODES, _CELLS = ("n_alpha", "n_speed"), ("n_cells", "n_classes", "n_marginals")
_COORDINATE = "fractional number of the node at equal steps of the impact "
_ALIAS = "upper half: probability to stay in the column, 1/65536; lower half: the other component"
_RECORDS = (
    "records: probability of reflection, means, factors (columns packed), padding; 1/4096; "
    "8 zeros behind the last record"
)
_EXPERTS = (
    "records: coefficients of the means, 1/2048, by feature; factors (columns packed), 1/4096; "
    "padding; 8 zeros behind the last record"
)


def _arrays_with(count: str, *arrays: tuple[Any, ...]) -> list[StoredArray]:
    """List arrays that a table has if a count is not 0: name, type, dimensions, meaning, extra."""
    return [StoredArray(name, count, *rest) for name, *rest in arrays]


#: All arrays, in the order of a file: of the nodes, the grains, the spin law and the laws of
#: contact. Those of the law's shapes are of the shapes with a positive weight.
ARRAYS = (
    *_arrays_with("n_alpha",
        ("alpha_coordinate", "<f8", ("n_alpha_grid",), _COORDINATE + "angle"),
        ("speed_coordinate", "<f8", ("n_speed_grid",), _COORDINATE + "speed"),
        ("normals", "<f4", (257, 4), "cubics through the normal quantile function"),
        ("alias", "<u4", (*_NODES, "n_components"), _ALIAS),
        ("first_of_class", "<u2", (*_NODES, "n_classes"),
            "first mixture component of each class of rebounds"),
        ("components", "<i2", (*_NODES, "n_components", "stride"), _RECORDS, 8),
        ("spans", "<f8", (*_CELLS, 2), "least quantile of the cell, and size of a step"),
        ("quantiles", "<u2", (*_CELLS, "n_knots", 4),
            "steps of the quantiles at the four nodes of a cell"),
    ),
    *_arrays_with("n_shapes",
        ("shape_codes", "<i4", ("n_shapes",), f"shapes, from {FIRST_MESH} on meshes"),
        ("shape_shares", "<f8", ("n_shapes",), "running sum of their shares"),
        ("shape_ratios", "<f8", ("n_shapes", 2),
            "b/a and c/b of all their grains; 0: they are drawn"),
        ("ratio_range", "<f8", ("n_shapes", 2, 2),
            "smallest and largest b/a, then c/b, that were simulated"),
        ("shape_geometry", "<f8", ("n_shapes", 4),
            "volumes, moments and surfaces, as spin/shape_geometry"),
    ),
    *_arrays_with("n_leaves",
        ("shape_inertia", "<f8", ("n_shapes", 2),
            "g1, g3 of the largest and smallest moments of inertia"),
        ("kappa_quantiles", "<f8", ("n_shapes", N_KAPPA_QUANTILES),
            "kappa of rebounds at equal steps of probability"),
        ("roots", "<i4", ("n_shapes",), "first node of their trees"),
        ("node_axis", "<i1", ("n_nodes",), "quantity that a node compares"),
        ("node_cut", "<f8", ("n_nodes",), "values from here on go to the second child"),
        ("node_child", "<i4", ("n_nodes", 2), "a later node, or -1 - the number of a leaf"),
        ("inputs", "<f4", ("n_leaves", 2 * N_INPUTS), "centres of the inputs, then scales"),
        ("spin_spans", "<f4", ("n_leaves", "n_outcomes", 2),
            "least quantile, and size of a step"),
        ("spin_quantiles", "<u2", ("n_leaves", "n_outcomes", "n_spin_knots"),
            "steps of the quantiles"),
        ("group_gates", "<i2", ("n_leaves", N_FEATURES, N_GROUPS), "gates of the groups, 1/512"),
        ("gates", "<i2", ("n_leaves", N_GROUPS, N_FEATURES, GROUP_SIZE),
            "gates of the experts, 1/512"),
        ("experts", "<i2", ("n_leaves", N_EXPERTS, "expert_stride"), _EXPERTS, 8),
    ),
    *_arrays_with("n_law_parameters",
        ("laws", "<f8", ("n_law_parameters",), "laws of contact, as sphere/laws or spin/laws"),
    ),
)  # fmt: skip

#: Flag of a table whose rebounds do not depend on the speed.
SPEED_INDEPENDENT = 1
#: Flag of a table of spheres: rebounds follow from laws of contact, and there are no nodes.
SPHERES = 2

#: What is counted; `sampler.formats.bounds.LENGTHS` bounds the dimensions of arrays.
COUNTS = {
    "n_alpha": "nodes of the impact angle; of spheres 0, as all of the nodes and the spin law",
    "n_speed": "nodes of the impact speed",
    "n_alpha_grid": "entries of alpha_coordinate",
    "n_speed_grid": "entries of speed_coordinate",
    "n_knots": "knots of a quantile function",
    "n_components": "mixture components of a node",
    "n_classes": "classes of rebounds",
    "n_channels": "channels of a component",
    "n_marginals": "channels with quantile functions",
    "stride": "numbers in the record of a component",
    "n_columns": "variables of the state that the table gives",
    "n_shapes": "shapes of the grains; 0: no spin law, whose fields are 0",
    "n_nodes": "nodes of their trees",
    "n_leaves": "leaves of their trees",
    "n_spin_knots": "knots of a quantile function of the spin law",
    "n_outcomes": "outcomes of the spin law: 7, or 8 with works; expert_stride is "
    f"{expert_stride(N_OUTCOMES)} or {expert_stride(N_OUTCOMES_WITH_WORKS)}",
    "n_features": f"features of the spin law: {N_FEATURES}; a reader takes no other number",
    "n_experts": f"experts of a leaf: {N_EXPERTS}; a reader takes no other number",
    "n_law_parameters": "numbers of the laws of contact; 0: none",
    "flags": f"sum of {SPEED_INDEPENDENT}: rebounds do not depend on the speed, none is outside; "
    f"{SPHERES}: a table of spheres",
}

HEADER = (
    Field("magic", "S8", 1, "89 52 42 54 0D 0A 1A 0A"),
    Field("major", "<u2", 1, f"version, {BINARY_VERSION[0]}"),
    Field("minor", "<u2", 1, f"version, {BINARY_VERSION[1]}"),
    Field("header_bytes", "<u4", 1, "size of this header"),
    Field("file_bytes", "<u8", 1, f"size of the file, below {MOST_BYTES}"),
    Field("sha256", "u1", 32, "checksum of the file without these 32 bytes"),
    Field("content_sha256", "u1", 32, "checksum of the table (.h5) that this was made from"),
    Field("pair", f"S{PAIR_BYTES + 1}", 1, "name of the material pair, UTF-8, zeros behind it"),
    *(Field(name, "<u4", 1, meaning) for name, meaning in COUNTS.items()),
    Field("channels", "i1", MOST_NAMES, "channel of each row of a factor; -1 from n_channels on"),
    Field("marginals", "i1", MOST_NAMES, "number of its quantile function; -1: none"),
    Field("columns", "i1", MOST_NAMES, "variables of the state; -1 from n_columns on"),
    Field("alpha_offset", "<i4", 1, "number of the first node in alpha_coordinate"),
    Field("speed_offset", "<i4", 1, "number of the first node in speed_coordinate"),
    Field("alpha_first", "<f8", 1, "smallest impact angle, rad"),
    Field("alpha_last", "<f8", 1, "largest impact angle, rad"),
    Field("alpha_origin", "<f8", 1, "impact angle at the start of alpha_coordinate, rad"),
    Field("alpha_scale", "<f8", 1, "entries of alpha_coordinate per rad; 0: one angle only"),
    Field("speed_first", "<f8", 1, "smallest impact speed, m/s"),
    Field("speed_last", "<f8", 1, "largest impact speed, m/s"),
    Field("speed_origin", "<f8", 1, "impact speed at the start of speed_coordinate, m/s"),
    Field("speed_scale", "<f8", 1, "entries of speed_coordinate per m/s; 0: one speed only"),
    Field("valid_speed", "<f8", 2, "impact speeds between which the pair's law was measured, m/s"),
    Field("least_inertia", "<f8", 1, "smallest moment of inertia of any grain over m a^2"),
    Field("variate_max", "<f8", 1, "mixture variate of the last knot; the first is its negative"),
    Field("spin_alpha", "<f8", 2, "smallest and largest impact angle of the spin law, rad"),
    Field("spin_speed", "<f8", 2, "smallest and largest effective speed V_e, m/s"),
    Field("spin_size", "<f8", 2, "sizes of the spin a |Omega| / V that the spin law covers"),
    Field("spin_coordinate", "<f8", 2, "k V_e^n of the largest V_e, and n"),
    Field("aspect", "<f8", 8, "laws of b/a and c/b: mean, deviation, probabilities of the ends"),
    *(Field(f"at_{array.name}", "<u8", 1, f"offset of {array.name}") for array in ARRAYS),
)

#: The header as numpy reads it: packed, and every field naturally aligned.
HEADER_DTYPE = np.dtype([(f.name, f.dtype, (f.count,) if f.count > 1 else ()) for f in HEADER])


def field_offset(name: str) -> int:
    """Find the offset of a field of the header."""
    fields = HEADER_DTYPE.fields
    assert fields is not None
    return fields[name][1]


def layout_text() -> str:
    """Write the lists of fields of a binary table as two blocks of text, for the page."""
    fields = [("offset", "field", "type", "meaning")]
    for field in HEADER:
        kind = field.dtype.strip("<") + (f" x {field.count}" if field.count > 1 else "")
        if not field.name.startswith("at_"):
            fields.append((str(field_offset(field.name)), field.name, kind, field.meaning))
    arrays = [("at", "array", "type and shape", "meaning")]
    for array in ARRAYS:
        kind = f"{array.dtype.strip('<')} [{', '.join(map(str, array.dims))}]"
        place = field_offset(f"at_{array.name}")
        arrays.append((str(place), array.name, kind, array.meaning))
    return _block(fields) + "\n" + _block(arrays)


def _block(rows: Sequence[tuple[str, ...]]) -> str:
    """Write rows as a block of text in columns."""
    widths = [max(len(row[k]) for row in rows) for k in range(3)]
    lines = ["  ".join((*map(str.ljust, row, widths), row[3])) for row in rows]
    return "```text\n" + "\n".join(lines) + "\n```\n"
