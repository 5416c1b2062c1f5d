"""Result of a calibration, as records."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from tablegen.config.config import Config
from tablegen.measured.measurements import SPREAD
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class ComparedNumber:
    """A measured mean or spread beside the simulated one."""

    #: Row of the measurements, from 0.
    row: int
    alpha_deg: float
    #: m/s; None if not stated.
    speed: float | None
    #: Name of the column: a quantity, or its spread.
    column: str
    measured: float
    simulated: float
    #: Chance error of the simulated number.
    chance: float
    #: How far a mean may be off; spreads are not followed.
    tolerance: float | None = None

    @property
    def residual(self) -> float:
        """Simulated less measured number."""
        return self.simulated - self.measured

    @property
    def miss(self) -> float:
        """Residual of a mean over its tolerance."""
        return abs(self.residual) / self.tolerance if self.tolerance else 0.0

    @property
    def place(self) -> str:
        """Name the row in words."""
        speed = "" if self.speed is None else f" and {self.speed:g} m/s"
        return f"{self.alpha_deg:g} degrees{speed}"


@dataclass(frozen=True)
class Fit:
    """The smoothest laws for one population, or one given form of the laws."""

    #: Name of the grains.
    grains: str
    config: Config
    #: Names of the k fitted numbers, the numbers, and their standard errors, NaN if not computed.
    labels: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    #: How far the data determine each number, 0 to 1, and not smoothness, (k,).
    determined: FloatArray
    #: Roughness of the laws: root mean square of the differences that the fit makes small.
    roughness: float
    #: Means and spreads, simulated with random numbers of their own.
    numbers: tuple[ComparedNumber, ...]
    cpu_seconds: float

    @property
    def means(self) -> list[ComparedNumber]:
        """Means, the worst first."""
        means = (one for one in self.numbers if one.tolerance is not None)
        return sorted(means, key=lambda one: -one.miss)

    @property
    def spreads(self) -> list[ComparedNumber]:
        """Spreads that a ratio can be taken of."""
        found = (one for one in self.numbers if one.column.endswith(SPREAD))
        return [one for one in found if one.measured > 0.0 and one.simulated > 0.0]

    @property
    def holds(self) -> bool:
        """Whether all means are within their tolerances."""
        return self.means[0].miss <= 1.0

    @property
    def spread_distance(self) -> float:
        """Root mean square of the logarithm of simulated over measured spreads; NaN without."""
        ratios = np.array([one.simulated / one.measured for one in self.spreads])
        return float(np.sqrt(np.mean(np.log(ratios) ** 2))) if ratios.size else float("nan")


@dataclass(frozen=True)
class Calibration:
    """A pair that follows measured rebounds, and the fits that it was chosen from."""

    fits: tuple[Fit, ...]
    #: The chosen one; where none holds the means, that which comes nearest.
    chosen: Fit
    #: What looks wrong in the measurements, and which rows are missed; empty if nothing.
    advice: str = ""

    @property
    def config(self) -> Config:
        """The fitted pair, with the text of its file."""
        return self.chosen.config

    @property
    def missed(self) -> bool:
        """Whether no grains hold the means."""
        return not self.chosen.holds

    def to_dict(self) -> dict[str, object]:
        """Give everything as plain data for JSON; None: unknown."""
        fits = [
            {
                "grains": fit.grains,
                "holds": fit.holds,
                "worst_miss": fit.means[0].miss,
                "spread_distance": _plain([fit.spread_distance])[0],
                "roughness": fit.roughness,
                "cpu_seconds": fit.cpu_seconds,
                "parameters": _parameters(fit),
                "numbers": [asdict(one) | {"residual": one.residual} for one in fit.numbers],
            }
            for fit in self.fits
        ]
        return {
            "pair": self.config.name,
            "grains": self.chosen.grains,
            "missed": self.missed,
            "advice": self.advice,
            "fits": fits,
            "config": self.config.text,
        }


def _parameters(fit: Fit) -> Sequence[dict[str, object]]:
    names = ("name", "value", "standard_error", "determined")
    columns = (_plain(fit.values), _plain(fit.errors), _plain(fit.determined))
    return [dict(zip(names, one, strict=True)) for one in zip(fit.labels, *columns, strict=True)]


def _plain(values: Iterable[float]) -> list[float | None]:
    """Make plain numbers; None if not finite."""
    return [float(value) if np.isfinite(value) else None for value in values]
