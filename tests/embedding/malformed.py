"""Malformed binary tables: what is changed in a good one, and the code that it is refused with.

The checksum is made right again where not it is the matter, so that every check is reached.
"""

import numpy as np
from sampler.formats.image import checksum

from sampler.formats.binary_layout import (
    ARRAYS,
    FIRST_HEADER_BYTES,
    HEADER_DTYPE,
    SPIN_ARRAYS,
    field_offset,
)

NAN = np.nan
_DTYPES = {array.name: array.dtype for array in (*ARRAYS, *SPIN_ARRAYS)}


def set_field(name, value, at=None):
    """Change of a header field, or of one element of it."""

    def change(data):
        header = data[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)
        if at is None:
            header[name] = value
        else:
            header[name][0, at] = value
        return data

    return change


def add_to_field(name, value):
    def change(data):
        header = data[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)
        header[name] = header[name] + np.asarray(value).astype(header[name].dtype)
        return data

    return change


def set_number(name, at, value):
    """Change of one number of an array; `at` counts from its begin."""

    def change(data):
        start = int(data[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)[f"at_{name}"][0])
        dtype = np.dtype(_DTYPES[name])
        start += at * dtype.itemsize
        data[start : start + dtype.itemsize] = np.array([value], dtype).view(np.uint8)
        return data

    return change


def cut(length):
    return lambda data: data[:length].copy()


def lengthened(data):
    return np.concatenate([data, np.zeros(64, np.uint8)])


def components_to_the_end(data):
    """Room for the records, each a cache line, but not for the zeros behind them."""
    data = np.concatenate([data, np.zeros(-data.size % 64, np.uint8)])
    header = data[: HEADER_DTYPE.itemsize].view(HEADER_DTYPE)
    records = header["n_alpha"] * header["n_speed"] * header["n_components"]
    header["file_bytes"] = data.size
    header["at_components"] = data.size - 64 * records
    return data


def flip(name):
    def change(data):
        data[field_offset(name)] ^= 1
        return data

    return change


def keep(data):
    return data


