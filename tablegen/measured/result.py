"""Result of a calibration, as records."""

import math
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
    #: Standard error of the measured number by its count; None if not known.
    error: float | None
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
    #: Names of the k fitted numbers, the numbers, and their standard errors; NaN if smoothness or
    #: a bound decides a number, and not the data.
    labels: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    #: Means and spreads, simulated with random numbers of their own.
    numbers: tuple[ComparedNumber, ...]

    @property
    def means(self) -> list[ComparedNumber]:
        """Means, the worst first."""
        means = (one for one in self.numbers if one.tolerance is not None)
        return sorted(means, key=lambda one: -one.miss)

    @property
    def spreads(self) -> list[ComparedNumber]:
        """Spreads that a ratio can be taken of."""
        spreads = (one for one in self.numbers if one.column.endswith(SPREAD))
        return [one for one in spreads if one.measured > 0.0 and one.simulated > 0.0]

    @property
    def holds(self) -> bool:
        """Whether all means are within their tolerances."""
        return self.means[0].miss <= 1.0

    @property
    def spread_distance(self) -> float:
        """Root mean square of the logarithm of simulated over measured spreads; NaN without."""
        ratios = np.array([one.simulated / one.measured for one in self.spreads])
        return float(np.sqrt(np.mean(np.log(ratios) ** 2))) if ratios.size else float("nan")

    @property
    def misfit(self) -> float:
        """Number by which grains are chosen, 1 at best.

        It is the worst mean over its tolerance, or 1 if all means are within theirs, times the
        typical factor between simulated and measured spreads, if spreads were measured.
        """
        factor = math.exp(self.spread_distance) if self.spreads else 1.0
        return max(self.means[0].miss, 1.0) * factor

    def to_dict(self) -> dict[str, object]:
        """Give everything as plain data for JSON; None: no spreads, no standard error."""
        names = ("name", "value", "standard_error")
        errors = (None if np.isnan(error) else float(error) for error in self.errors)
        numbers = zip(self.labels, self.values.tolist(), errors, strict=True)
        return {
            "grains": self.grains,
            "holds": self.holds,
            "misfit": self.misfit,
            "worst_miss": self.means[0].miss,
            "spread_distance": self.spread_distance if self.spreads else None,
            "parameters": [dict(zip(names, one, strict=True)) for one in numbers],
            "numbers": [asdict(one) | {"residual": one.residual} for one in self.numbers],
        }


@dataclass(frozen=True)
class Calibration:
    """Contact laws that were fitted to measured rebounds, from `calibrate`.

    Attributes
    ----------
    fits : tuple of Fit
        One fit for each population of grains that was tried.
    chosen : Fit
        The fit with the least misfit.
    advice : str
        What looks wrong in the measurements, and which rows are missed; "" if nothing.
    """

    fits: tuple[Fit, ...]
    chosen: Fit
    advice: str = ""

    @property
    def config(self) -> Config:
        """Configuration of the fitted pair, with the text of its file."""
        return self.chosen.config

    @property
    def missed(self) -> bool:
        """Whether the chosen fit misses some measured means."""
        return not self.chosen.holds

    def to_dict(self) -> dict[str, object]:
        """Give everything as plain data for JSON."""
        chosen = {"grains": self.chosen.grains, "missed": self.missed, "advice": self.advice}
        fits = [fit.to_dict() for fit in self.fits]
        return {"pair": self.config.name, **chosen, "fits": fits, "config": self.config.text}
