"""Bounds of the arguments of the direct model, in the order in which LAWS.md shows them.

Inside of the bounds every rebound ends with a finite state; LAWS.md has the cost of the worst
corners. Outside, the time of a rebound or its rounding errors grow without limit. The same bounds
apply in files, flags and functions.
"""

import math
from contextlib import suppress
from dataclasses import dataclass
from numbers import Real
from typing import Any

from sampler.errors import InputError, value_text


@dataclass(frozen=True)
class Bounds:
    """Closed range of a quantity."""

    low: float
    high: float
    unit: str = ""

    @property
    def field(self) -> dict[str, float]:
        """Both ends, as pydantic names them."""
        return {"ge": self.low, "le": self.high}

    @property
    def words(self) -> str:
        """What is allowed, for messages and help pages."""
        return f"{self.low:g} to {self.high:g}{self.unit}"

    def checked(self, name: str, value: Any) -> float:
        """Return the value of an argument as a float; raise `InputError` if it is out of range.

        True, False, texts and arrays are not numbers.
        """
        number = as_number(value)
        if not self.low <= number <= self.high:  # not a NaN either
            raise self.refusal(name, value)
        return number

    def refusal(self, name: str, value: Any) -> InputError:
        """Error for a value that is no number of the range."""
        unit = self.unit if math.isfinite(as_number(value)) else ""
        return InputError(name, f"{argument_text(value)}{unit}", self.words)


def as_number(value: Any) -> float:
    """Convert a value to a float; NaN if it is not a number, or too large."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.nan


def argument_text(value: Any) -> str:
    """Write the value of an argument: a number in 12 digits, anything else as Python does."""
    if isinstance(value, Real) and not isinstance(value, bool):
        with suppress(OverflowError):
            return f"{float(value):.12g}"
    return value_text(value)


#: Ratios b/a and c/b.
ASPECT = Bounds(1e-3, 1.0)

#: Impact angle from the wall.
ALPHA_DEG = Bounds(1e-6, 90.0, " degrees")

#: Impact speed.
SPEED = Bounds(1e-6, 1e5, " m/s")

#: Angular velocity before the impact along each axis.
SPIN = Bounds(-1e3, 1e3, " V/a")

#: Inertia about a spin over m a^2. No particle has one larger than 2.
INERTIA = Bounds(0.0, 2.0)

#: Angle [rad] by which a particle may turn before its first contact, 2 |spin| / sin(alpha1).
MOST_TURNED = 1e6

#: Half-size [m] for rebounds in units of a, which do not depend on it. It is a power of two, so
#: that a change of units loses no bits.
HALF_SIZE = 2.0**-17

#: Smallest rebound speed of a contact point over V.
CONTACT_RESOLUTION = Bounds(1e-6, 0.1)

#: Truncation of the flight series.
TOLERANCE = Bounds(1e-14, 1e-4)

#: Least extent of a mesh in the units of its file, and largest coordinate. The cubes of these
#: numbers neither overflow nor underflow.
MESH_SIZE = Bounds(1e-30, 1e30)
