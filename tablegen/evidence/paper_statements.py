"""Statements of the paper that can be checked, with their criteria and checks.

A check looks at parts of the statistics of one source, such as each curve. A statement holds if
all parts agree. Without a part the source cannot tell: a table holds the mixture only, without
collisions and rotational energies.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from tablegen.config.config import Config, load_config
from tablegen.config.defaults import MIXTURE
from tablegen.evidence.paper_statistics import (
    DENSITY,
    DIRECT,
    SCATTERING_BINS,
    TABLE,
    FigureStatistics,
    SampleStatistics,
)
from tablegen.model.float_array import FloatArray

#: Statements that are not checked, with the reason.
NOT_CHECKED = (
    "A mixture agrees better with the measured velocities than one shape does, and the agreement "
    "is good (Figures 3 and 4): the measured values are in the figures only, not in the text.",
    "No rebound depends on the size of the particle: it holds by construction here, velocities "
    "being in V and angular velocities in V/a.",
)

#: Largest `asymmetry` that counts as symmetric.
_SYMMETRIC = 5.0

#: Smoothing of densities before maxima are sought, in bins.
_SMOOTHING = 3.0

#: Samples of one shape by rising angle, or of all shapes.
_Samples = Sequence[SampleStatistics]

#: Parts of the statistics of a source, and a check: whether a part agrees, and what was measured.
_Parts = Callable[[FigureStatistics, str], Sequence[Any]]
_Check = Callable[[Any], tuple[bool, str]]


@dataclass(frozen=True)
class Verdict:
    """Whether a statement holds (None: it is not about this pair), and what was measured."""

    holds: bool | None
    measured: str


@dataclass(frozen=True)
class Statement:
    """A statement of the paper in our words, and the verdicts; None where a source cannot tell."""

    place: str
    text: str
    criterion: str
    direct: Verdict | None = None
    table: Verdict | None = None


#: Statements in the order of the paper with their parts and checks, by the name of the check.
CHECKS: dict[str, tuple[Statement, _Parts, _Check]] = {}


def is_of_the_paper(config: Config) -> bool:
    """Whether laws and particles are those of the paper, whatever their names."""

    def physics(of: Config) -> tuple[object, ...]:
        restitution = of.pair.restitution.model_dump(exclude={"source", "valid_speed"})
        resistance = of.pair.resistance.model_dump(exclude={"source"})
        return restitution, resistance, of.population.model_dump()

    return physics(config) == physics(load_config("corundum-steel"))


def check_statements(statistics: FigureStatistics) -> list[Statement]:
    """Check every statement against direct simulation and the table.

    For another pair or other particles than the paper's, statements are measured and not judged.
    """
    judged = is_of_the_paper(statistics.config)

    def checked(name: str, source: str) -> Verdict | None:
        found = verdict(name, statistics, source)
        return found if found is None or judged else replace(found, holds=None)

    return [
        replace(statement, direct=checked(name, DIRECT), table=checked(name, TABLE))
        for name, (statement, *_) in CHECKS.items()
    ]


def verdict(name: str, statistics: FigureStatistics, source: str) -> Verdict | None:
    """Judge one of `CHECKS` on one source; None where the source cannot tell."""
    _, parts, check = CHECKS[name]
    found = [check(part) for part in parts(statistics, source)]
    text = "; ".join(words for _, words in found)
    return Verdict(all(bool(agrees) for agrees, _ in found), text) if found else None


def _statement(place: str, text: str, criterion: str, parts: _Parts) -> Callable[[_Check], _Check]:
    """Register the check that follows."""

    def register(check: _Check) -> _Check:
        CHECKS[check.__name__.lstrip("_")] = Statement(place, text, criterion), parts, check
        return check

    return register


def _curves(statistics: FigureStatistics, source: str) -> list[_Samples]:
    return [statistics.curve(source, shape) for shape in statistics.shapes(source)]


def _whole(statistics: FigureStatistics, source: str) -> list[_Samples]:
    every = [sample for curve in _curves(statistics, source) for sample in curve]
    return [every] if every else []


def _normal(statistics: FigureStatistics, source: str) -> _Samples:
    return [curve[-1] for curve in _curves(statistics, source) if curve[-1].alpha_deg == 90.0]


def _mixture(statistics: FigureStatistics, source: str) -> list[_Samples]:
    curve = statistics.curve(source, MIXTURE)
    return [curve] if curve else []


def _simulated(parts: _Parts) -> _Parts:
    """Parts of direct simulation only."""
    return lambda statistics, source: parts(statistics, source) if source == DIRECT else []


def _where(sample: SampleStatistics) -> str:
    return f"{sample.shape}, {sample.alpha_deg:g}°"


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def _gaps(samples: _Samples, names: Sequence[str], errors: float) -> tuple[bool, str]:
    """Compare the differences of mean and most probable value with 0.01 and some errors."""
    texts, small = [], 0
    for name in names:
        having = [sample for sample in samples if name in sample.mean]
        gaps = [abs(sample.mean[name] - sample.mode[name]) for sample in having]
        for gap, sample in zip(gaps, having, strict=True):
            small += gap < max(0.01, errors * sample.error[name])
        if gaps:
            k = int(np.argmin(gaps))
            texts.append(f"{name}: smallest difference {gaps[k]:.4f} ({_where(having[k])})")
    return not small, ", ".join(texts) + (f", too small in {small} cases" if small else "")


@_statement(
    "Section 2, Figures 3 and 4",
    "The mean and the most probable value of u⁺ and of v⁺ differ much at all impact angles.",
    "the two differ by more than 0.01 V and by 5 standard errors, every shape and angle",
    _whole,
)
def _means_differ_from_modes(samples: _Samples) -> tuple[bool, str]:
    return _gaps(samples, ("u", "v"), 5.0)


def _peak_of_u(sample: SampleStatistics) -> tuple[float, float]:
    """Position of the maximum of the density of |u|, and the density at zero over it.

    A maximum that exceeds the density at zero by less than four standard errors is at zero.
    """
    low, high, bins = DENSITY["u"]
    counts = sample.density["u"].astype(np.float64)
    zero = round(-low / (high - low) * bins)
    width = min(zero, bins - zero)
    folded = counts[zero : zero + width] + counts[zero - width : zero][::-1]
    density: FloatArray = gaussian_filter1d(folded, _SMOOTHING, mode="reflect")
    top = int(density.argmax())
    # a Gaussian averages 2 sqrt(pi) times its width in bins; at the edge, half of that
    averaged = 2.0 * np.sqrt(np.pi) * _SMOOTHING
    noise = np.sqrt(density[top] / averaged + density[0] / (0.5 * averaged))
    if density[top] - density[0] < 4.0 * noise:
        top = 0
    position = 0.0 if top == 0 else (top + 0.5) * (high - low) / bins
    return position, float(density[0] / density[top])


@_statement(
    "Section 2, Figure 3",
    "At normal impact the most probable u⁺ is zero for every shape but the prism.",
    "the peak of the density of |u⁺| is at zero",
    lambda *of: [sample for sample in _normal(*of) if sample.shape != "prism"],
)
def _tangential_mode_is_zero(sample: SampleStatistics) -> tuple[bool, str]:
    peak, _ = _peak_of_u(sample)
    return peak == 0.0, f"{sample.shape} {peak:.2f}"


@_statement(
    "Section 2, Figure 5",
    "For prisms at normal impact the density of u⁺ has two equal maxima on both sides of a "
    "minimum at zero.",
    "the density at zero is below 97 % of the maximum, and u⁺ is symmetric",
    lambda *of: [sample for sample in _normal(*of) if sample.shape == "prism"],
)
def _prisms_have_two_maxima(sample: SampleStatistics) -> tuple[bool, str]:
    (position, ratio), skew = _peak_of_u(sample), sample.asymmetry["u"]
    text = f"maxima at ±{position:.2f}, density at zero {_percent(ratio)} of them"
    holds = position > 0.0 and ratio < 0.97 and skew <= _SYMMETRIC
    return holds, f"{text}, asymmetry {skew:.1f}"


@_statement(
    "Section 2, table",
    "At normal impact fewer than half of the particles of any shape collide only once.",
    "share of single collisions below 50 %",
    _simulated(_normal),
)
def _singles_below_half(sample: SampleStatistics) -> tuple[bool, str]:
    return sample.singles < 0.5, f"{sample.shape} {_percent(sample.singles)}"


@_statement(
    "Section 2, table",
    "At normal impact the particles of all shapes but ellipsoids mostly collide twice or more "
    "often.",
    "share of repeated collisions above that of single ones, ellipsoids left out",
    _simulated(lambda *of: [s for s in _normal(*of) if s.shape not in ("ellipsoid", MIXTURE)]),
)
def _repeated_prevail(sample: SampleStatistics) -> tuple[bool, str]:
    share = 1.0 - sample.singles
    return share > 0.5, f"{sample.shape} {_percent(share)}"


@_statement(
    "Section 2",
    "With falling impact angle the share of single collisions changes, for every shape, not "
    "monotonically.",
    "the share both rises and falls, by 4 standard errors",
    _simulated(_curves),
)
def _singles_not_monotonic(curve: _Samples) -> tuple[bool, str]:
    shares = np.array([sample.singles for sample in curve])
    noise = 4.0 * np.sqrt(0.5 / curve[0].count)
    # the extreme that is farther away from both ends
    away = np.minimum(abs(shares - shares[0]), abs(shares - shares[-1]))
    k = max((int(shares.argmax()), int(shares.argmin())), key=lambda end: float(away[end]))
    turns = bool(away[k] > noise)
    middle = f"{_percent(shares[k])} at {curve[k].alpha_deg:g}°" if turns else "monotonic"
    first = f"{curve[0].shape} {_percent(shares[0])} at {curve[0].alpha_deg:g}°"
    return turns, f"{first}, {middle}, {_percent(shares[-1])} at 90°"


@_statement(
    "Section 2",
    "At every angle and for every shape 25 to 70 % of the particles collide twice or more often.",
    "smallest and largest share within 25 to 70 %",
    _simulated(_whole),
)
def _repeated_within_range(samples: _Samples) -> tuple[bool, str]:
    every = sorted((s for s in samples if s.shape != MIXTURE), key=lambda s: -s.singles)
    low, high = 1.0 - every[0].singles, 1.0 - every[-1].singles
    text = f"from {_percent(low)} ({_where(every[0])}) to {_percent(high)} ({_where(every[-1])})"
    return low >= 0.25 and high <= 0.70, text


@_statement(
    "Section 2, Figure 7",
    "The mean and the most probable Ωz are not positive, for every shape and angle.",
    "at most 5 standard errors (mean) and 0.02 V/a (most probable) above zero",
    _whole,
)
def _spin_not_positive(samples: _Samples) -> tuple[bool, str]:
    heights = [sample.mean["omega_z"] / sample.error["omega_z"] for sample in samples]
    height, sample = max(heights), samples[int(np.argmax(heights))]
    text = f"largest mean {sample.mean['omega_z']:+.4f} V/a, {height:+.1f} standard errors"
    other = max(samples, key=lambda sample: sample.mode["omega_z"])
    mode = other.mode["omega_z"]
    text += f" ({_where(sample)}), largest most probable {mode:+.4f} V/a ({_where(other)})"
    return height <= 5.0 and mode <= 0.02, text


@_statement(
    "Section 2",
    "The share of particles with Ωz > 0 grows with the impact angle.",
    "no step down by more than 4 standard errors",
    _curves,
)
def _positive_spin_grows(curve: _Samples) -> tuple[bool, str]:
    shares, count = np.array([sample.positive_spin for sample in curve]), curve[0].count
    # one more count keeps the error of an empty pair above zero
    steps = np.diff(shares) / np.sqrt((shares[1:] + shares[:-1]) / count + 1.0 / count**2)
    down = int(steps.argmin())
    grows = bool(steps[down] > -4.0)
    text = f"{curve[0].shape} {_percent(shares[0])} to {_percent(shares[-1])}"
    return grows, text + ("" if grows else f", falls to {curve[down + 1].alpha_deg:g}°")


@_statement(
    "Section 2, Figure 8",
    "At normal impact the density of Ωz is symmetric about zero.",
    "asymmetry at most 5 (chance: 1 in 900,000)",
    _normal,
)
def _normal_spin_is_symmetric(sample: SampleStatistics) -> tuple[bool, str]:
    skew = sample.asymmetry["omega_z"]
    return skew <= _SYMMETRIC, f"{sample.shape} {skew:.1f}"


@_statement(
    "Section 2",
    "The densities of Ωx and Ωy are symmetric about zero at every angle.",
    "asymmetry at most 5 (chance: 1 in 900,000 each), every shape and angle; a tetrahedron of "
    "unequal half-sizes is chiral",
    _curves,
)
def _transverse_spin_is_symmetric(curve: _Samples) -> tuple[bool, str]:
    skews = [max(s.asymmetry["omega_x"], s.asymmetry["omega_y"]) for s in curve]
    worst = int(np.argmax(skews))
    text = f"{curve[worst].shape} {skews[worst]:.1f} ({curve[worst].alpha_deg:g}°)"
    return skews[worst] <= _SYMMETRIC, text


@_statement(
    "Section 2, Figure 9",
    "Particles lose much kinetic energy in the rebound.",
    "mean loss of kinetic energy, translational and rotational, above 5 % at every angle",
    _simulated(_whole),
)
def _energy_is_lost(samples: _Samples) -> tuple[bool, str]:
    losses = [1.0 - sample.mean["translational"] - sample.mean["rotational"] for sample in samples]
    k = int(np.argmin(losses))
    return losses[k] > 0.05, f"smallest mean loss {_percent(losses[k])} ({_where(samples[k])})"


@_statement(
    "Section 2, Figure 9",
    "The mean translational energy falls monotonically with rising impact angle.",
    "falls at every step of 5°",
    _curves,
)
def _translational_falls(curve: _Samples) -> tuple[bool, str]:
    means = np.array([sample.mean["translational"] for sample in curve])
    steps = np.diff(means)
    text = f"{curve[0].shape} {means[0]:.3f} to {means[-1]:.3f}, least step {steps.max():+.4f}"
    return bool(np.all(steps < 0.0)), text


def _peak_of_rotational(curve: _Samples) -> tuple[float, float]:
    """Angle and height of the highest mean rotational energy, the angle by a parabola."""
    means = np.array([sample.mean["rotational"] for sample in curve])
    top = int(means.argmax())
    if not 0 < top < len(means) - 1:
        return curve[top].alpha_deg, float(means[top])
    left, middle, right = means[top - 1 : top + 2]
    offset = 0.5 * (left - right) / (left - 2.0 * middle + right)
    step = curve[top + 1].alpha_deg - curve[top].alpha_deg
    return curve[top].alpha_deg + offset * step, float(middle)


@_statement(
    "Section 2, Figure 9",
    "The mean rotational energy has its maximum at 15 to 20°, for every shape and the mixture.",
    "maximum of a parabola through the highest point and its neighbours within 15 to 20°",
    _simulated(_curves),
)
def _rotational_peak(curve: _Samples) -> tuple[bool, str]:
    angle, _ = _peak_of_rotational(curve)
    return 15.0 <= angle <= 20.0, f"{curve[0].shape} {angle:.1f}°"


@_statement(
    "Section 2, Figure 9",
    "Ellipsoids and truncated prisms have the greatest rotational energy.",
    "their maxima are above those of prisms and tetrahedra",
    _simulated(lambda *of: [_curves(*of)]),
)
def _greatest_rotational(curves: list[_Samples]) -> tuple[bool, str]:
    heights = {c[0].shape: _peak_of_rotational(c)[1] for c in curves if c[0].shape != MIXTURE}
    order = sorted(heights, key=heights.__getitem__, reverse=True)
    text = ", ".join(f"{shape} {heights[shape]:.3f}" for shape in order)
    return set(order[:2]) == {"ellipsoid", "truncated-prism"}, f"maxima: {text}"


@_statement(
    "Section 2, Figure 10",
    "The most probable energies differ much from the mean ones.",
    "translational and rotational differ by more than 0.01 of the energy before, every shape "
    "and angle",
    _whole,
)
def _energies_differ(samples: _Samples) -> tuple[bool, str]:
    return _gaps(samples, ("translational", "rotational"), 0.0)


@_statement(
    "Section 3, Figure 13",
    "Reflected particles are scattered considerably at every impact angle.",
    "standard deviation of α₂ of the mixture above 5°",
    _mixture,
)
def _scattered_everywhere(curve: _Samples) -> tuple[bool, str]:
    least = min(curve, key=lambda sample: sample.scattering_deg)
    text = f"smallest {least.scattering_deg:.1f}° (at {least.alpha_deg:g}°)"
    return least.scattering_deg > 5.0, text


@_statement(
    "Section 3, Figure 13",
    "The scattering is strongest at normal impact.",
    "standard deviation of α₂ of the mixture is largest at 90°",
    _mixture,
)
def _scattering_strongest_at_normal(curve: _Samples) -> tuple[bool, str]:
    most, last = max(curve, key=lambda sample: sample.scattering_deg), curve[-1]
    text = f"largest {most.scattering_deg:.1f}° (at {most.alpha_deg:g}°)"
    at_last = f"{last.scattering_deg:.1f}° at {last.alpha_deg:g}°"
    return most is last and last.alpha_deg == 90.0, f"{text}, {at_last}"


def indicatrix_maxima(sample: SampleStatistics) -> list[float]:
    """Angles alpha2 [degrees] of the maxima of the 2D indicatrix.

    A maximum counts if it stands out by a twentieth of the highest.
    """
    density = gaussian_filter1d(sample.scattering.astype(np.float64), _SMOOTHING)
    # at grazing impact the highest bin may be the first
    peaks, _ = find_peaks(np.pad(density, 1), prominence=0.05 * density.max())
    return [float((k - 0.5) * 180.0 / SCATTERING_BINS) for k in peaks]


@_statement(
    "Section 3, Figure 13",
    "Below 70° the indicatrix of the mixture has one maximum.",
    "one maximum that stands out by a twentieth of the highest, 5° to 65°",
    lambda *of: [sample for curve in _mixture(*of) for sample in curve if sample.alpha_deg < 69],
)
def _one_maximum_below_70(sample: SampleStatistics) -> tuple[bool, str]:
    maxima = len(indicatrix_maxima(sample))
    return maxima == 1, f"{maxima} at {sample.alpha_deg:g}°"


@_statement(
    "Section 3, Figure 13",
    "From 70° on the indicatrix of the mixture has two maxima.",
    "two maxima that stand out by a twentieth of the highest, 70° to 90°",
    lambda *of: [sample for curve in _mixture(*of) for sample in curve if sample.alpha_deg > 69],
)
def _two_maxima_from_70(sample: SampleStatistics) -> tuple[bool, str]:
    maxima = len(indicatrix_maxima(sample))
    return maxima == 2, f"{maxima} at {sample.alpha_deg:g}°"


@_statement(
    "Section 3, Figure 13",
    "Spheres rebound regularly, all at one angle α₂.",
    "range of α₂ over 100 spheres below 10⁻⁹ degrees, every angle",
    _simulated(lambda statistics, _: [statistics.sphere_deg]),
)
def _spheres_are_regular(sphere_deg: dict[float, tuple[float, float]]) -> tuple[bool, str]:
    widest = max(high - low for low, high in sphere_deg.values())
    return widest < 1e-9, f"widest range {widest:.1e} degrees"
