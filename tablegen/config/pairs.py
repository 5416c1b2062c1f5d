"""Material pairs: what happens at one contact of a given particle material with a given wall.

A pair file names one law of restitution (`tablegen.config.restitution`) and one of resistance
(`tablegen.config.resistance`), each with its coefficients and its source; tables/LAWS.md shows
how.
"""

from typing import Annotated, Any

import numpy as np
from pydantic import Field

from tablegen.config.field_types import Line, Name, Record
from tablegen.config.resistance import ResistanceLaw
from tablegen.config.restitution import RestitutionLaw
from tablegen.model.contact_laws import LawArguments


class MaterialPair(Record):
    """Particle material, wall material, and the laws of their contact."""

    #: Filled in where a scene refers to a pair by name.
    name: Name | None = None
    particle: Line
    wall: Line
    restitution: Annotated[RestitutionLaw, Field(discriminator="law")]
    resistance: Annotated[ResistanceLaw, Field(discriminator="law")]

    def extrapolation(self, speed: float) -> str | None:
        """Say why an impact speed lies outside what the law of restitution was measured for.

        Parameters
        ----------
        speed : float
            Impact speed [m/s].

        Returns
        -------
        str or None
            None if the law's validity range holds it.
        """
        valid = self.restitution.valid_speed
        if valid is None:
            return "the restitution law states no range of speeds in which it was measured"
        if valid[0] <= speed <= valid[1]:
            return None
        return (
            f"the restitution law was measured at {valid[0]:g} to {valid[1]:g} m/s; "
            f"{speed:g} m/s extrapolates it"
        )

    def kernel_arguments(self) -> LawArguments:
        """Contact laws as plain numbers, for kernels.

        Returns
        -------
        LawArguments
        """
        entries: dict[str, Any] = dict.fromkeys(
            ("coefficient", "exponent", "strength", "factor"), 0.0
        )
        entries |= {"numbers": np.zeros(0), "resistances": np.zeros(0)}
        entries |= {**self.restitution.kernel_entries(), **self.resistance.kernel_entries()}
        return LawArguments(**entries)
