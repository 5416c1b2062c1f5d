"""Laws of resistance to sliding at the contact, as a pair file states them.

`tablegen.model.contact_laws` has the kernel of each; tables/LAWS.md shows how a file names them.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from tablegen.configuration.field_types import Record, Text
from tablegen.model.contact_laws import CONSTANT_RESISTANCE, ORIENTATION


class OrientationResistance(Record):
    """Sliding resistance at the contact, from the particle's orientation.

    With r_c the contact point from the centre of mass and V_p the velocity of that centre before
    the collision,

        C_f = factor exp(strength r_c . V_p / (|r_c| |V_p|)).

    Source: Panfilov and Tsirkunov (2022), eq. 7, where strength and factor are 1.
    """

    law: Literal["exponential-orientation"]
    strength: Annotated[float, Field(ge=0.0, le=10.0)]
    factor: Annotated[float, Field(ge=0.0, le=100.0)] = 1.0
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
    value: Annotated[float, Field(ge=0.0, le=100.0)]
    source: Text

    def kernel_entries(self) -> Mapping[str, Any]:
        """Entries of `LawArguments` that the law sets."""
        return {"resistance_law": CONSTANT_RESISTANCE, "factor": self.value}


ResistanceLaw = OrientationResistance | ConstantResistance
