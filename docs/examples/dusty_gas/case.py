"""A case: gas, particles and body in SI units, and the numbers that the tracker needs."""

import math
from dataclasses import dataclass

from dusty_gas.gas import BODIES, Flow

#: Air at 300 K and 1 bar.
GAS_DENSITY = 1.16  # kg/m^3
VISCOSITY = 1.85e-5  # Pa s

#: Corundum.
PARTICLE_DENSITY = 3950.0  # kg/m^3

BODY_RADIUS = 0.1  # m


@dataclass(frozen=True)
class Case:
    """One body, one size of particles.

    Attributes
    ----------
    body : {"cylinder", "sphere"}
    stokes : float
        Stokes number rho_p d^2 U / (18 mu R), with the diameter d of a particle and the radius R
        of the body.
    speed : float
        Speed U of the stream, m/s.
    """

    body: str
    stokes: float
    speed: float = 200.0

    @property
    def diameter(self) -> float:
        """Diameter of the particles, m."""
        stopping = self.stokes * BODY_RADIUS / self.speed
        return math.sqrt(18.0 * VISCOSITY * stopping / PARTICLE_DENSITY)

    @property
    def reynolds(self) -> float:
        """Reynolds number of a particle at rest in the stream."""
        return GAS_DENSITY * self.speed * self.diameter / VISCOSITY

    def flow(self) -> Flow:
        """Drag and body, for the tracker."""
        return Flow(BODIES.index(self.body), 1.0 / self.stokes, self.reynolds)
