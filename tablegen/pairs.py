"""Material pairs: what happens at one contact of a given particle material with a given wall."""

from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from tablegen.fields import Name, Positive, Record, SpeedRange, Text


class LawArguments(NamedTuple):
    """Contact laws as plain numbers, for kernels."""

    #: Coefficient of the restitution law, (s/m)^exponent.
    coefficient: float
    #: Exponent of the restitution law.
    exponent: float
    #: Factor in the exponent of the resistance law.
    strength: float


class RestitutionLaw(Record):
    """Normal restitution at the contact point, measured for the pair.

    With V_c the velocity of the contact point (m/s) and v_c its normal component,

        a_nc = 1 - [1 - exp(-coefficient |V_c|^exponent)] |v_c| / |V_c|.

    Source: form and corundum-on-steel coefficients as in Panfilov and Tsirkunov (2022), eq. 6.
    """

    law: Literal["exponential"]
    coefficient: Positive
    exponent: Annotated[float, Field(gt=0.0, le=10.0)]
    valid_speed: SpeedRange
    source: Text

    def coordinate(self, speed: ArrayLike) -> NDArray[np.float64]:
        """Abscissa for interpolation in impact speed: exp(-coefficient speed^exponent).

        Speed enters the model only through this law, so rebound statistics are nearly linear in
        this coordinate. It falls strictly from 1 at rest towards 0.

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


class ResistanceLaw(Record):
    """Sliding resistance at the contact, from the particle's orientation.

    With r_c the contact point from the centre of mass and V_p the velocity of that centre before
    the collision,

        C_f = exp(strength r_c . V_p / (|r_c| |V_p|)).

    Source: Panfilov and Tsirkunov (2022), eq. 7, where the strength is 1.
    """

    law: Literal["exponential-orientation"]
    strength: Annotated[float, Field(ge=0.0, le=10.0)]
    source: Text


class MaterialPair(Record):
    """Particle material, wall material, and the laws of their contact."""

    #: Filled in where a scene refers to a pair by name.
    name: Name | None = None
    particle: Text
    wall: Text
    restitution: RestitutionLaw
    resistance: ResistanceLaw

    def kernel_arguments(self) -> LawArguments:
        """Contact laws as plain numbers, for kernels.

        Returns
        -------
        LawArguments
        """
        return LawArguments(
            self.restitution.coefficient, self.restitution.exponent, self.resistance.strength
        )