#: Name, change, code, and whether the checksum is made right afterwards.
MALFORMED = [
    ("empty", cut(0), -14, False),
    ("magic cut", cut(7), -14, False),
    ("another format", set_field("magic", b"\x89HDF\r\n\x1a\n"), -14, True),
    ("sent as text", set_field("magic", b"\x89RBT\n\x1a\n\0"), -14, True),
    ("header cut", cut(100), -16, False),
    ("newer", set_field("major", 2), -15, True),
    ("older", set_field("major", 0), -15, True),
    ("last byte cut", cut(-1), -16, False),
    ("lengthened", lengthened, -16, False),
    ("size", add_to_field("file_bytes", 64), -16, True),
    ("checksum", flip("sha256"), -17, False),
    ("pair changed", flip("pair"), -17, False),
    ("flags changed", flip("flags"), -17, False),
    *((f"{name} is 0", set_field(name, 0), -18, True) for name in (
        "n_alpha", "n_speed", "n_alpha_grid", "n_speed_grid", "n_knots", "n_components",
        "n_classes", "n_channels", "n_marginals", "n_columns", "stride",
    )),
    ("one grid value", set_field("n_alpha_grid", 1), -18, True),
    ("one knot", set_field("n_knots", 1), -18, True),
    ("nine channels", set_field("n_channels", 9), -18, True),
    ("stride", set_field("stride", 64), -18, True),
    ("huge", set_field("n_components", 2**32 - 1), -18, True),
    ("channel unknown", set_field("channels", 8, at=0), -19, True),
    ("channel negative", set_field("channels", -2, at=0), -19, True),
    ("channel twice", set_field("channels", 1, at=0), -19, True),
    ("channel beyond", set_field("channels", 7, at=7), -19, True),
    ("marginal twice", set_field("marginals", 0, at=1), -19, True),
    ("marginal missing", set_field("marginals", -1, at=5), -19, True),
    ("marginal beyond", set_field("marginals", 6, at=6), -19, True),
    ("column unknown", set_field("columns", 8, at=5), -19, True),
    ("column twice", set_field("columns", 0, at=5), -19, True),
    ("escape sequence in the pair", set_field("pair", b"\x1b[2Jgold"), -19, True),
    ("end of a line in the pair", set_field("pair", b"a\nb"), -19, True),
    ("C1 control character", set_field("pair", "a\x9bb".encode()), -19, True),
    ("pair without an end", set_field("pair", b"x" * 128), -19, True),
    ("column without channels", set_field("columns", 7, at=5), -19, True),
    *((f"{array.name} unaligned", add_to_field(f"at_{array.name}", 8), -20, True)
      for array in ARRAYS),
    *((f"{array.name} in the header", set_field(f"at_{array.name}", 64), -20, True)
      for array in ARRAYS),
    *((f"{array.name} beyond", set_field(f"at_{array.name}", 2**64 - 64), -20, True)
      for array in ARRAYS),
    ("quantiles at the end", add_to_field("at_quantiles", 64), -20, True),
    ("components at the end", components_to_the_end, -20, True),
    ("more components", set_field("n_components", 65536), -20, True),
    ("more knots", set_field("n_knots", 65536), -20, True),
    ("more nodes", set_field("n_alpha", 65536), -20, True),
    ("NaN angle", set_field("alpha_first", NAN), -21, True),
    ("infinite speed", set_field("speed_last", np.inf), -21, True),
    ("angle 0", set_field("alpha_first", 0.0), -21, True),
    ("angle above pi/2", set_field("alpha_last", 1.6), -21, True),
    ("speeds fall", set_field("speed_last", 1.0), -21, True),
    ("one speed for three nodes", set_field("speed_first", 300.0), -21, True),
    ("angle too small", set_field("alpha_first", 1e-12), -21, True),
    ("speed too large", set_field("speed_last", 2e9), -21, True),
    ("negative origin", set_field("alpha_origin", -0.5), -21, True),
    ("origin behind", set_field("alpha_origin", 0.5), -21, True),
    ("NaN scale", set_field("speed_scale", NAN), -21, True),
    ("no scale", set_field("speed_scale", 0.0), -21, True),
    ("negative scale", set_field("speed_scale", -1.0), -21, True),
    ("scale too large", set_field("speed_scale", 1e3), -21, True),
    ("no variate", set_field("variate_max", 0.0), -21, True),
    ("small variate", set_field("variate_max", 1e-4), -21, True),
    ("NaN variate", set_field("variate_max", NAN), -21, True),
    ("large variate", set_field("variate_max", 2e6), -21, True),
    ("offset", set_field("alpha_offset", 1), -22, True),
    ("large offset", set_field("alpha_offset", -(2**31)), -22, True),
    ("coordinate NaN", set_number("alpha_coordinate", 3, NAN), -22, True),
    ("coordinate below 0", set_number("alpha_coordinate", 0, -1e-6), -22, True),
    ("coordinate falls", set_number("speed_coordinate", 3, 0.0), -22, True),
    ("coordinate too large", set_number("speed_coordinate", 100, 1e7), -22, True),
    ("last coordinate", set_number("alpha_coordinate", 100, 2.5), -22, True),
    ("cubic NaN", set_number("normals", 1000, NAN), -23, True),
    ("cubic large", set_number("normals", 7, 17.0), -23, True),
    ("alias", set_number("alias", 44, 5), -24, True),
    ("class does not begin at 0", set_number("first_of_class", 2, 1), -25, True),
    ("class beyond", set_number("first_of_class", 1, 6), -25, True),
    ("reflection above 1", set_number("components", 32, 4097), -26, True),
    ("reflection below 0", set_number("components", 0, -1), -26, True),
    ("diagonal 0", set_number("components", 7, 0), -26, True),
    ("last diagonal negative", set_number("components", 32 * 44 + 27, -5), -26, True),
    ("span NaN", set_number("spans", 0, NAN), -27, True),
    ("step infinite", set_number("spans", 5, np.inf), -27, True),
    ("step negative", set_number("spans", 5, -1.0), -27, True),
    ("v of 0", set_number("spans", 0, 0.0), -27, True),
    ("u_hat of -1", set_number("spans", 2, -1.0), -27, True),
    ("w_hat of 1", set_number("spans", 7, 1.0), -27, True),
    ("omega too large", set_number("spans", 4, 2e9), -27, True),
    ("omega overflows", set_number("spans", 5, 1e304), -27, True),
    ("quantiles fall", set_number("quantiles", 4, 65535), -28, True),
]  # fmt: skip

