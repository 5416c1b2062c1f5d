"""Check that a number is within bounds, in arguments, flags and files alike."""

import math
import sys
from contextlib import suppress
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any

from sampler.errors import InputError, value_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Bounds:
    """Closed range of a quantity; NaN lies in none.

    Attributes
    ----------
    low, high : float
    unit : str
        With a space in front, for messages.
    text : str
        What is allowed, in words, if the ends do not say it.
    """

    low: float = -sys.float_info.max
    high: float = sys.float_info.max
    unit: str = ""
    text: str = ""

    @property
    def field(self) -> dict[str, float]:
        """Both ends, as pydantic names them."""
        return {"ge": self.low, "le": self.high}

    @property
    def words(self) -> str:
        """What is allowed, for messages and help pages."""
        return self.text or f"{self.low:g} to {self.high:g}{self.unit}"

    def hold(self, numbers: "NDArray[Any]") -> "NDArray[np.bool_]":
        """Tell which numbers of an array lie in the range."""
        return (numbers >= self.low) & (numbers <= self.high)

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
