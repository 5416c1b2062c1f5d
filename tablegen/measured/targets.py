"""What a calibration aims at: measured means and spreads, each with the weight of its accuracy."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tablegen.measured.records import QUANTITIES, SPREAD, Measurements
from tablegen.measured.strata import SimulatedMoments
from tablegen.model.float_array import FloatArray

#: Accuracy of a mean whose count of particles is not stated, by quantity; it only weighs rows and
#: quantities against each other, for the errors of the fit follow from its residuals.
STATED_ACCURACY: Mapping[str, float] = {
    "e_n": 0.02,
    "e_t": 0.02,
    "rebound_angle_deg": 1.0,
    "out_of_plane_deg": 1.0,
    "omega_z": 0.02,
}

#: How much larger that of a spread is taken to be. A measured spread also holds those of size,
#: speed and direction before the impact and of the wall, which the pair does not have.
SPREAD_FACTOR = 2.5


@dataclass(frozen=True)
class Targets:
    """m measured numbers.

    Attributes
    ----------
    row : (m,) int64
        Of the measurements.
    quantity : tuple of m str
        Of `tablegen.measured.records.QUANTITIES`.
    spread : (m,) bool
        Whether the number is a standard deviation; a mean otherwise.
    measured : (m,) float64
    accuracy : (m,) float64
        Standard error of the measured number.
    counted : (m,) bool
        Whether that follows from a count of particles, or is `STATED_ACCURACY`.
    """

    row: NDArray[np.int64]
    quantity: tuple[str, ...]
    spread: NDArray[np.bool_]
    measured: FloatArray
    accuracy: FloatArray
    counted: NDArray[np.bool_]

    @property
    def columns(self) -> tuple[str, ...]:
        """Name of the column of each number."""
        pairs = zip(self.quantity, self.spread, strict=True)
        return tuple(name + SPREAD if spread else name for name, spread in pairs)

    def pick(self, simulated: SimulatedMoments) -> tuple[FloatArray, FloatArray]:
        """Pick simulated numbers (m,) and their chance errors (m,), in this order."""
        both = (
            (simulated.mean, simulated.std),
            (simulated.mean_error, simulated.std_error),
        )
        rows = list(zip(self.quantity, self.spread, self.row, strict=True))
        values, errors = (
            np.array([maps[int(spread)][name][row] for name, spread, row in rows]) for maps in both
        )
        return values, errors


def make_targets(measurements: Measurements, simulated: SimulatedMoments | None) -> Targets:
    """All means and spreads of some measurements, row by row.

    With a count n a mean is accurate to s / sqrt(n), with s the measured spread or, where that is
    missing, the simulated one; and a spread to s / sqrt(2 (n - 1)), as for a normal law. Only the
    weights rest on these: standard errors of parameters follow from the simulated law
    (`tablegen.measured.uncertainty`).

    Parameters
    ----------
    measurements : Measurements
    simulated : SimulatedMoments or None
        Of the same rows; None if there are none.

    Returns
    -------
    Targets
        The out-of-plane angle has a spread only: its mean is zero by symmetry.
    """
    rows: list[tuple[int, str, bool, float, float, bool]] = []
    for row, count in enumerate(measurements.count):
        counted = bool(count > 1.0)
        for name in QUANTITIES:
            moments = measurements.moments[name]
            mean, std = float(moments.mean[row]), float(moments.std[row])
            size = std if std > 0.0 or simulated is None else float(simulated.std[name][row])
            stated = STATED_ACCURACY[name]
            if np.isfinite(mean) and name != "out_of_plane_deg":
                accuracy = size / np.sqrt(count) if counted else stated
                rows.append((row, name, False, mean, accuracy, counted))
            if np.isfinite(std):
                accuracy = SPREAD_FACTOR * stated
                if counted:
                    accuracy = size / np.sqrt(2.0 * (count - 1.0))
                rows.append((row, name, True, std, accuracy, counted))
    columns = list(zip(*rows, strict=True)) if rows else [()] * 6
    return Targets(
        row=np.array(columns[0], dtype=np.int64),
        quantity=tuple(columns[1]),
        spread=np.array(columns[2], dtype=np.bool_),
        measured=np.array(columns[3], dtype=np.float64),
        accuracy=np.array(columns[4], dtype=np.float64),
        counted=np.array(columns[5], dtype=np.bool_),
    )
