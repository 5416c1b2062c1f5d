"""Cases of the stability study: particles, impacts and spins up to the extremes.

The spin before an impact is along the wall axis z, the normal of the impact plane: it alone acts
on the sliding of a symmetric body, and its sign matters. With spin s [V / a] the lowest point of
a sphere slides at cos(alpha1) + s: at -1 it rolls at grazing impact, at +1 it slides twice as fast.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.config.messages import shown
from tablegen.config.population import Population
from tablegen.model.shape_codes import SHAPE_NAMES

#: Ratios b/a and c/b from round to slender and flat.
_RATIOS = (1.0, 0.999, 0.5, 0.05, 0.02)
_QUICK_RATIOS = (1.0, 0.5, 0.02)

#: Ratio below which a body counts as slender (b/a) or flat (c/b), and from which on as round.
_SMALL, _ROUND = 0.1, 0.99

#: Forms by (slender, flat).
_FORMS = {
    (True, True): "blade",
    (True, False): "needle",
    (False, True): "disc",
    (False, False): "block",
}
FORMS = ("near-sphere", *_FORMS.values())


@dataclass(frozen=True)
class Case:
    """One particle form at one impact condition.

    Attributes
    ----------
    shape : str
        A name of `tablegen.model.shape_codes.SHAPE_NAMES`.
    aspect : tuple of two floats
        b / a and c / b.
    alpha_deg : float
        Impact angle [degrees].
    speed : float
        Impact speed [m/s].
    spin : float
        Angular velocity before the impact along the wall axis z, times a / V.
    """

    shape: str
    aspect: tuple[float, float]
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
        if min(ba, cb) >= _ROUND:
            return FORMS[0]
        return _FORMS[ba <= _SMALL, cb <= _SMALL]

    def population(self, config: Config) -> Population:
        """Particles of this form only; prisms are truncated as the configuration says."""
        return config.population.restricted_to(self.shape).with_aspect(*self.aspect)


@dataclass(frozen=True)
class Grid:
    """Product of shapes, pairs of ratios, angles [degrees], speeds [m/s] and spins [V / a].

    A sphere has the ratios 1 and 1 only, whatever pairs the others have.
    """

    shapes: tuple[str, ...]
    aspects: tuple[tuple[float, float], ...]
    angles_deg: tuple[float, ...]
    speeds: tuple[float, ...]
    spins: tuple[float, ...]

    def narrowed(self, axes: "Grid") -> "Grid":
        """Replace the axes of this grid by those of another that are not empty.

        Raises
        ------
        InputError
            If the only shape is the sphere, with ratios other than 1 and 1.
        """
        if axes.shapes == ("sphere",) and set(axes.aspects) - {(1.0, 1.0)}:
            raise InputError(f"aspect: got {shown(axes.aspects[0])}, allowed for spheres: [1, 1]")
        return Grid(
            shapes=axes.shapes or self.shapes,
            aspects=axes.aspects or self.aspects,
            angles_deg=axes.angles_deg or self.angles_deg,
            speeds=axes.speeds or self.speeds,
            spins=axes.spins or self.spins,
        )

    def cases(self) -> Iterator[Case]:
        """Yield all cases in a fixed order."""
        for shape in self.shapes:
            aspects = ((1.0, 1.0),) if shape == "sphere" else self.aspects
            rest = itertools.product(aspects, self.angles_deg, self.speeds, self.spins)
            for aspect, alpha_deg, speed, spin in rest:
                yield Case(shape, aspect, alpha_deg, speed, spin)


FULL = Grid(
    shapes=SHAPE_NAMES,
    aspects=tuple((ba, cb) for ba in _RATIOS for cb in _RATIOS),
    angles_deg=(0.01, 0.5, 1.0, 20.0, 45.0, 70.0, 89.99, 90.0),
    speeds=(1.0, 10.0, 50.0, 300.0, 3000.0),
    spins=(0.0, 1.0, -1.0, 5.0, -5.0, 50.0, -50.0),
)

#: Ends and middles of every axis, without spins of 50 V / a, which cost most at grazing impact.
QUICK = Grid(
    shapes=SHAPE_NAMES,
    aspects=tuple((ba, cb) for ba in _QUICK_RATIOS for cb in _QUICK_RATIOS),
    angles_deg=(0.01, 1.0, 45.0, 90.0),
    speeds=(1.0, 50.0, 300.0, 3000.0),
    spins=(0.0, 1.0, -1.0, 5.0),
)
