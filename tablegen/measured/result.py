"""Task and result of a calibration, as records."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass

import numpy as np

from tablegen.checkpoints import software
from tablegen.config.config import Config
from tablegen.measured.measurements import SPREAD, Measurements, Spreads
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class Task:
    """Checked arguments of a calibration."""

    measurements: Measurements
    #: SHA-256 of the file of measurements; empty without a file.
    checksum: str
    start: Config
    free: tuple[str, ...]
    #: Rows that the fit uses, and rows that are held out.
    used: list[int]
    held: list[int]
    #: Impact speeds of all rows, and the given one of rows that state none.
    speeds: FloatArray
    speed: float | None
    wall_tilt_deg: float
    spreads: Spreads
    count: int
    seed: int
    threads: int | None

    @property
    def fingerprint(self) -> str:
        """Everything that decides the result."""
        m = self.measurements
        moments = [part for one in m.moments.values() for part in one]
        numbers = np.concatenate([m.alpha_deg, self.speeds, m.count, *moments]).tolist()
        rest = (self.free, self.held, self.spreads, self.wall_tilt_deg, self.count, self.seed)
        return f"{software()}\n{self.start.text}\n{numbers}\n{rest}"


@dataclass(frozen=True)
class FittedNumber:
    """A measured mean or spread beside the simulated one."""

    #: Row of the measurements, from 0.
    row: int
    alpha_deg: float
    #: m/s; None if not stated.
    speed: float | None
    #: Name of the column: a quantity, or its spread.
    column: str
    measured: float
    #: Standard error of the measured number: from its count, or assumed.
    accuracy: float
    #: Largest residual that errors explain, and whether it is one-sided, of an upper bound.
    allowed: float
    bound: bool
    simulated: float
    #: Chance error of the simulated number.
    chance: float
    #: Standard error of the simulated number as a prediction, from those of the parameters.
    predicted: float
    held_out: bool

    @property
    def residual(self) -> float:
        """Simulated less measured number."""
        return self.simulated - self.measured

    @property
    def excess(self) -> float:
        """Residual over the largest that errors explain."""
        return (self.residual if self.bound else abs(self.residual)) / self.allowed


@dataclass(frozen=True)
class Calibration:
    """A pair whose k free numbers follow measured rebounds."""

    #: The fitted pair, with the text of its file.
    config: Config
    #: Names of the fitted numbers: paths of the pair file, and ``wall_tilt_deg``.
    labels: tuple[str, ...]
    #: Numbers of the start pair, fitted numbers, and their standard errors, NaN at a bound; (k,).
    given: FloatArray
    values: FloatArray
    errors: FloatArray
    #: Shape (k, k); zero at a bound.
    correlation: FloatArray
    #: Rows that the fit used, then those held out, simulated with random numbers of their own.
    numbers: tuple[FittedNumber, ...]
    #: Root of the weighted sum of squares of the residuals over the degrees of freedom, NaN if
    #: there are none: numbers that the fit used less free parameters.
    scatter: float
    freedom: int
    warnings: tuple[str, ...]
    #: Root mean square of the residuals of the means over their accuracies: of start and fit.
    of_means: tuple[float, float]
    #: Roughness of the wall, fitted or given.
    wall_tilt_deg: float

    def fitted(self, spreads: bool) -> list[FittedNumber]:
        """Collect the means, or the spreads, that the fit used."""
        used = (number for number in self.numbers if not number.held_out)
        return [number for number in used if number.column.endswith(SPREAD) == spreads]

    @property
    def missed(self) -> bool:
        """Whether a mean is farther off than errors explain."""
        return any(number.excess > 1.0 for number in self.fitted(spreads=False))

    def largest(self, held_out: bool = False) -> Mapping[str, FittedNumber]:
        """Find the number with the largest residual of each column."""
        found: dict[str, FittedNumber] = {}
        for number in self.numbers:
            if number.held_out == held_out:
                most = found.setdefault(number.column, number)
                found[number.column] = max(most, number, key=lambda one: abs(one.residual))
        return found

    def to_dict(self) -> dict[str, object]:
        """Give everything as plain data for JSON; None: unknown."""
        names = ("name", "start", "value", "standard_error")
        numbers = (_plain(self.given), _plain(self.values), _plain(self.errors))
        return {
            "pair": self.config.name,
            "parameters": [
                dict(zip(names, parameter, strict=True))
                for parameter in zip(self.labels, *numbers, strict=True)
            ],
            "correlation": [_plain(row) for row in self.correlation],
            "wall_tilt_deg": self.wall_tilt_deg,
            "missed": self.missed,
            "scatter": _plain([self.scatter])[0],
            "degrees_of_freedom": self.freedom,
            "numbers": [asdict(number) | {"residual": number.residual} for number in self.numbers],
            "warnings": list(self.warnings),
            "config": self.config.text,
        }


def _plain(values: Iterable[float]) -> list[float | None]:
    """Make plain numbers; None if not finite."""
    return [float(value) if np.isfinite(value) else None for value in values]
