"""The paper's statements on the directions of rebound (Section 3), checked."""

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from tablegen.config.defaults import MIXTURE
from tablegen.evidence.checked_statement import Checks, Findings
from tablegen.evidence.sample_statistics import (
    SCATTERING_BINS,
    FigureStatistics,
    SampleStatistics,
)

CHECKS = Checks()

#: Smoothing of an indicatrix before maxima are sought, in bins.
_SMOOTHING = 3.0


@CHECKS.statement(
    "Section 3, Figure 13",
    "Reflected particles are scattered considerably at every impact angle.",
    "standard deviation of α₂ of the mixture above 5°",
)
def _scattered_everywhere(statistics: FigureStatistics, source: str) -> Findings:
    curve = statistics.curve(source, MIXTURE)
    if curve:
        least = min(curve, key=lambda sample: sample.scattering_deg)
        text = f"smallest {least.scattering_deg:.1f}° (at {least.alpha_deg:g}°)"
        yield least.scattering_deg > 5.0, text


@CHECKS.statement(
    "Section 3, Figure 13",
    "The scattering is strongest at normal impact.",
    "standard deviation of α₂ of the mixture is largest at 90°",
)
def _scattering_strongest_at_normal(statistics: FigureStatistics, source: str) -> Findings:
    curve = statistics.curve(source, MIXTURE)
    if curve:
        most, last = max(curve, key=lambda sample: sample.scattering_deg), curve[-1]
        yield (
            most is last and last.alpha_deg == 90.0,
            f"largest {most.scattering_deg:.1f}° (at {most.alpha_deg:g}°), "
            f"{last.scattering_deg:.1f}° at {last.alpha_deg:g}°",
        )


def indicatrix_maxima(sample: SampleStatistics) -> list[float]:
    """Angles alpha2 [degrees] of the maxima of the 2D indicatrix.

    A maximum counts if it stands out by a twentieth of the highest.
    """
    density = gaussian_filter1d(sample.scattering.astype(np.float64), _SMOOTHING)
    # at grazing impact the highest bin may be the first
    peaks, _ = find_peaks(np.pad(density, 1), prominence=0.05 * density.max())
    return [float((k - 0.5) * 180.0 / SCATTERING_BINS) for k in peaks]


def _maxima(
    statistics: FigureStatistics, source: str, angles: tuple[float, float], number: int
) -> Findings:
    curve = statistics.curve(source, MIXTURE)
    found = {
        sample.alpha_deg: len(indicatrix_maxima(sample))
        for sample in curve
        if angles[0] <= sample.alpha_deg <= angles[1]
    }
    wrong = [f"{n} at {angle:g}°" for angle, n in found.items() if n != number]
    if found:
        yield not wrong, ", ".join(wrong) or f"{number} at every angle of {len(found)}"


@CHECKS.statement(
    "Section 3, Figure 13",
    "Below 70° the indicatrix of the mixture has one maximum.",
    "one maximum that stands out by a twentieth of the highest, 5° to 65°",
)
def _one_maximum_below_70(statistics: FigureStatistics, source: str) -> Findings:
    return _maxima(statistics, source, (0.0, 69.0), 1)


@CHECKS.statement(
    "Section 3, Figure 13",
    "From 70° on the indicatrix of the mixture has two maxima.",
    "two maxima that stand out by a twentieth of the highest, 70° to 90°",
)
def _two_maxima_from_70(statistics: FigureStatistics, source: str) -> Findings:
    return _maxima(statistics, source, (70.0, 90.0), 2)


@CHECKS.statement(
    "Section 3, Figure 13",
    "Spheres rebound regularly, all at one angle α₂.",
    "range of α₂ over 100 spheres below 10⁻⁹ degrees, every angle",
    direct_only=True,
)
def _spheres_are_regular(statistics: FigureStatistics, source: str) -> Findings:
    widest = max(high - low for low, high in statistics.sphere_deg.values())
    yield widest < 1e-9, f"widest range {widest:.1e} degrees"
