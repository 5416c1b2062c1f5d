"""Laws of normal restitution at the contact, as a pair file states them.

`tablegen.model.contact_laws` has the kernel of each; tables/LAWS.md shows how a file names them.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, field_validator, model_validator

from tablegen.config.field_types import Increasing, Positive, Record, SpeedRange, Text
from tablegen.config.messages import refusal
from tablegen.model.contact_laws import (
    CONSTANT,
    EXPONENTIAL,
    POLYNOMIAL,
    POWER,
    TABULATED,
    pack_table,
)
from tablegen.model.float_array import FloatArray

#: How far rounding may carry a restitution coefficient out of [0, 1].
_ROUNDING = 1e-12

#: Exponent of the abscissa of laws that ignore the speed: so small that two nodes span any range.
_FAINT = 0.01

#: Restitution coefficient.
Coefficient = Annotated[float, Field(ge=0.0, le=1.0)]


class _Restitution(Record):
    """What all laws of normal restitution share.

    A law gives the ratio a_nc of the normal velocities of the contact point after and before the
    collision. Whatever the contact speed and the angle, 0 <= a_nc <= 1: a law that can leave this
    range is refused when it is read.
    """

    @property
    def depends_on_speed(self) -> bool:
        """Whether a_nc, and with it the rebound statistics, depend on the contact speed."""
        return False

    def coordinate(self, speed: ArrayLike) -> FloatArray:
        """Abscissa for interpolation in impact speed; rebound statistics are nearly linear in it.

        Parameters
        ----------
        speed : array_like of float
            Impact speed, m/s, positive.

        Returns
        -------
        float64 array
            Shape of `speed`; positive, dimensionless, strictly falling with the speed. Default
            nodes are equally spaced in its logarithm.
        """
        return self._abscissa(np.asarray(speed, dtype=np.float64))

    def _abscissa(self, speed: FloatArray) -> FloatArray:
        # Speed enters the model only through the law of restitution, so without it every speed has
        # the same rebound statistics, any abscissa serves, and nodes at the ends are enough.
        return speed**-_FAINT


class ExponentialRestitution(_Restitution):
    """Restitution that falls with the contact speed towards normal impact.

    With V_c the velocity of the contact point (m/s) and v_c its normal component,

        a_nc = 1 - [1 - exp(-coefficient |V_c|^exponent)] |v_c| / |V_c|.

    Source: form and corundum-on-steel coefficients as in Panfilov and Tsirkunov (2022), eq. 6.
    """

    law: Literal["exponential"]
    coefficient: Positive
    exponent: Annotated[float, Field(gt=0.0, le=10.0)]
    valid_speed: SpeedRange | None = None
    source: Text

    @property
    def depends_on_speed(self) -> bool:
        """Whether a_nc depends on the contact speed: yes."""
        return True

    def _abscissa(self, speed: FloatArray) -> FloatArray:
        # a_nc at normal impact, which falls from 1 at rest towards 0
        return np.exp(-self.coefficient * speed**self.exponent)

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {
            "restitution_law": EXPONENTIAL,
            "coefficient": self.coefficient,
            "exponent": self.exponent,
        }


class PolynomialRestitution(_Restitution):
    """Restitution as a polynomial in the impact angle at the contact.

    With beta = asin(|v_c| / |V_c|) in radians, measured from the wall,

        a_nc = c_0 + c_1 beta + c_2 beta^2 + ...
    """

    law: Literal["polynomial"]
    #: c_0, c_1, ...: lowest power first.
    coefficients: Annotated[tuple[float, ...], Field(min_length=1, max_length=16)]
    valid_speed: SpeedRange | None = None
    source: Text

    @field_validator("coefficients")
    @classmethod
    def _physical(cls, coefficients: tuple[float, ...]) -> tuple[float, ...]:
        polynomial = np.polynomial.Polynomial(coefficients)
        # Extremes lie at the ends or where the slope is zero; the grid stands in for turning
        # points that a root finder loses to a vanishing leading coefficient.
        turns = polynomial.trim().deriv().roots().real
        grid = np.linspace(0.0, np.pi / 2, 2001)
        angles = np.append(grid, turns[(turns > 0.0) & (turns < np.pi / 2)])
        values = polynomial(angles)
        worst = int(np.argmax(np.abs(values - 0.5)))
        if not abs(values[worst] - 0.5) <= 0.5 + _ROUNDING:
            raise ValueError(
                "a polynomial within 0 to 1 from 0 to 90 degrees; this one is "
                f"{values[worst]:.4g} at {np.degrees(angles[worst]):.3g} degrees"
            )
        return coefficients

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {"restitution_law": POLYNOMIAL, "numbers": np.array(self.coefficients)}


class ConstantRestitution(_Restitution):
    """The same restitution at every contact: a_nc = value."""

    law: Literal["constant"]
    value: Coefficient
    valid_speed: SpeedRange | None = None
    source: Text

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {"restitution_law": CONSTANT, "coefficient": self.value}


class PowerRestitution(_Restitution):
    """Restitution that falls with a power of the normal contact speed.

    With v_c the normal component of the contact velocity (m/s),

        a_nc = min(1, coefficient (|v_c| / reference_speed)^(-exponent)).

    The limit belongs to the law: the power alone grows without bound towards rest. Form: e.g.
    K. L. Johnson, Contact Mechanics (1985), sec. 11.5, fully plastic impact, exponent 1/4.
    """

    law: Literal["power"]
    #: Restitution at the reference speed, where it is below 1.
    coefficient: Annotated[float, Field(gt=0.0, le=1e6)]
    reference_speed: Annotated[float, Field(gt=0.0, le=1e5)]
    exponent: Annotated[float, Field(gt=0.0, le=2.0)]
    valid_speed: SpeedRange | None = None
    source: Text

    @property
    def depends_on_speed(self) -> bool:
        """Whether a_nc depends on the contact speed: yes."""
        return True

    def _abscissa(self, speed: FloatArray) -> FloatArray:
        # proportional to a_nc at normal impact where that is below 1
        return (speed / self.reference_speed) ** -self.exponent

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {
            "restitution_law": POWER,
            "coefficient": self.coefficient * self.reference_speed**self.exponent,
            "exponent": self.exponent,
        }


class TabulatedRestitution(_Restitution):
    """Restitution from a table over the angle and the speed of the contact.

    Bilinear in beta = asin(|v_c| / |V_c|), measured from the wall, and |V_c|; constant beyond the
    ends of the table. An axis of one node stands for no dependence on it.
    """

    law: Literal["tabulated"]
    angle_deg: Increasing[Annotated[float, Field(ge=0.0, le=90.0)]]
    #: Contact speeds, m/s.
    speed: Increasing[Positive]
    #: One row for each angle, with one number for each speed.
    value: tuple[tuple[Coefficient, ...], ...]
    valid_speed: SpeedRange | None = None
    source: Text

    @model_validator(mode="after")
    def _table_fits(self) -> Self:
        rows, columns = len(self.angle_deg), len(self.speed)
        if len(self.value) != rows or any(len(row) != columns for row in self.value):
            allowed = f"{rows} rows (angle_deg) of {columns} numbers (speed)"
            raise refusal("value", self.value, allowed)
        return self

    @property
    def depends_on_speed(self) -> bool:
        """Whether a_nc depends on the contact speed: where a row has two values."""
        return any(len(set(row)) > 1 for row in self.value)

    def _abscissa(self, speed: FloatArray) -> FloatArray:
        # default nodes lie a factor of at most 1.43 apart
        return 1.0 / speed if self.depends_on_speed else super()._abscissa(speed)

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        table = pack_table(np.radians(self.angle_deg), np.array(self.speed), np.array(self.value))
        return {"restitution_law": TABULATED, "numbers": table}


RestitutionLaw = (
    ExponentialRestitution
    | PolynomialRestitution
    | ConstantRestitution
    | PowerRestitution
    | TabulatedRestitution
)
