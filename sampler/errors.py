"""Errors that a user can cause, each with one line: what, what was given, what is allowed.

Kernels return status codes in their place: 0 is fine, positive is a warning, negative an error.
"""

OK = 0
"""Status code: fine."""
CLAMPED = 1
"""Status code: outside the table, whose nearest condition was used."""
NOT_FINITE = -1
"""Status code: NaN or infinity in the arguments; nothing was written, as for all that follow."""
NOT_APPROACHING = -2
"""Status code: the particle does not approach the wall."""
SPEED_NOT_POSITIVE = -3
"""Status code: at rest relative to the wall, or within 1e-150 m/s of it."""
NORMAL_NOT_USABLE = -4
"""Status code: a normal of length zero."""
HALF_SIZE_NOT_POSITIVE = -5
"""Status code: a half-size that is not positive, or below 1e-30 m."""
TILT_NOT_FOUND = -6
"""Status code of rough walls: no tilt was accepted, with a probability below 1e-50 a hit."""
CASCADE_NOT_ENDED = -7
"""Status code of rough walls: bounces without end, with a probability below 1e-30 a hit."""
ROUGHNESS_NOT_USABLE = -8
"""Status code of rough walls: a roughness outside of 0 to 0.5 rad."""
NO_SPIN_LAW = -9
"""Status code: a spin or a grain was given, and the table has no spin law."""
GRAIN_NOT_KNOWN = -10
"""Status code: a grain of a shape that the spin law does not have, or of ratios that are none."""
SPIN_NOT_GIVEN = -11
"""Status code: no spin, for the arrays of a table that was loaded with a population of its own."""


#: Characters of a given value that are worth repeating.
_LONGEST = 60


def shortened(text: str) -> str:
    """Begin of what was given, where it is not worth repeating whole."""
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


class InputError(ValueError):
    """An argument, field or flag that cannot be used."""


class TableError(InputError):
    """A table file that cannot be read as a rebound table."""


class OutsideTableWarning(UserWarning):
    """Draws lay outside a table and were moved to its edge; given once a table, at the first."""
