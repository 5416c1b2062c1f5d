"""Material pairs: the laws of restitution and of resistance to sliding at one contact.

`tablegen.model.contact_laws` and `tablegen.model.coulomb` have the kernels of the laws, and
tables/LAWS.md shows how a file states them. The contact point moves with V_c [m/s] and has the
normal velocity v_c; beta = asin(|v_c| / |V_c|) is the impact angle at the contact, from the wall.
"""

from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, field_validator, model_validator

from sampler.covered import ends_text
from sampler.errors import InputError
from sampler.formats import bounds
from tablegen.config.complaints import refusal, shown
from tablegen.config.field_types import Increasing, Line, Name, Positive, Record, SpeedRange, Text
from tablegen.model import contact_laws as kernels
from tablegen.model.float_array import FloatArray

#: How far a restitution coefficient may be outside of [0, 1] by rounding.
_ROUNDING = 1e-12

#: Exponent of the abscissa of laws that do not depend on the speed. It is so small that two nodes
#: are enough for any range.
_FAINT = 0.01

#: Restitution coefficient.
Restitution = Annotated[float, Field(ge=0.0, le=1.0)]

#: Coefficient of resistance to sliding, or of friction.
Resistance = Annotated[float, Field(ge=0.0, le=100.0)]

ContactAngle = Annotated[float, Field(ge=0.0, le=90.0)]

#: Tangential restitution: 1 reverses the tangential contact velocity, 0 ends it, -1 leaves it.
Reversals = tuple[Annotated[float, Field(ge=-1.0, le=1.0)], ...]


class _Restitution(Record):
    """Base of the laws of a_nc, the ratio of the normal contact velocities after and before.

    At any contact speed and angle, 0 <= a_nc <= 1. A law that can leave this range is refused when
    it is read.
    """

    @property
    def depends_on_speed(self) -> bool:
        """Whether a_nc, and with it the rebound statistics, depend on the contact speed."""
        return False

    def coordinate(self, speed: ArrayLike) -> FloatArray:
        """Compute the abscissa for interpolation in impact speed [m/s].

        It decreases strictly with the speed, and rebound statistics are nearly linear in it.
        """
        return self._abscissa(np.asarray(speed, dtype=np.float64))

    def _abscissa(self, speed: FloatArray) -> FloatArray:
        # a law without speed could use any abscissa; with this one, nodes at the ends are enough
        return speed**-_FAINT


class ExponentialRestitution(_Restitution):
    """Restitution that falls with the contact speed towards normal impact.

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


class PolynomialRestitution(_Restitution):
    """Restitution as a polynomial in the impact angle at the contact, in radians.

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
        # The extremes are at the ends or where the slope is zero. The grid is for turning points
        # that the root finder misses if the leading coefficient is nearly zero.
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


class ConstantRestitution(_Restitution):
    """The same restitution at every contact: a_nc = value."""

    law: Literal["constant"]
    value: Restitution
    valid_speed: SpeedRange | None = None
    source: Text


