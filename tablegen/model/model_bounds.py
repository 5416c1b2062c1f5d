"""Bounds of the arguments of the direct model: one table, which LAWS.md shows.

Within them every rebound ends, with a finite state; LAWS.md has the cost of the worst corners.
Beyond them time grows without end, or rounding errors do. They hold in files, flags and functions
alike.
"""

import math
from dataclasses import dataclass
from numbers import Real
from typing import Any

from sampler.errors import InputError, shortened


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
        """Return the number given for an argument; raises `InputError` if it is out of the range.

        True and False, texts and arrays are no numbers.
        """
        number = as_number(value)
        if not self.low <= number <= self.high:  # not a NaN either
            raise self.refusal(name, value)
        return number

    def refusal(self, name: str, value: Any) -> InputError:
        """Error for a value that is no number of the range."""
        unit = self.unit if math.isfinite(as_number(value)) else ""
        return InputError(f"{name}: got {as_text(value)}{unit}, allowed: {self.words}")


def as_number(value: Any) -> float:
    """Value as a floating-point number; NaN if it is not a number, or too large."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.nan


def as_text(value: Any) -> str:
    """Text of a given value, short and in one line."""
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            return f"{float(value):.12g}"
        except OverflowError:
            return "a number beyond the largest of 64 bits"
    return shortened(" ".join(repr(value).split()))


#: Ratios b/a and c/b.
ASPECT = Bounds(1e-3, 1.0)

#: Impact angle from the wall.
ALPHA_DEG = Bounds(1e-6, 90.0, " degrees")

#: Impact speed.
SPEED = Bounds(1e-6, 1e5, " m/s")

#: Each component of the angular velocity before the impact.
SPIN = Bounds(-1e3, 1e3, " V/a")

#: Inertia about a spin over m a^2; of no particle is it larger than 2.
INERTIA = Bounds(0.0, 2.0)

#: Angle [rad] that a particle may turn from its greatest height to its least, before any contact:
#: 2 |spin| / sin(alpha1).
MOST_TURNED = 1e6

#: Half-size [m] where any gives the same rebound: a power of two, so that units of a keep all bits.
HALF_SIZE = 2.0**-17

#: Smallest rebound speed of a contact point over V.
CONTACT_RESOLUTION = Bounds(1e-6, 0.1)

#: Truncation of the flight series.
TOLERANCE = Bounds(1e-14, 1e-4)

#: Least extent of a mesh in the units of its file, and the largest coordinate. Cubes of these
#: numbers are numbers.
MESH_SIZE = Bounds(1e-30, 1e30)
