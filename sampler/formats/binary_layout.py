"""The layout of a table image (.rbt): the one description that writer, readers and pages follow.

An image is `sampler.formats.table_arrays.TableArrays` as the draw wants it in memory, so that a
program in C maps the file and draws. It begins with a header of fixed size, `HEADER`, of which
`sampler/c/rebound_sampler.h` has the same as a struct; the arrays of `ARRAYS` follow, each at an
offset of its own that is a multiple of `ALIGNMENT`. All numbers are little-endian.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sampler.formats.channels import VARIABLES

#: Begins every image; its line ends tell of a transfer as text, its first byte of seven bits.
MAGIC = b"\x89RBT\r\n\x1a\n"
#: Major and minor version. A reader takes any minor version of its major version.
IMAGE_VERSION = (1, 0)
#: Bytes to which every array is aligned: a cache line.
ALIGNMENT = 64
#: Images are smaller than this, so that 32-bit indices reach everything in them.
MOST_BYTES = 2**31
#: Room for the names of channels and components.
MOST_NAMES = len(VARIABLES)


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
class ImageArray:
    """One array of the image.

    Attributes
    ----------
    name : str
        Its offset is the header field ``at_`` + name.
    dtype : str
    dims : tuple of str or int
        Names of header fields; ``n_cells`` is made from the numbers of nodes.
    meaning : str
    extra : int
        Further numbers behind the last, which a draw may read but not use.
    """

    name: str
    dtype: str
    dims: tuple[str | int, ...]
    meaning: str
    extra: int = 0


ARRAYS = (
    ImageArray(
        "alpha_coordinate",
        "<f8",
        ("n_alpha_grid",),
        "fractional number of the node at equal steps of the impact angle",
    ),
    ImageArray(
        "speed_coordinate",
        "<f8",
        ("n_speed_grid",),
        "fractional number of the node at equal steps of the impact speed",
    ),
    ImageArray("normals", "<f4", (257, 4), "cubics through the normal quantile function"),
    ImageArray(
        "alias",
        "<u4",
        ("n_alpha", "n_speed", "n_components"),
        "upper half: probability to stay in the column, 1/65536; lower half: the other component",
    ),
    ImageArray(
        "first_of_class",
        "<u2",
        ("n_alpha", "n_speed", "n_classes"),
        "first mixture component of each class of rebounds",
    ),
    ImageArray(
        "components",
        "<i2",
        ("n_alpha", "n_speed", "n_components", "stride"),
        "records: probability of reflection, means, factors (columns packed), padding; 1/4096; "
        "8 zeros behind the last record",
        extra=8,
    ),
    ImageArray(
        "spans",
        "<f8",
        ("n_cells", "n_classes", "n_marginals", 2),
        "least quantile of a cell, and size of its steps",
    ),
    ImageArray(
        "quantiles",
        "<u2",
        ("n_cells", "n_classes", "n_marginals", "n_knots", 4),
        "steps of the quantiles at the four nodes of a cell",
    ),
)

#: Flag of a table whose rebounds do not depend on the speed.
SPEED_INDEPENDENT = 1

_COUNTS = {
    "n_alpha": "nodes of the impact angle",
    "n_speed": "nodes of the impact speed",
    "n_alpha_grid": "entries of alpha_coordinate",
    "n_speed_grid": "entries of speed_coordinate",
    "n_knots": "knots of a quantile function",
    "n_components": "mixture components of a node",
    "n_classes": "classes of rebounds",
    "n_channels": "channels of a component",
    "n_marginals": "channels with quantile functions",
    "n_columns": "components of the state that the table gives",
    "stride": "numbers of the record of a component",
    "flags": f"{SPEED_INDEPENDENT}: rebounds do not depend on the speed, none is outside; else 0",
}

HEADER = (
    Field("magic", "S8", 1, "89 52 42 54 0D 0A 1A 0A"),
    Field("major", "<u2", 1, f"version, {IMAGE_VERSION[0]}"),
    Field("minor", "<u2", 1, f"version, {IMAGE_VERSION[1]}"),
    Field("header_bytes", "<u4", 1, "size of this header"),
    Field("file_bytes", "<u8", 1, f"size of the file, below {MOST_BYTES}"),
    Field("sha256", "u1", 32, "checksum of the file without these 32 bytes"),
    Field("content_sha256", "u1", 32, "checksum of the table (.h5) that the image was made from"),
    Field("pair", "S128", 1, "name of the material pair, UTF-8, zeros behind it"),
    *(Field(name, "<u4", 1, meaning) for name, meaning in _COUNTS.items()),
    Field("channels", "i1", MOST_NAMES, "channel of each row of a factor; -1 from n_channels on"),
    Field("marginals", "i1", MOST_NAMES, "its quantile function, 0, 1, ...; -1: it has none"),
    Field("columns", "i1", MOST_NAMES, "components of the state; -1 from n_columns on"),
    Field("alpha_offset", "<i4", 1, "number of the first node in alpha_coordinate"),
    Field("speed_offset", "<i4", 1, "number of the first node in speed_coordinate"),
    Field("alpha_first", "<f8", 1, "smallest impact angle, rad"),
    Field("alpha_last", "<f8", 1, "largest impact angle, rad"),
    Field("alpha_origin", "<f8", 1, "impact angle at the begin of alpha_coordinate, rad"),
    Field("alpha_scale", "<f8", 1, "entries of alpha_coordinate per rad; 0: it is one angle"),
    Field("speed_first", "<f8", 1, "smallest impact speed, m/s"),
    Field("speed_last", "<f8", 1, "largest impact speed, m/s"),
    Field("speed_origin", "<f8", 1, "impact speed at the begin of speed_coordinate, m/s"),
    Field("speed_scale", "<f8", 1, "entries of speed_coordinate per m/s; 0: it is one speed"),
    Field("variate_max", "<f8", 1, "mixture variate of the last knot; the first is its negative"),
    *(Field(f"at_{array.name}", "<u8", 1, f"offset of {array.name}") for array in ARRAYS),
)

#: The header as numpy reads it: packed, and every field naturally aligned.
HEADER_DTYPE = np.dtype([(f.name, f.dtype, (f.count,) if f.count > 1 else ()) for f in HEADER])


def field_offset(name: str) -> int:
    """Offset of a field of the header."""
    fields = HEADER_DTYPE.fields
    assert fields is not None
    return fields[name][1]


#: Why an image is refused, by error code; `rbt_strerror` of the C header has the same texts.
REASONS: Mapping[int, str] = {
    -10: "file: cannot be opened, allowed: a file that exists",
    -11: "file: cannot be read",
    -12: "memory: not enough for this table",
    -13: "machine: is big-endian, allowed: little-endian",
    -14: "format: is no image of a rebound table (.rbt)",
    -15: "format_version: allowed: 1.x (a newer file needs a newer rebound-tables)",
    -16: "file_bytes: the file is truncated, or longer than it says",
    -17: "sha256: the contents do not have this checksum",
    -18: "dimensions: one is 0 or too large, or does not fit the others",
    -19: "names: a channel or column is unknown, occurs twice or lacks what it is made of",
    -20: "offsets: an array does not lie in the file on a multiple of 64",
    -21: "axes: allowed: finite, growing, angles above 0 to pi/2, speeds above 0",
    -22: "coordinates: allowed: growing, whole at the first and the last node",
    -23: "normals: allowed: finite cubics below 16",
    -24: "alias: a component is not below their number",
    -25: "first_of_class: allowed: from 0, non-decreasing, at most the number of components",
    -26: "components: allowed: reflection from 0 to 4096, diagonals positive",
    -27: "spans: allowed: finite and within what is physical",
    -28: "quantiles: allowed: non-decreasing from knot to knot",
}


def layout_text() -> str:
    """Field lists of the image as Markdown, for the page on the format."""
    lines = ["| offset | field | type | meaning |", "|---|---|---|---|"]
    for field in HEADER:
        kind = field.dtype.strip("<") + (f" x {field.count}" if field.count > 1 else "")
        lines.append(f"| {field_offset(field.name)} | `{field.name}` | {kind} | {field.meaning} |")
    lines += ["", "| array | type | shape | meaning |", "|---|---|---|---|"]
    for array in ARRAYS:
        shape = ", ".join(str(dim) for dim in array.dims)
        lines.append(f"| `{array.name}` | {array.dtype.strip('<')} | {shape} | {array.meaning} |")
    return "\n".join(lines) + "\n"
