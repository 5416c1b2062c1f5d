"""Errors that a user can cause, each one line: the field, what was given, what is allowed.

Draws and rebounds have, in every language, a code for each row: 0, a sum of the flags `ANGLE`,
`SPEED`, `SPIN` and `EXTRAPOLATED`, or one of the negative codes below.
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
    Code("ANGLE", 1, "impact angle outside the table: the nearest was drawn"),
    Code("SPEED", 2, "impact speed outside the table: the nearest was drawn"),
    Code("SPIN", 4, "spin beyond the table, or inertia beyond the grain: the nearest was drawn"),
    Code("EXTRAPOLATED", 8, "a speed at which the material pair was not measured"),
    Code("ERR_MISSING", -1, "a required array or the table is missing (NULL, or a handle of 0)"),
    Code("ERR_NOT_FINITE", -2,
        "arguments: allowed: finite numbers, speeds below 1e150 m/s, inertia 0 or more"),
    Code("ERR_NOT_APPROACHING", -3,
        "alpha1: allowed: above 0, at most pi/2 rad; velocity: allowed: towards the wall, "
        "(velocity - wall_velocity) . normal < 0"),
    Code("ERR_SPEED_NOT_POSITIVE", -4,
        "speed: allowed: above 0 m/s; velocity: allowed: 1e-150 m/s or more relative to the wall"),
    Code("ERR_NORMAL_NOT_USABLE", -5, "normal: allowed: any length but zero"),
    Code("ERR_HALF_SIZE", -6, "half_size: allowed: 1e-09 to 100 m"),
    Code("ERR_ROUGHNESS_NOT_USABLE", -7,
        "roughness: allowed: 0 to 0.5 rad; of a profile: ra 0 or more, rq not below ra, rsm and "
        "diameter above 0, and a tilt within that"),
    Code("ERR_CASCADE_NOT_ENDED", -9, "roughness: bounces without end"),
    Code("ERR_NO_SPIN_LAW", -10,
        "spin, grain, rebound: the table has no spin law, allowed: fresh grains without spin"),
    Code("ERR_GRAIN_NOT_KNOWN", -11,
        "grain: allowed: a shape of the spin law, and b/a and c/b from 0.001 to 1"),
    Code("ERR_NO_WORKS", -12, "works: the table has no works"),
    Code("ERR_NOT_OPENED", -20,
        "file: cannot be opened, allowed: a regular file that exists and may be read"),
    Code("ERR_NOT_READ", -21, "file: cannot be read, or is a folder, pipe or device"),
    Code("ERR_NO_MEMORY", -22, "memory: not enough for this table"),
    Code("ERR_BIG_ENDIAN", -23, "machine: is big-endian, allowed: little-endian"),
    Code("ERR_FORMAT", -24, "format: is no binary rebound table (.rbt)"),
    Code("ERR_VERSION", -25, "format_version: allowed: 3.x; make the file again: sampler export"),
    Code("ERR_SIZE", -26, "file_bytes: the file is truncated, or longer than it says"),
    Code("ERR_CHECKSUM", -27, "sha256: the contents do not have this checksum"),
    Code("ERR_DIMENSIONS", -28, "dimensions: one is 0 or too large, or does not fit the others"),
    Code("ERR_NAMES", -29, "names: a channel or column is unknown or occurs twice"),
    Code("ERR_OFFSETS", -30, "offsets: an array does not lie in the file on a multiple of 64"),
    Code("ERR_INDICES", -31, "indices: a component, class, root or child lies beyond its array"),
)  # fmt: skip

#: Last code of a draw or a rebound; those beyond are of files.
LAST_OF_DRAWS = -12

#: Codes by name: 0 is fine, positive a flag, negative an error whose results are NaN.
STATUS = {code.name.removeprefix("ERR_"): code.number for code in CODES}

OK = STATUS["OK"]
ANGLE = STATUS["ANGLE"]
SPEED = STATUS["SPEED"]
SPIN = STATUS["SPIN"]
EXTRAPOLATED = STATUS["EXTRAPOLATED"]
MISSING = STATUS["MISSING"]
NOT_FINITE = STATUS["NOT_FINITE"]
NOT_APPROACHING = STATUS["NOT_APPROACHING"]
SPEED_NOT_POSITIVE = STATUS["SPEED_NOT_POSITIVE"]
NORMAL_NOT_USABLE = STATUS["NORMAL_NOT_USABLE"]
HALF_SIZE = STATUS["HALF_SIZE"]
CASCADE_NOT_ENDED = STATUS["CASCADE_NOT_ENDED"]
NO_SPIN_LAW = STATUS["NO_SPIN_LAW"]
GRAIN_NOT_KNOWN = STATUS["GRAIN_NOT_KNOWN"]
NO_WORKS = STATUS["NO_WORKS"]

#: Flags of a row that lies outside the table. `EXTRAPOLATED` is not among them: it is set in most
#: rows where particles are slow, and would hide these flags in ``code > 0``.
OUTSIDE = ANGLE | SPEED | SPIN

#: Flags of a row, by kind.
FLAGS = {"angle": ANGLE, "speed": SPEED, "spin": SPIN, "extrapolated": EXTRAPOLATED}

#: Characters of a given value that are worth repeating.
_LONGEST = 60


class InputError(ValueError):
    """An argument, field or flag that cannot be used."""


class TableError(InputError):
    """A table file that cannot be read as a rebound table."""


class OutsideTableWarning(UserWarning):
    """Draws lay outside a table, or of the measured speeds; given once a table and kind."""


def refuse(name: str, got: object, allowed: str) -> NoReturn:
    """Raise the `InputError` of an argument: its name, what was given, what is allowed."""
    raise InputError(f"{name}: got {got}, allowed: {allowed}")


def shortened(text: str) -> str:
    """Cut a given text after its first 60 characters."""
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
