"""Laws of normal restitution at the contact, as a pair file states them.

`tablegen.model.contact_laws` has the kernel of each; tables/LAWS.md shows how a file names them.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from tablegen.configuration.field_types import Nodes, Positive, Record, SpeedRange, Text, refusal
from tablegen.model.contact_laws import (
    CONSTANT,
    EXPONENTIAL,
    POLYNOMIAL,
    POWER,
    TABULATED,
    pack_table,
)

FloatArray = NDArray[np.float64]

#: How far rounding may carry a restitution coefficient out of [0, 1].
_ROUNDING = 1e-12

#: Exponent of the abscissa of laws that ignore the speed: so small that two nodes span any range.
_FAINT = 0.01

#: Most terms of a polynomial; more say nothing about measurements.
_TERMS = 16


def _as_tuples(value: object) -> object:
    """TOML arrays arrive as lists, perhaps of lists; a frozen record holds tuples."""
    return tuple(_as_tuples(item) for item in value) if isinstance(value, list) else value


def _some_terms(values: tuple[float, ...]) -> tuple[float, ...]:
    """Refuse a polynomial with no terms, or with too many."""
    if not 1 <= len(values) <= _TERMS:
        raise refusal(f"1 to {_TERMS} numbers", given=values)
    return values


def _within_right_angle(nodes: tuple[float, ...]) -> tuple[float, ...]:
    """Refuse angles that no impact has."""
    if not 0.0 <= nodes[0] <= nodes[-1] <= 90.0:
        raise refusal("angles from 0 to 90 degrees, each larger than the one before", given=nodes)
    return nodes


def _positive_speeds(nodes: tuple[float, ...]) -> tuple[float, ...]:
    """Refuse speeds at or below rest."""
    if not nodes[0] > 0.0:
        raise refusal("speeds above 0 m/s, each larger than the one before", given=nodes)
    return nodes


def _rows(value: object) -> object:
    """Refuse what is not a table of numbers before its items are looked at."""
    rows = _as_tuples(value)
    if not isinstance(rows, tuple) or not all(isinstance(row, tuple) for row in rows):
        raise refusal("a list of rows of numbers, [[...], [...]]", given=value)
    return rows


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
        """Abscissa for interpolation in impact speed; here for a law that ignores the speed.

        Speed enters the model only through the law of restitution, so without it every speed has
        the same rebound statistics, any abscissa serves, and nodes at the ends are enough.

        Parameters
        ----------
        speed : array_like of float
            Impact speed, m/s, positive.

        Returns
        -------
        float64 array
            Shape of `speed`; positive, strictly falling with the speed. Default nodes are equally
            spaced in its logarithm.
        """
        return np.asarray(speed, dtype=np.float64) ** -_FAINT


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

    def coordinate(self, speed: ArrayLike) -> FloatArray:
        """Abscissa for interpolation in impact speed: exp(-coefficient speed^exponent).

        It is a_nc at normal impact, in which rebound statistics are nearly linear; it falls from 1
        at rest towards 0.

        Parameters
        ----------
        speed : array_like of float
            Impact speed, m/s, not negative.

        Returns
        -------
        float64 array
            Shape of `speed`, dimensionless.
        """
        return np.exp(-self.coefficient * np.asarray(speed, dtype=np.float64) ** self.exponent)

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
    coefficients: Annotated[
        tuple[float, ...], BeforeValidator(_as_tuples), AfterValidator(_some_terms)
    ]
    valid_speed: SpeedRange | None = None
    source: Text

    @model_validator(mode="after")
    def _physical(self) -> Self:
        polynomial = np.polynomial.Polynomial(self.coefficients)
        # Extremes lie at the ends or where the slope is zero; the grid stands in for turning
        # points that a root finder loses to a vanishing leading coefficient.
        turns = polynomial.trim().deriv().roots().real
        grid = np.linspace(0.0, np.pi / 2, 2001)
        angles = np.append(grid, turns[(turns > 0.0) & (turns < np.pi / 2)])
        values = polynomial(angles)
        worst = int(np.argmax(np.abs(values - 0.5)))
        if not abs(values[worst] - 0.5) <= 0.5 + _ROUNDING:
            raise refusal(
                "a polynomial within 0 to 1 from 0 to 90 degrees; this one is "
                f"{values[worst]:.4g} at {np.degrees(angles[worst]):.3g} degrees",
                given=self.coefficients,
                field="coefficients",
            )
        return self

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {"restitution_law": POLYNOMIAL, "numbers": np.array(self.coefficients)}


class ConstantRestitution(_Restitution):
    """The same restitution at every contact: a_nc = value."""

    law: Literal["constant"]
    value: Annotated[float, Field(ge=0.0, le=1.0)]
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

    def coordinate(self, speed: ArrayLike) -> FloatArray:
        """Abscissa for interpolation in impact speed: (speed / reference_speed)^(-exponent).

        It is proportional to a_nc at normal impact where that is below 1.

        Parameters
        ----------
        speed : array_like of float
            Impact speed, m/s, positive.

        Returns
        -------
        float64 array
            Shape of `speed`, dimensionless, strictly falling.
        """
        ratio = np.asarray(speed, dtype=np.float64) / self.reference_speed
        return ratio**-self.exponent

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
    angle_deg: Annotated[Nodes, AfterValidator(_within_right_angle)]
    #: Contact speeds, m/s.
    speed: Annotated[Nodes, AfterValidator(_positive_speeds)]
    #: One row for each angle, with one number for each speed.
    value: Annotated[tuple[tuple[float, ...], ...], BeforeValidator(_rows)]
    valid_speed: SpeedRange | None = None
    source: Text

    @model_validator(mode="after")
    def _table_fits(self) -> Self:
        rows, columns = len(self.angle_deg), len(self.speed)
        widths = {len(row) for row in self.value}
        if len(self.value) != rows or widths != {columns}:
            raise refusal(
                f"{rows} rows (angle_deg) of {columns} numbers (speed)",
                given=self.value,
                field="value",
            )
        for i, row in enumerate(self.value):
            for j, number in enumerate(row):
                if not 0.0 <= number <= 1.0:
                    raise refusal("a number from 0 to 1", given=number, field=f"value[{i}][{j}]")
        return self

    @property
    def depends_on_speed(self) -> bool:
        """Whether a_nc depends on the contact speed: where a row has two values."""
        return any(len(set(row)) > 1 for row in self.value)

    def coordinate(self, speed: ArrayLike) -> FloatArray:
        """Abscissa for interpolation in impact speed: 1 / speed.

        Default nodes then lie a factor of at most 1.43 apart. A table that ignores the speed has
        the abscissa of such laws.

        Parameters
        ----------
        speed : array_like of float
            Impact speed, m/s, positive.

        Returns
        -------
        float64 array
            Shape of `speed`, strictly falling.
        """
        if not self.depends_on_speed:
            return super().coordinate(speed)
        return 1.0 / np.asarray(speed, dtype=np.float64)

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
