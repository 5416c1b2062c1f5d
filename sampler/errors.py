"""Mistakes of users, as data: which argument, what was given, what is allowed or what to do.

`InputError` keeps these as fields and writes its sentence in `str`, where it is shown; no other
code reads that sentence. Draws and rebounds have, in every language, a code for each row: 0, a sum
of the flags `ANGLE`, `SPEED`, `SPIN` and `EXTRAPOLATED`, or one of the negative codes below.
"""

import copy
from collections.abc import Mapping
from typing import Any, NamedTuple, Self


class Code(NamedTuple):
    """What a function of the C header returns: ``RBT_`` + name, and what `rbt_strerror` says."""

    name: str
    number: int
    #: One sentence for people, without a full stop.
    text: str
    #: Arguments of Python's draws that may be to blame, the first that was given, and what is
    #: allowed of each.
    allowed: Mapping[str, str] = {}


#: Codes of draws, then of files.
CODES = (
    Code("OK", 0, "no error"),
    Code("ANGLE", 1,
        "the impact angle lies outside the table, and the nearest angle was used"),
    Code("SPEED", 2,
        "the impact speed lies outside the table, and the nearest speed was used"),
    Code("SPIN", 4,
        "the spin lies outside the table, or the grain cannot have this inertia, and the nearest "
        "value was used"),
    Code("EXTRAPOLATED", 8, "the material pair was not measured at this speed"),
    Code("ERR_MISSING", -1,
        "the table (NULL, or a handle of 0) or a required array is missing: a rebound needs "
        "velocity, normal, half_size, index and hit, a draw needs alpha1, speed, index and hit"),
    Code("ERR_NOT_FINITE", -2,
        "an argument, or the square of a speed or a spin, is NaN or infinite; or an inertia is "
        "negative"),
    Code("ERR_NOT_APPROACHING", -3,
        "the particle moves away from the wall, or alpha1 is not above 0 and at most pi/2 rad; "
        "leave its velocity unchanged; if every particle has this code, the normals point into "
        "the wall",
        {"alpha1": "above 0, at most pi/2 rad",
         "velocity": "towards the wall, (velocity - wall_velocity) . normal < 0"}),
    Code("ERR_SPEED_NOT_POSITIVE", -4,
        "the impact speed is not above 0, or the particle moves at less than 1e-150 m/s relative "
        "to the wall",
        {"speed": "above 0 m/s", "velocity": "1e-150 m/s or more relative to the wall"}),
    Code("ERR_NORMAL_NOT_USABLE", -5, "the normal of the wall has length zero",
        {"normal": "any length but zero"}),
    Code("ERR_HALF_SIZE", -6, "the half-size is not from 1e-09 to 100 m",
        {"half_size": "1e-09 to 100 m"}),
    Code("ERR_ROUGHNESS_NOT_USABLE", -7,
        "the roughness is not from 0 to 0.5 rad, or there is no such profile: ra must be 0 or "
        "more, rq not below ra, rsm and diameter above 0",
        {"roughness": "0 to 0.5 rad"}),
    Code("ERR_CASCADE_NOT_ENDED", -8,
        "the particle hit facet after facet of the rough wall and did not leave it"),
    Code("ERR_REBOUND_NOT_ENDED", -9,
        "the simulated particle did not leave the wall; a larger contact_resolution ends a chain "
        "of collisions"),
    Code("ERR_NO_SPIN_LAW", -10,
        "the table has no spin law; ask for fresh grains that arrive without spin"),
    Code("ERR_GRAIN_NOT_KNOWN", -11,
        "the table was not made for this grain: a shape, b/a or c/b is not one of its population",
        {"grain": "a shape code and ratios that the table was made for"}),
    Code("ERR_NO_WORKS", -12, "the table does not have the energies that impulses take (works)"),
    Code("ERR_DIRECT_VERSION", -13,
        "the object of direct simulation was made for another version of this header; write it "
        "again: tablegen export-direct"),
    Code("ERR_DIRECT_PAIR", -14,
        "the object of direct simulation is of another material pair than the table, or lacks a "
        "shape of its grains"),
    Code("ERR_NOT_OPENED", -15, "the file does not exist, or may not be read"),
    Code("ERR_NOT_READ", -16,
        "the file cannot be read; it must be a regular file, not a folder, pipe or device"),
    Code("ERR_NO_MEMORY", -17, "there is not enough memory for this table"),
    Code("ERR_BIG_ENDIAN", -18, "this machine is big-endian, and tables are little-endian"),
    Code("ERR_FORMAT", -19, "the file is not a binary rebound table (.rbt)"),
    Code("ERR_VERSION", -20,
        "the file has a format, or a spin law, of another version; write it again: sampler export"),
    Code("ERR_SIZE", -21, "the file is damaged: it has not the length that its header states"),
    Code("ERR_CHECKSUM", -22, "the file is damaged: its contents do not have its checksum"),
    Code("ERR_DIMENSIONS", -23,
        "the file is damaged: a dimension is 0 or too large, or does not fit the others"),
    Code("ERR_NAMES", -24,
        "the file is damaged: a channel or variable is unknown or occurs twice"),
    Code("ERR_OFFSETS", -25,
        "the file is damaged: an array does not lie within it, at a multiple of 64"),
    Code("ERR_INDICES", -26,
        "the file is damaged: a component, class, root or child lies beyond its array"),
)  # fmt: skip

#: Last code of a draw or a rebound; those beyond are of laws and files that cannot be used.
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
REBOUND_NOT_ENDED = STATUS["REBOUND_NOT_ENDED"]
NO_SPIN_LAW = STATUS["NO_SPIN_LAW"]
GRAIN_NOT_KNOWN = STATUS["GRAIN_NOT_KNOWN"]
NO_WORKS = STATUS["NO_WORKS"]