#: The same of a table with a spin law: two shapes, the second a mesh, with four nodes and five
#: leaves each, as `spin_tables` makes them.
MALFORMED_SPIN = [
    ("header of version 1.0", cut(FIRST_HEADER_BYTES), -16, False),
    *((f"{name} is 0", set_field(name, 0), -18, True)
      for name in ("n_nodes", "n_leaves", "n_spin_knots")),
    ("one spin knot", set_field("n_spin_knots", 1), -18, True),
    ("too many shapes", set_field("n_shapes", 1025), -18, True),
    ("huge", set_field("n_leaves", 2**32 - 1), -18, True),
    *((f"{array.name} unaligned", add_to_field(f"at_{array.name}", 8), -20, True)
      for array in SPIN_ARRAYS),
    *((f"{array.name} in the header", set_field(f"at_{array.name}", 448), -20, True)
      for array in SPIN_ARRAYS),
    *((f"{array.name} beyond", set_field(f"at_{array.name}", 2**64 - 64), -20, True)
      for array in SPIN_ARRAYS),
    ("more leaves", set_field("n_leaves", 2**20), -20, True),
    ("more nodes", set_field("n_nodes", 2**20), -20, True),
    ("more knots", set_field("n_spin_knots", 4096), -20, True),
    ("experts at the end", add_to_field("at_experts", 64), -20, True),
    ("valid speed NaN", set_field("valid_speed", NAN, at=0), -21, True),
    ("valid speeds fall", set_field("valid_speed", 10.0, at=1), -21, True),
    ("valid speed negative", set_field("valid_speed", -1.0, at=0), -21, True),
    ("spin angle 0", set_field("spin_alpha", 0.0, at=0), -21, True),
    ("spin angles fall", set_field("spin_alpha", 1e-3, at=1), -21, True),
    ("spin angle above pi/2", set_field("spin_alpha", 1.6, at=1), -21, True),
    ("spin speed NaN", set_field("spin_speed", NAN, at=1), -21, True),
    ("spin speed 0", set_field("spin_speed", 0.0, at=0), -21, True),
    ("spin speed too large", set_field("spin_speed", 2e9, at=1), -21, True),
    ("speed scale NaN", set_field("spin_coordinate", NAN, at=0), -21, True),
    ("speed scale negative", set_field("spin_coordinate", -1.0, at=0), -21, True),
    ("speed scale infinite", set_field("spin_coordinate", np.inf, at=0), -21, True),
    ("speed exponent 0", set_field("spin_coordinate", 0.0, at=1), -21, True),
    ("shape negative", set_number("shape_codes", 0, -1), -29, True),
    ("share NaN", set_number("shape_shares", 0, NAN), -29, True),
    ("shares fall", set_number("shape_shares", 0, 1.5), -29, True),
    ("shares end below 1", set_number("shape_shares", 1, 0.9), -29, True),
    ("ratio above 1", set_number("shape_ratios", 2, 1.5), -29, True),
    ("one ratio of two", set_number("shape_ratios", 3, 0.0), -29, True),
    ("mean ratio NaN", set_field("aspect", NAN, at=0), -29, True),
    ("deviation negative", set_field("aspect", -0.1, at=5), -29, True),
    ("probability negative", set_field("aspect", -0.1, at=2), -29, True),
    ("probabilities fall", set_field("aspect", 0.01, at=7), -29, True),
    ("root beyond", set_number("roots", 1, 8), -30, True),
    ("root negative", set_number("roots", 0, -1), -30, True),
    ("axis unknown", set_number("node_axis", 2, 6), -30, True),
    ("axis negative", set_number("node_axis", 2, -1), -30, True),
    ("cut NaN", set_number("node_cut", 3, NAN), -30, True),
    ("cut large", set_number("node_cut", 3, 2e3), -30, True),
    ("a child is its parent", set_number("node_child", 2, 1), -30, True),
    ("a child is an earlier node", set_number("node_child", 5, 0), -30, True),
    ("child beyond", set_number("node_child", 7, 8), -30, True),
    ("leaf beyond", set_number("node_child", 0, -11), -30, True),
    ("least number", set_number("node_child", 0, -(2**31)), -30, True),
    ("middle NaN", set_number("inputs", 6, NAN), -31, True),
    ("middle large", set_number("inputs", 14, -2e3), -31, True),
    ("factor NaN", set_number("inputs", 7, NAN), -31, True),
    ("factor negative", set_number("inputs", 13, -1.0), -31, True),
    ("factor large", set_number("inputs", 139, 2e4), -31, True),
    ("first diagonal 0", set_number("experts", 138, 0), -31, True),
    ("last diagonal negative", set_number("experts", 160 * 1279 + 158, -5), -31, True),
    ("span NaN", set_number("spin_spans", 0, NAN), -27, True),
    ("step infinite", set_number("spin_spans", 1, np.inf), -27, True),
    ("step negative", set_number("spin_spans", 119, -1.0), -27, True),
    ("outcome too large", set_number("spin_spans", 1, 1e3), -27, True),
    ("outcome too small", set_number("spin_spans", 8, -2e6), -27, True),
    ("v below 0", set_number("spin_spans", 2, -1e-6), -27, True),
    ("v of 0", set_number("spin_spans", 3, 0.0), -27, True),
    ("v of 0 at the second knot", set_number("spin_quantiles", 34, 0), -27, True),
    ("quantiles fall", set_number("spin_quantiles", 2, 65535), -28, True),
]  # fmt: skip


def make(good, change, repair):
    """Malformed binary table, from the bytes of a good one."""
    data = change(np.frombuffer(good, np.uint8).copy())
    if repair:
        at = field_offset("sha256")
        data[at : at + 32] = np.frombuffer(checksum(data), np.uint8)
    return data.tobytes()
