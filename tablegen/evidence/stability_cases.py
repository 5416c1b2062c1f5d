"""Cases of the stability study: particles, impacts and spins up to the extremes."""

from collections.abc import Iterator
from dataclasses import astuple, dataclass
from itertools import product

from sampler.errors import InputError
from sampler.formats.shape_codes import SHAPE_NAMES
from tablegen.config.config import Config
from tablegen.config.population import Population

_RATIOS = (1.0, 0.999, 0.5, 0.05, 0.02)

FORMS = ("near-sphere", "blade", "needle", "disc", "block")


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
            f"{self.shape} {ba:g} {cb:g}, {self.alpha_deg:g} degrees, {self.speed:g} m/s, "
            f"spin {self.spin:g} V/a"
        )

    @property
    def form(self) -> str:
        """One of `FORMS`."""
        ba, cb = self.aspect
        if min(ba, cb) >= 0.99:
            return "near-sphere"
        if ba <= 0.1:
            return "blade" if cb <= 0.1 else "needle"
        return "disc" if cb <= 0.1 else "block"

    def population(self, config: Config) -> Population:
        """Particles of this form only, prisms truncated as in the configuration."""
        return config.population.restricted_to(self.shape).with_aspect(*self.aspect)


@dataclass(frozen=True)
class Grid:
    """Product of shapes, aspect ratios, angles [degrees], speeds [m/s] and spins [V/a]."""

    shapes: tuple[str, ...] = ()
    aspects: tuple[tuple[float, float], ...] = ()
    angles_deg: tuple[float, ...] = ()
    speeds: tuple[float, ...] = ()
    spins: tuple[float, ...] = ()

    def narrowed(self, axes: "Grid") -> "Grid":
        """Replace the axes of this grid by the axes of `axes` that are not empty.

        Raises `InputError` if the only shape is the sphere, and a ratio is not 1.
        """
        if axes.shapes == ("sphere",) and set(axes.aspects) - {(1.0, 1.0)}:
            ba, cb = axes.aspects[0]
            raise InputError(f"aspect: got [{ba:g}, {cb:g}], allowed for spheres: [1, 1]")
        return Grid(*(new or old for new, old in zip(astuple(axes), astuple(self), strict=True)))

    def cases(self) -> Iterator[Case]:
        """Yield all cases in a fixed order; a sphere has the ratios 1 and 1 only."""
        for shape in self.shapes:
            aspects = ((1.0, 1.0),) if shape == "sphere" else self.aspects
            for values in product(aspects, self.angles_deg, self.speeds, self.spins):
                yield Case(shape, *values)


FULL = Grid(
    shapes=SHAPE_NAMES,
    aspects=tuple((ba, cb) for ba in _RATIOS for cb in _RATIOS),
    angles_deg=(0.01, 0.5, 1.0, 20.0, 45.0, 70.0, 89.99, 90.0),
    speeds=(1.0, 10.0, 50.0, 300.0, 3000.0),
    spins=(0.0, 1.0, -1.0, 5.0, -5.0, 50.0, -50.0),
)

#: Ends and middles of every axis, without the spins of 50 V/a, the most expensive cases.
QUICK = Grid(
    shapes=SHAPE_NAMES,
    aspects=tuple((ba, cb) for ba in _RATIOS[::2] for cb in _RATIOS[::2]),
    angles_deg=(0.01, 1.0, 45.0, 90.0),
    speeds=(1.0, 50.0, 300.0, 3000.0),
    spins=(0.0, 1.0, -1.0, 5.0),
)
