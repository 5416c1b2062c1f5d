"""Cases of the stability study: particles, impacts and spins up to the extremes."""

from dataclasses import dataclass
from itertools import product

from sampler.formats.shape_codes import SHAPE_NAMES
from tablegen.config.config import Config
from tablegen.config.population import Population

#: b/a and c/b, impact angles [degrees], speeds [m/s], and spins before the impact [V/a]. The quick
#: study has ends and middles without the spins of 50 V/a, the most expensive cases.
_RATIOS = (1.0, 0.999, 0.5, 0.05, 0.02)
_FULL = (
    (0.01, 0.5, 1.0, 20.0, 45.0, 70.0, 89.99, 90.0),
    (1.0, 10.0, 50.0, 300.0, 3000.0),
    (0.0, 1.0, -1.0, 5.0, -5.0, 50.0, -50.0),
)
_QUICK = ((0.01, 1.0, 45.0, 90.0), (1.0, 50.0, 300.0, 3000.0), (0.0, 1.0, -1.0, 5.0))


@dataclass(frozen=True)
class Case:
    """One particle form at one impact condition; the spin is along the wall axis z."""

    shape: str
    #: b/a and c/b.
    aspect: tuple[float, float]
    #: Impact angle [degrees], speed [m/s], and spin before the impact [V/a].
    alpha_deg: float
    speed: float
    spin: float

    def __str__(self) -> str:
        ba, cb = self.aspect
        return (
            f"{self.shape} with b/a {ba:g} and c/b {cb:g}, {self.alpha_deg:g} degrees, "
            f"{self.speed:g} m/s, spin {self.spin:g} V/a"
        )

    def population(self, config: Config) -> Population:
        """Restrict the population to this form, with prisms truncated as in the configuration."""
        return config.population.restricted_to(self.shape).with_aspect(*self.aspect)


def all_cases(quick: bool = False) -> list[Case]:
    """List the cases in a fixed order; a sphere has the ratios 1 and 1 only."""
    ratios, axes = (_RATIOS[::2], _QUICK) if quick else (_RATIOS, _FULL)
    return [
        Case(shape, *values)
        for shape in SHAPE_NAMES
        for values in product(
            ((1.0, 1.0),) if shape == "sphere" else tuple(product(ratios, ratios)), *axes
        )
    ]
