"""Laws of resistance to sliding at the contact, as a pair file states them.

`tablegen.model.contact_laws` and `tablegen.model.coulomb` have the kernels; tables/LAWS.md shows
how a file names them.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tablegen.config.field_types import Increasing, Record, Text
from tablegen.config.messages import refusal
from tablegen.model.contact_laws import (
    CONSTANT_RESISTANCE,
    COULOMB,
    ORIENTATION,
    TABULATED_RESISTANCE,
    pack_table,
)

#: Coefficient of resistance to sliding, or of friction.
Coefficient = Annotated[float, Field(ge=0.0, le=100.0)]


class OrientationResistance(Record):
    """Sliding resistance at the contact, from the particle's orientation.

    With r_c the contact point from the centre of mass and V_p the velocity of that centre before
    the collision,

        C_f = factor exp(strength r_c . V_p / (|r_c| |V_p|)).

    Source: Panfilov and Tsirkunov (2022), eq. 7, where strength and factor are 1. Below zero the
    resistance is least where the contact lies ahead of the motion, as at steep impact.
    """

    law: Literal["exponential-orientation"]
    strength: Annotated[float, Field(ge=-10.0, le=10.0)]
    factor: Coefficient = 1.0
    source: Text

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {
            "resistance_law": ORIENTATION,
            "strength": self.strength,
            "factor": self.factor,
        }


class ConstantResistance(Record):
    """The same sliding resistance at every contact: C_f = value; 0 lets contacts slide freely."""

    law: Literal["constant"]
    value: Coefficient
    source: Text

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {"resistance_law": CONSTANT_RESISTANCE, "factor": self.value}


class CoulombResistance(Record):
    """Coulomb friction with stick and slip, at every instant of a collision.

    A contact that slides along e has dS_t = -dynamic e dS_n. One that has come to rest sticks if
    |dS_t| <= static dS_n can hold it, and else slides anew. The restitution a_nc is then Stronge's
    energetic one: its square is the part of the work of compression that is given back.

    Source: Stronge, Proc. R. Soc. Lond. A 431 (1990) 169-181.
    """

    law: Literal["coulomb"]
    static: Coefficient
    dynamic: Coefficient
    source: Text

    @model_validator(mode="after")
    def _static_holds(self) -> Self:
        if self.dynamic > self.static:
            raise refusal("dynamic", self.dynamic, f"0 to static, {self.static:g}")
        return self

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {"resistance_law": COULOMB, "strength": self.static, "factor": self.dynamic}


class TabulatedResistance(Record):
    """Sliding resistance from a table over the impact angle at the contact.

    C_f is linear in beta = asin(|v_c| / |V_c|), measured from the wall, between the angles of the
    table, and constant beyond its ends.
    """

    law: Literal["tabulated"]
    angle_deg: Increasing[Annotated[float, Field(ge=0.0, le=90.0)]]
    #: One number for each angle.
    value: tuple[Coefficient, ...]
    source: Text

    @model_validator(mode="after")
    def _table_fits(self) -> Self:
        if len(self.value) != len(self.angle_deg):
            allowed = f"{len(self.angle_deg)} numbers, one for each of angle_deg"
            raise refusal("value", self.value, allowed)
        return self

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        values = np.array(self.value)[:, None]
        table = pack_table(np.radians(self.angle_deg), np.ones(1), values)
        return {"resistance_law": TABULATED_RESISTANCE, "resistances": table}


ResistanceLaw = OrientationResistance | ConstantResistance | TabulatedResistance | CoulombResistance
