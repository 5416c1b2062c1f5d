"""What a calibration finds, as records."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np

from tablegen.config.config import Config
from tablegen.measured.records import SPREAD
from tablegen.model.float_array import FloatArray


@dataclass(frozen=True)
class FittedNumber:
    """A measured mean or spread beside the simulated one."""

    #: Of the measurements, from 0.
    row: int
    alpha_deg: float
    #: m/s; None where it is not stated.
    speed: float | None
    #: Name of the column: a quantity, or its spread.
    column: str
    measured: float
    #: Standard error of the measured number: from its count, or the one that is assumed.
    accuracy: float
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


@dataclass(frozen=True)
class Calibration:
    """A pair whose free parameters follow measured rebounds.

    Attributes
    ----------
    config : Config
        The fitted pair; its text is the file.
    labels : tuple of k str
        Of the fitted numbers: paths of the pair file, and ``wall_tilt_deg``.
    given, values, errors : (k,) float64
        Of the start pair, fitted, and their standard errors; NaN for those at a bound.
    correlation : (k, k) float64
        Zero for those at a bound.
    numbers : tuple of FittedNumber
        Rows that the fit used, then those held out. Simulated with random numbers that the fit
        did not see.
    scatter : float
        Root of the weighted sum of squares of the residuals over the degrees of freedom; NaN where
        there are none.
    freedom : int
        Degrees of freedom: numbers that the fit used less free parameters.
    warnings : tuple of str
    wall_tilt_deg : float
        Roughness of the wall, fitted or given.
    """

    config: Config
    labels: tuple[str, ...]
    given: FloatArray
    values: FloatArray
    errors: FloatArray
    correlation: FloatArray
    numbers: tuple[FittedNumber, ...]
    scatter: float
    freedom: int
    warnings: tuple[str, ...]
    wall_tilt_deg: float

    def largest(self, held_out: bool = False) -> Mapping[str, FittedNumber]:
        """Give the number with the largest residual of each column."""
        found: dict[str, FittedNumber] = {}
        for number in self.numbers:
            before = found.get(number.column)
            if number.held_out == held_out and (
                before is None or abs(number.residual) > abs(before.residual)
            ):
                found[number.column] = number
        return found

    def explained(self) -> Mapping[str, tuple[FittedNumber, FittedNumber]]:
        """Give, of each column of spreads, the least and the most simulated part of a spread."""
        found = {}
        for column in dict.fromkeys(n.column for n in self.numbers if n.column.endswith(SPREAD)):
            rows = [n for n in self.numbers if n.column == column and n.measured > 0.0]
            rows.sort(key=lambda number: number.simulated / number.measured)
            if rows:
                found[column] = rows[0], rows[-1]
        return found

    def to_dict(self) -> dict[str, object]:
        """Everything as plain data, for JSON; None stands for what is not known."""
        parameters = [
            {"name": name, "start": start, "value": value, "standard_error": error}
            for name, start, value, error in zip(
                self.labels,
                _plain(self.given),
                _plain(self.values),
                _plain(self.errors),
                strict=True,
            )
        ]
        return {
            "pair": self.config.name,
            "parameters": parameters,
            "correlation": [_plain(row) for row in self.correlation],
            "wall_tilt_deg": self.wall_tilt_deg,
            "scatter": _plain(np.array([self.scatter]))[0],
            "degrees_of_freedom": self.freedom,
            "numbers": [asdict(number) | {"residual": number.residual} for number in self.numbers],
            "warnings": list(self.warnings),
            "config": self.config.text,
        }


def _plain(values: FloatArray) -> list[float | None]:
    """Numbers for JSON."""
    return [float(value) if np.isfinite(value) else None for value in values]
