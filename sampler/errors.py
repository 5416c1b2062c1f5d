"""Errors that a user can cause, each one line: the field, what was given, what is allowed.

Draws and rebounds return, in every language, a sum of the flags `CLAMPED` and `EXTRAPOLATED`, or
one of the negative codes below.
"""

from typing import NamedTuple, NoReturn


class Code(NamedTuple):
    """What a function of the C header returns: ``RBT_`` + name, and what `rbt_strerror` says."""

    name: str
    number: int
    text: str


#: Codes of draws, then of files.
CODES = (
    Code("OK", 0, "fine"),
    Code("CLAMPED", 1,
        "angle or speed outside the table, whose nearest condition was used, or a spin beyond it"),
    Code("EXTRAPOLATED", 2, "a speed at which the material pair was not measured"),
    Code("ERR_NOT_FINITE", -1, "arguments: allowed: finite numbers, speeds below 1e150 m/s"),
    Code("ERR_NOT_APPROACHING", -2,
        "alpha1: allowed: above 0, at most pi/2 rad; velocity: allowed: towards the wall, "
        "(velocity - wall_velocity) . normal < 0"),
    Code("ERR_SPEED_NOT_POSITIVE", -3,
        "speed: allowed: above 0 m/s; velocity: allowed: 1e-150 m/s or more relative to the wall"),
    Code("ERR_NORMAL_NOT_USABLE", -4, "normal: allowed: any length but zero"),
    Code("ERR_HALF_SIZE_NOT_POSITIVE", -5, "half_size: allowed: 1e-30 m or more"),
    Code("ERR_TILT_NOT_FOUND", -6, "roughness: no tilt of a facet was accepted"),
    Code("ERR_CASCADE_NOT_ENDED", -7, "roughness: bounces without end"),
    Code("ERR_ROUGHNESS_NOT_USABLE", -8,
        "roughness: allowed: 0 to 0.5 rad; of a profile: ra and rq 0 or more, rsm and diameter "
        "above 0, and a tilt within that"),
    Code("ERR_NO_SPIN_LAW", -9,
        "spin: the table was made without it, allowed: none (NULL), or a table with a spin law"),
    Code("ERR_NOT_OPENED", -10,
        "file: cannot be opened, allowed: a regular file that exists and may be read"),
    Code("ERR_NOT_READ", -11, "file: cannot be read, or is a folder, pipe or device"),
    Code("ERR_NO_MEMORY", -12, "memory: not enough for this table"),
    Code("ERR_BIG_ENDIAN", -13, "machine: is big-endian, allowed: little-endian"),
    Code("ERR_FORMAT", -14, "format: is no binary rebound table (.rbt)"),
    Code("ERR_VERSION", -15,
        "format_version: allowed: 1.x (a newer file needs a newer rebound-tables)"),
    Code("ERR_SIZE", -16, "file_bytes: the file is truncated, or longer than it says"),
    Code("ERR_CHECKSUM", -17, "sha256: the contents do not have this checksum"),
    Code("ERR_DIMENSIONS", -18, "dimensions: one is 0 or too large, or does not fit the others"),
    Code("ERR_NAMES", -19,
        "names: a channel or column is unknown, occurs twice or lacks what it is made of, or the "
        "pair has characters that control terminals"),
    Code("ERR_OFFSETS", -20, "offsets: an array does not lie in the file on a multiple of 64"),
    Code("ERR_AXES", -21,
        "axes: allowed: growing, angles from 1e-09 to 90 degrees, speeds from 1e-09 to 1e+09 m/s, "
        "last variate from 0.001 to 1e+06"),
    Code("ERR_COORDINATES", -22,
        "coordinates: allowed: growing from 0 to 1e+06, whole at the first and the last node"),
    Code("ERR_NORMALS", -23, "normals: allowed: finite cubics below 16"),
    Code("ERR_ALIAS", -24, "alias: a component is not below their number"),
    Code("ERR_CLASSES", -25,
        "first_of_class: allowed: from 0, non-decreasing, at most the number of components"),
    Code("ERR_COMPONENTS", -26,
        "components: allowed: reflection from 0 to 4096, diagonals positive"),
    Code("ERR_SPANS", -27, "spans: allowed: finite and within what is physical"),
    Code("ERR_QUANTILES", -28, "quantiles: allowed: non-decreasing from knot to knot"),
    Code("ERR_GRAINS", -29,
        "grains: allowed: shares that grow to 1, probabilities that grow, ratios from 0.001 to 1"),
    Code("ERR_TREES", -30,
        "trees: allowed: cuts within 1000, children that are a later node or a leaf"),
    Code("ERR_LEAVES", -31,
        "leaves: allowed: middles within 1000, factors from 0 to 10000, diagonals positive"),
    Code("ERR_GRAIN_NOT_KNOWN", -32,
        "grain: allowed: a shape of the spin law, and b/a and c/b from 0.001 to 1"),
)  # fmt: skip

#: Codes by name: 0 is fine, positive a flag, negative an error with nothing written.
STATUS = {code.name.removeprefix("ERR_"): code.number for code in CODES}

OK = STATUS["OK"]
CLAMPED = STATUS["CLAMPED"]
EXTRAPOLATED = STATUS["EXTRAPOLATED"]
NOT_FINITE = STATUS["NOT_FINITE"]
NOT_APPROACHING = STATUS["NOT_APPROACHING"]
SPEED_NOT_POSITIVE = STATUS["SPEED_NOT_POSITIVE"]
NORMAL_NOT_USABLE = STATUS["NORMAL_NOT_USABLE"]
HALF_SIZE_NOT_POSITIVE = STATUS["HALF_SIZE_NOT_POSITIVE"]
TILT_NOT_FOUND = STATUS["TILT_NOT_FOUND"]
CASCADE_NOT_ENDED = STATUS["CASCADE_NOT_ENDED"]
ROUGHNESS_NOT_USABLE = STATUS["ROUGHNESS_NOT_USABLE"]
NO_SPIN_LAW = STATUS["NO_SPIN_LAW"]
GRAIN_NOT_KNOWN = STATUS["GRAIN_NOT_KNOWN"]

#: Characters of a given value that are worth repeating.
_LONGEST = 60


class InputError(ValueError):
    """An argument, field or flag that cannot be used."""


class TableError(InputError):
    """A table file that cannot be read as a rebound table."""


class OutsideTableWarning(UserWarning):
    """Draws lay outside a table; given once a table, at the first."""


def refuse(name: str, got: object, allowed: str) -> NoReturn:
    """Raise the `InputError` of an argument: its name, what was given, what is allowed."""
    raise InputError(f"{name}: got {got}, allowed: {allowed}")


def shortened(text: str) -> str:
    """Cut a given text after its first 60 characters."""
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