#: Flags of a row that lies outside the table. `EXTRAPOLATED` is not among them: it is set in most
#: rows where particles are slow, and would hide these flags in ``code > 0``.
OUTSIDE = ANGLE | SPEED | SPIN

#: Flags of a row, by kind.
FLAGS = {code.name.lower(): code.number for code in CODES if code.number > 0}

#: Characters of a given value that are worth repeating.
_LONGEST = 60

#: Characters of a given value that a sentence has at most; the path of a file may be long.
_LONGEST_GIVEN = 300


class InputError(ValueError):
    """A mistake in what a user gave: an argument, a field of a file, or a flag of a command.

    The error keeps its parts as attributes. `str` makes one line of them: "ARGUMENT: got GIVEN,
    allowed: ALLOWED" if a value is at fault, and "ARGUMENT: PROBLEM; REMEDY" if something else is,
    such as a missing package or a full disk.

    Parameters
    ----------
    argument : str
        Name of the argument, field or flag.
    given : object, optional
        The value that was given.
    allowed : str, optional
        The values that are allowed.
    problem : str, optional
        What happened, or what is wrong with the given value.
    remedy : str, optional
        What the user can do.
    row : int or tuple of int, optional
        Index of the first row of the arguments that cannot be used.
    particle : int, optional
        Identity of the particle in this row, its `index` in a draw.
    source : str, optional
        Name of the file, or of the larger field, in which the field stands.
    further : sequence of InputError, optional
        Other mistakes in the same input. The line names them all.

    Notes
    -----
    All parameters are attributes of the error.

    Examples
    --------
    >>> import sampler
    >>> try:
    ...     sampler.load("corundum-steel").sample(2.0, 150.0, seed=1, index=0)
    ... except sampler.InputError as error:
    ...     print(error.argument, "is not", error.allowed)
    alpha1 is not above 0, at most pi/2 rad
    """

    def __init__(
        self,
        argument: str,
        given: object = None,
        allowed: str = "",
        *,
        problem: str = "",
        remedy: str = "",
        row: int | tuple[int, ...] | None = None,
        particle: int | None = None,
        source: str = "",
        further: "tuple[InputError, ...]" = (),
    ) -> None:
        super().__init__(argument)
        self.argument, self.given, self.allowed = argument, given, allowed
        self.problem, self.remedy = problem, remedy
        self.row, self.particle = row, particle
        self.source, self.further = source, further

    def __str__(self) -> str:
        what = [] if self.given is None else [f"got {str(self.given)[:_LONGEST_GIVEN]}"]
        what += [self.problem] if self.problem else []
        what += [f"allowed: {self.allowed}"] if self.allowed else []
        what[:1] = [f"{first}{self._place()}" for first in what[:1]]
        text = ", ".join(what)
        text += f"; {self.remedy}" if self.remedy else ""
        line = ": ".join(part for part in (self.source, self.argument, text) if part)
        line = "; ".join([line, *map(str, self.further)])
        # one line, whatever a name or a value holds
        return printable(line)

    def _place(self) -> str:
        """Name the row, and the particle where it is known."""
        if self.row is None:
            return ""
        if self.particle is None:
            return f" at index {self.row}"
        return f" at row {self.row} (particle {self.particle})"

    def replaced(self, **fields: Any) -> Self:
        """Return the same error with other values of some fields."""
        changed = copy.copy(self)
        changed.__dict__.update(fields)
        return changed

    def within(self, source: object) -> Self:
        """Return the same error of a field that stands in a file or a larger field."""
        return self.replaced(source=f"{source}: {self.source}" if self.source else str(source))


class OutputError(InputError):
    """An output that cannot be written; the fields are those of `InputError`, and its `path`.

    A command names the option that gave the path in place of the argument.
    """

    def __init__(self, argument: str = "output", *, path: object = None, **fields: Any) -> None:
        super().__init__(argument, **fields)
        self.path = path


class TableError(InputError):
    """A file that cannot be used as a rebound table; the fields are those of `InputError`."""


class OutsideTableWarning(UserWarning):
    """Warning of draws outside a table, or at speeds at which the pair was not measured.

    A table gives it once for each kind of flag. ``sampler.load(name, outside="raise")`` raises an
    error instead, and `Table.counts` counts all such draws.

    Parameters
    ----------
    first : InputError or str
        The first such row of the call, in the form of the error that ``outside="raise"`` raises.
        Programs that repeat a warning, such as pytest, pass its whole text instead.
    number : int, optional
        Number of such rows in the call.
    kind : str, optional
        Kind of the flag: angle, speed, spin or extrapolated.

    Notes
    -----
    All parameters are attributes of the warning.
    """

    def __init__(self, first: InputError | str, number: int = 0, kind: str = "") -> None:
        super().__init__(first, number, kind)
        self.first, self.number, self.kind = first, number, kind

    def __str__(self) -> str:
        if isinstance(self.first, str):
            return self.first
        what = "extrapolated" if self.kind == "extrapolated" else "drawn at the nearest condition"
        rows = (
            "1 row of this call was"
            if self.number == 1
            else f"{self.number} rows of this call were"
        )
        return (
            f"{self.first}; {rows} {what}; table.counts counts all such rows, and this warning is "
            "not repeated"
        )


def printable(text: str) -> str:
    """Write line ends, and characters that a terminal obeys, as Python writes them in a string."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def shortened(text: str) -> str:
    """Cut a given text after its first 60 characters."""
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def value_text(value: object) -> str:
    """Write a given value as Python does, short and in one line."""
    if isinstance(value, int) and value.bit_length() > 256:
        # Python refuses to write out thousands of digits
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, str):
        return repr(shortened(value))
    return shortened(" ".join(repr(value).split()))