class PowerRestitution(_Restitution):
    """Restitution that falls with a power of the normal contact speed.

        a_nc = min(1, coefficient (|v_c| / reference_speed)^(-exponent)).

    The limit is part of the law, because the power alone grows without bound towards rest. Source
    of the form: K. L. Johnson, Contact Mechanics (1985), section 11.5, fully plastic impact with
    the exponent 1/4.
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
        # proportional to a_nc at normal impact, where a_nc is below 1
        return (speed / self.reference_speed) ** -self.exponent


class TabulatedRestitution(_Restitution):
    """Restitution from a table over the angle and the speed of the contact.

    It is bilinear in beta and |V_c|, and constant beyond the ends of the table. With one node on an
    axis the law does not depend on that quantity.
    """

    law: Literal["tabulated"]
    angle_deg: Increasing[ContactAngle]
    #: Contact speeds, m/s.
    speed: Increasing[Positive]
    #: One row for each angle, with one number for each speed.
    value: tuple[tuple[Restitution, ...], ...]
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
        """Whether a_nc depends on the contact speed: whether a row has different values."""
        return any(len(set(row)) > 1 for row in self.value)

    def _abscissa(self, speed: FloatArray) -> FloatArray:
        # the law is linear in the speed between its nodes, and a table has these nodes too
        return -speed if self.depends_on_speed else super()._abscissa(speed)


RestitutionLaw = (
    ExponentialRestitution
    | PolynomialRestitution
    | ConstantRestitution
    | PowerRestitution
    | TabulatedRestitution
)


class OrientationResistance(Record):
    """Sliding resistance at the contact that depends on the orientation of the particle.

    With r_c the contact point from the centre of mass and V_p the velocity of that centre before
    the collision,

        C_f = factor exp(strength r_c . V_p / (|r_c| |V_p|)).

    Source: Panfilov and Tsirkunov (2022), eq. 7, where strength and factor are 1. With a negative
    strength the resistance is least where the contact lies ahead of the motion, as at steep impact.
    """

    law: Literal["exponential-orientation"]
    strength: Annotated[float, Field(ge=-10.0, le=10.0)]
    factor: Resistance = 1.0
    source: Text


class ConstantResistance(Record):
    """The same sliding resistance at every contact: C_f = value. With 0, contacts slide freely."""

    law: Literal["constant"]
    value: Resistance
    source: Text


class CoulombResistance(Record):
    """Coulomb friction with stick and slip, at every instant of a collision.

    A contact that slides along e has dS_t = -dynamic e dS_n. A contact that has come to rest sticks
    if |dS_t| <= static dS_n can hold it, and otherwise slides again. The restitution a_nc is then
    Stronge's energetic restitution: its square is the share of the work of compression that is
    given back.

    A sphere that does not slide throughout the collision leaves with -`tangential_restitution`
    times its tangential contact velocity. That is [one number], or one for each impact angle at the
    contact in `angle_deg`, linear between them and constant beyond. By default it is 0, and the
    sphere rolls.

    Sources: Stronge, Proc. R. Soc. Lond. A 431 (1990) 169-181; Walton & Braun, J. Rheol. 30 (1986)
    949-980; Foerster, Louge, Chang & Allia, Phys. Fluids 6 (1994) 1108-1115.
    """

    law: Literal["coulomb"]
    static: Resistance
    dynamic: Resistance
    tangential_restitution: Reversals | None = None
    angle_deg: Increasing[ContactAngle] | None = None
    source: Text

    @model_validator(mode="after")
    def _static_holds(self) -> Self:
        if self.dynamic > self.static:
            raise refusal("dynamic", self.dynamic, f"0 to static, {self.static:g}")
        return self

    @model_validator(mode="after")
    def _number_for_each_angle(self) -> Self:
        angles, given = len(self.angle_deg or (90.0,)), self.tangential_restitution or ()
        if len(given) != angles and (given or self.angle_deg):
            allowed = (
                "one number" if angles == 1 else f"{angles} numbers, one for each of angle_deg"
            )
            raise refusal("tangential_restitution", given, allowed)
        return self


class TabulatedResistance(Record):
    """Sliding resistance from a table over the impact angle at the contact.

    C_f is linear in beta between the angles of the table, and constant beyond its ends.
    """

    law: Literal["tabulated"]
    angle_deg: Increasing[ContactAngle]
    #: One number for each angle.
    value: tuple[Resistance, ...]
    source: Text

    @model_validator(mode="after")
    def _table_fits(self) -> Self:
        if len(self.value) != len(self.angle_deg):
            allowed = f"{len(self.angle_deg)} numbers, one for each of angle_deg"
            raise refusal("value", self.value, allowed)
        return self


ResistanceLaw = OrientationResistance | ConstantResistance | TabulatedResistance | CoulombResistance


def kernel_entries(law: RestitutionLaw | ResistanceLaw) -> dict[str, Any]:
    """Return the entries of `LawArguments` that a law sets, but its code."""
    match law:
        case ExponentialRestitution():
            return {"coefficient": law.coefficient, "exponent": law.exponent}
        case PolynomialRestitution():
            return {"numbers": np.array(law.coefficients)}
        case ConstantRestitution():
            return {"coefficient": law.value}
        case PowerRestitution():
            coefficient = law.coefficient * law.reference_speed**law.exponent
            return {"coefficient": coefficient, "exponent": law.exponent}
        case TabulatedRestitution():
            axes = np.radians(law.angle_deg), np.array(law.speed)
            numbers = kernels.pack_table(*axes, np.array(law.value))
            return {"numbers": numbers}
        case OrientationResistance():
            return {"strength": law.strength, "factor": law.factor}
        case ConstantResistance():
            return {"factor": law.value}
        case CoulombResistance():
            numbers = np.zeros(0)
            if law.tangential_restitution is not None:
                axes = np.radians(law.angle_deg or (90.0,)), np.ones(1)
                numbers = kernels.pack_table(*axes, np.array(law.tangential_restitution)[:, None])
            return {"strength": law.static, "factor": law.dynamic, "resistances": numbers}
        case TabulatedResistance():
            axes = np.radians(law.angle_deg), np.ones(1)
            numbers = kernels.pack_table(*axes, np.array(law.value)[:, None])
            return {"resistances": numbers}


class MaterialPair(Record):
    """Particle material, wall material, and the laws of their contact."""

    #: Name of the pair file, if a scene refers to one.
    name: Name | None = None
    particle: Line
    wall: Line
    restitution: Annotated[RestitutionLaw, Field(discriminator="law")]
    resistance: Annotated[ResistanceLaw, Field(discriminator="law")]

    def extrapolation(self, speed: float) -> str | None:
        """Say why an impact speed [m/s] extrapolates the law of restitution, or return None."""
        valid = self.restitution.valid_speed
        if valid is None:
            return "the restitution law states no range of speeds in which it was measured"
        if valid[0] <= speed <= valid[1]:
            return None
        return (
            f"the restitution law was measured at {ends_text(valid)} m/s; "
            f"{speed:g} m/s extrapolates it"
        )

    def kernel_arguments(self, only_spheres: bool = True) -> kernels.LawArguments:
        """Return the contact laws as kernels take them, as numbers and arrays.

        Raises `InputError` if the laws are for spheres and not all particles are spheres.
        """
        given = getattr(self.resistance, "tangential_restitution", None)
        if given is not None and not only_spheres:
            allowed = "nothing, because only a population of spheres alone may have it"
            raise InputError("pair.resistance.tangential_restitution", shown(given), allowed)
        unused = dict.fromkeys(("coefficient", "exponent", "strength", "factor"), 0.0)
        entries: dict[str, Any] = {**unused, "numbers": np.zeros(0), "resistances": np.zeros(0)}
        entries["restitution_law"] = bounds.RESTITUTION_LAWS.index(self.restitution.law)
        entries["resistance_law"] = bounds.RESISTANCE_LAWS.index(self.resistance.law)
        entries |= kernel_entries(self.restitution) | kernel_entries(self.resistance)
        return kernels.LawArguments(**entries)
