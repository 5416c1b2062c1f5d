"""Columns of a file of measurements, and what each may hold."""

import math
from typing import NamedTuple

from tablegen.measured.records import QUANTITIES, SPREAD
from tablegen.model.model_bounds import ALPHA_DEG, SPEED

NUMBERS = ("alpha_deg", "speed", *(q + end for q in QUANTITIES for end in ("", SPREAD)), "count")
TEXTS = ("source", "remarks")
COLUMNS = (*NUMBERS, *TEXTS)

#: Columns that a file must have, with no cell empty.
DEMANDED = ("alpha_deg", "source")

#: Largest omega_z a/V: the energy of the impact spins a fibre of b/a = 0.1 by 16.
_MOST_SPIN = 20.0

#: What rounding of published digits may add to a ratio.
_ROUNDING = 1e-3

_FRACTION = "a fraction, not per cent"
_SPIN = "times a/V, not rad/s"


class Allowed(NamedTuple):
    """Closed range of a column, and a word on it for a message."""

    low: float
    high: float
    hint: str = ""

    def holds(self, value: float) -> bool:
        """Whether a value is in the range; NaN is not."""
        return self.low <= value <= self.high

    @property
    def words(self) -> str:
        """What is allowed, for a message."""
        hint = f" ({self.hint})" if self.hint else ""
        return f"{self.low:.4g} to {self.high:.4g}{hint}"


def _most_ratio(quantity: str, alpha_deg: float) -> float:
    """Restitution at which the energy of the impact is all in one component."""
    angle = math.radians(alpha_deg)
    part = math.sin(angle) if quantity == "e_n" else math.cos(angle)
    return (1.0 + _ROUNDING) / part


def allowed(column: str, alpha_deg: float) -> Allowed:
    """Range of a column of numbers at an impact angle.

    Parameters
    ----------
    column : str
        One of `NUMBERS`; e_t only at angles below 90 degrees, where it is defined.
    alpha_deg : float
        Of the row; of no account for the angle and the speed themselves.
    """
    if column == "alpha_deg":
        return Allowed(ALPHA_DEG.low, ALPHA_DEG.high, "degrees from the wall")
    if column == "speed":
        return Allowed(SPEED.low, SPEED.high, "m/s")
    if column == "count":
        return Allowed(1.0, 1e15, "a whole number of particles")
    quantity = column.removesuffix(SPREAD)
    if quantity in ("e_n", "e_t"):
        low, high = (-1.0 if quantity == "e_t" else 0.0), 1.0
        most = _most_ratio(quantity, alpha_deg)
        low, high, hint = low * most, high * most, f"at {alpha_deg:g} degrees; {_FRACTION}"
    elif quantity == "omega_z":
        low, high, hint = -_MOST_SPIN, _MOST_SPIN, _SPIN
    else:
        low, high = (0.0, 180.0) if quantity == "rebound_angle_deg" else (-90.0, 90.0)
        hint = "degrees"
    if column != quantity:  # a spread is at most half of the range
        low, high = 0.0, 0.5 * (high - low)
    return Allowed(low, high, hint)
