"""Checks of the paper's statements: each gives a verdict with the figure measured.

A check takes all laws and a source, and answers None where that source cannot tell: a table holds
the mixture, without collisions and rotational energies.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from tablegen.configuration.defaults import MIXTURE
from tablegen.model.float_array import FloatArray
from tablegen.studies.paper_figures.sample_statistics import (
    DENSITY,
    DIRECT,
    SCATTERING_BINS,
    FigureStatistics,
    SampleStatistics,
)

#: Largest asymmetry that counts as symmetric; see
#: `tablegen.studies.paper_figures.sample_statistics.asymmetry`.
_SYMMETRIC = 5.0

#: Smoothing of densities before maxima are sought, in bins.
_SMOOTHING = 3.0


@dataclass(frozen=True)
class Verdict:
    """Whether a statement holds (None: it is not about this pair), and what was measured."""

    holds: bool | None
    measured: str


def _where(law: SampleStatistics) -> str:
    return f"{law.shape}, {law.alpha_deg:g}°"


def _all(laws: FigureStatistics, source: str) -> list[SampleStatistics]:
    return [law for shape in laws.shapes(source) for law in laws.curve(source, shape)]


def _normal(laws: FigureStatistics, source: str) -> list[SampleStatistics]:
    found = (laws.at(source, shape, 90.0) for shape in laws.shapes(source))
    return [law for law in found if law is not None]


def _worst(
    laws: Iterable[SampleStatistics], value: Callable[[SampleStatistics], float]
) -> tuple[float, str]:
    """Smallest value and where it is."""
    law = min(laws, key=value)
    return value(law), _where(law)


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def means_differ_from_modes(laws: FigureStatistics, source: str) -> Verdict | None:
    """Mean against most probable value of u and v."""
    every, holds, parts = _all(laws, source), True, []
    if not every:
        return None
    for name in ("u", "v"):

        def gap(law: SampleStatistics, name: str = name) -> float:
            return abs(law.mean[name] - law.mode[name])

        least, where = _worst(every, gap)
        same = [law for law in every if gap(law) < max(0.01, 5.0 * law.error[name])]
        holds &= not same
        parts.append(f"{name}⁺: smallest difference {least:.4f} V ({where})")
        if same:
            parts[-1] += f", too small in {len(same)} of {len(every)} cases"
    return Verdict(holds, "; ".join(parts))


def _folded_density(law: SampleStatistics) -> FloatArray:
    """Smoothed density of |u|, from zero on."""
    low, high, bins = DENSITY["u"]
    counts = law.density["u"].astype(np.float64)
    zero = round(-low / (high - low) * bins)
    width = min(zero, bins - zero)
    both = counts[zero : zero + width] + counts[zero - width : zero][::-1]
    return np.asarray(gaussian_filter1d(both, _SMOOTHING, mode="reflect"))


def _peak_of_u(law: SampleStatistics) -> tuple[float, float]:
    """Position of the maximum of the density of |u|, and the density at zero over it.

    A maximum that exceeds the density at zero by less than four standard errors is at zero.
    """
    low, high, bins = DENSITY["u"]
    density = _folded_density(law)
    top = int(density.argmax())
    # a Gaussian averages 2 sqrt(pi) times its width in bins; at the edge, half as many
    averaged = 2.0 * np.sqrt(np.pi) * _SMOOTHING
    noise = np.sqrt(density[top] / averaged + density[0] / (0.5 * averaged))
    if density[top] - density[0] < 4.0 * noise:
        top = 0
    position = 0.0 if top == 0 else (top + 0.5) * (high - low) / bins
    return position, float(density[0] / density[top])


def tangential_mode_is_zero(laws: FigureStatistics, source: str) -> Verdict | None:
    """Most probable u at normal impact, prisms left out."""
    chosen = [law for law in _normal(laws, source) if law.shape != "prism"]
    if not chosen:
        return None
    peaks = {law.shape: _peak_of_u(law)[0] for law in chosen}
    text = ", ".join(f"{shape} {peak:.2f}" for shape, peak in peaks.items())
    return Verdict(not any(peaks.values()), f"peak of |u⁺| at: {text}")


def prisms_have_two_maxima(laws: FigureStatistics, source: str) -> Verdict | None:
    """Density of u of prisms at normal impact."""
    law = laws.at(source, "prism", 90.0)
    if law is None:
        return None
    position, ratio = _peak_of_u(law)
    skew = law.asymmetry["u"]
    text = (
        f"maxima at ±{position:.2f}, density at zero {_percent(ratio)} of them, "
        f"asymmetry {skew:.1f}"
    )
    return Verdict(position > 0.0 and ratio < 0.97 and skew <= _SYMMETRIC, text)


def _singles(law: SampleStatistics) -> float:
    assert law.collisions is not None
    return law.collisions[0]


def singles_below_half(laws: FigureStatistics, source: str) -> Verdict | None:
    """Share of single collisions at normal impact."""
    if source != DIRECT:
        return None
    shares = {law.shape: _singles(law) for law in _normal(laws, source)}
    text = ", ".join(f"{shape} {_percent(share)}" for shape, share in shares.items())
    return Verdict(max(shares.values()) < 0.5, text)


def repeated_prevail(laws: FigureStatistics, source: str) -> Verdict | None:
    """Share of repeated collisions at normal impact, ellipsoids left out."""
    if source != DIRECT:
        return None
    chosen = [law for law in _normal(laws, source) if law.shape not in ("ellipsoid", MIXTURE)]
    shares = {law.shape: 1.0 - _singles(law) for law in chosen}
    text = ", ".join(f"{shape} {_percent(share)}" for shape, share in shares.items())
    return Verdict(min(shares.values()) > 0.5, text)


def singles_not_monotonic(laws: FigureStatistics, source: str) -> Verdict | None:
    """Share of single collisions over the angle."""
    if source != DIRECT:
        return None
    holds, parts = True, []
    for shape in laws.shapes(source):
        curve = laws.curve(source, shape)
        shares = np.array([_singles(law) for law in curve])
        noise = 4.0 * np.sqrt(0.5 / curve[0].count)
        top = int(shares.argmax())
        # rises to its maximum and falls from it, or falls to its minimum and rises from it
        low = int(shares.argmin())
        inner = [k for k in (top, low) if 0 < k < len(shares) - 1]
        turns = any(
            min(abs(shares[k] - shares[0]), abs(shares[k] - shares[-1])) > noise for k in inner
        )
        holds &= turns
        parts.append(
            f"{shape} {_percent(shares[0])} at {curve[0].alpha_deg:g}°, "
            + (
                f"{_percent(shares[inner[0]])} at {curve[inner[0]].alpha_deg:g}°, "
                if turns
                else "monotonic, "
            )
            + f"{_percent(shares[-1])} at 90°"
        )
    return Verdict(holds, "; ".join(parts))


def repeated_within_range(laws: FigureStatistics, source: str) -> Verdict | None:
    """Share of repeated collisions at all angles."""
    if source != DIRECT:
        return None
    every = [law for law in _all(laws, source) if law.shape != MIXTURE]
    least, most = (pick(every, key=lambda law: 1.0 - _singles(law)) for pick in (min, max))
    low, high = 1.0 - _singles(least), 1.0 - _singles(most)
    text = f"from {_percent(low)} ({_where(least)}) to {_percent(high)} ({_where(most)})"
    return Verdict(low >= 0.25 and high <= 0.70, text)


def spin_not_positive(laws: FigureStatistics, source: str) -> Verdict | None:
    """Sign of the mean and the most probable spin."""
    every = _all(laws, source)
    if not every:
        return None
    mean = max(every, key=lambda law: law.mean["omega_z"] / law.error["omega_z"])
    mode = max(every, key=lambda law: law.mode["omega_z"])
    height = mean.mean["omega_z"] / mean.error["omega_z"]
    text = (
        f"largest mean {mean.mean['omega_z']:+.4f} V/a, {height:+.1f} standard errors "
        f"({_where(mean)}); largest most probable {mode.mode['omega_z']:+.4f} V/a ({_where(mode)})"
    )
    return Verdict(height <= 5.0 and mode.mode["omega_z"] <= 0.02, text)


def positive_spin_grows(laws: FigureStatistics, source: str) -> Verdict | None:
    """Share of positive spins over the angle."""
    holds, parts = True, []
    for shape in laws.shapes(source):
        curve = laws.curve(source, shape)
        shares = np.array([law.positive_spin for law in curve])
        # one more count keeps the error of an empty pair above zero
        errors = np.sqrt((shares[1:] + shares[:-1]) / curve[0].count + 1.0 / curve[0].count ** 2)
        steps = np.diff(shares) / errors
        down = int(steps.argmin())
        holds &= bool(steps[down] > -4.0)
        parts.append(
            f"{shape} {_percent(shares[0])} to {_percent(shares[-1])}"
            + (f", falls to {curve[down + 1].alpha_deg:g}°" if steps[down] <= -4.0 else "")
        )
    return Verdict(holds, "; ".join(parts)) if parts else None


def normal_spin_is_symmetric(laws: FigureStatistics, source: str) -> Verdict | None:
    """Symmetry of the spin at normal impact."""
    skews = {law.shape: law.asymmetry["omega_z"] for law in _normal(laws, source)}
    if not skews:
        return None
    text = ", ".join(f"{shape} {skew:.1f}" for shape, skew in skews.items())
    return Verdict(max(skews.values()) <= _SYMMETRIC, f"asymmetry: {text}")


def transverse_spin_is_symmetric(laws: FigureStatistics, source: str) -> Verdict | None:
    """Symmetry of the other spins at all angles."""
    parts, holds = [], True
    for shape in laws.shapes(source):
        curve = laws.curve(source, shape)
        worst = max(curve, key=lambda law: max(law.asymmetry["omega_x"], law.asymmetry["omega_y"]))
        value = max(worst.asymmetry["omega_x"], worst.asymmetry["omega_y"])
        holds &= value <= _SYMMETRIC
        parts.append(f"{shape} {value:.1f} ({worst.alpha_deg:g}°)")
    if not parts:
        return None
    text = f"largest asymmetry: {'; '.join(parts)}"
    return Verdict(
        holds, text if holds else f"{text}; a tetrahedron of unequal half-sizes is chiral"
    )


def energy_is_lost(laws: FigureStatistics, source: str) -> Verdict | None:
    """Mean loss of kinetic energy."""
    if source != DIRECT:
        return None
    every = _all(laws, source)
    least, where = _worst(
        every, lambda law: 1.0 - law.mean["translational"] - law.mean["rotational"]
    )
    return Verdict(least > 0.05, f"smallest mean loss {_percent(least)} ({where})")


def translational_falls(laws: FigureStatistics, source: str) -> Verdict | None:
    """Mean translational energy over the angle."""
    holds, parts = True, []
    for shape in laws.shapes(source):
        means = np.array([law.mean["translational"] for law in laws.curve(source, shape)])
        steps = np.diff(means)
        holds &= bool(np.all(steps < 0.0))
        parts.append(f"{shape} {means[0]:.3f} to {means[-1]:.3f}, least step {steps.max():+.4f}")
    return Verdict(holds, "; ".join(parts)) if parts else None


def _rotational_peak(curve: list[SampleStatistics]) -> tuple[float, float]:
    """Angle and height of the highest mean rotational energy."""
    means = np.array([law.mean["rotational"] for law in curve])
    top = int(means.argmax())
    if not 0 < top < len(means) - 1:
        return curve[top].alpha_deg, float(means[top])
    left, middle, right = means[top - 1 : top + 2]
    offset = 0.5 * (left - right) / (left - 2.0 * middle + right)
    step = curve[top + 1].alpha_deg - curve[top].alpha_deg
    return curve[top].alpha_deg + offset * step, float(middle)


def rotational_peak(laws: FigureStatistics, source: str) -> Verdict | None:
    """Angle of the highest mean rotational energy."""
    if source != DIRECT:
        return None
    peaks = {shape: _rotational_peak(laws.curve(source, shape))[0] for shape in laws.shapes(source)}
    text = ", ".join(f"{shape} {angle:.1f}°" for shape, angle in peaks.items())
    return Verdict(all(15.0 <= angle <= 20.0 for angle in peaks.values()), f"maximum at: {text}")


def greatest_rotational(laws: FigureStatistics, source: str) -> Verdict | None:
    """Order of the highest mean rotational energies."""
    if source != DIRECT:
        return None
    heights = {
        shape: _rotational_peak(laws.curve(source, shape))[1]
        for shape in laws.shapes(source)
        if shape != MIXTURE
    }
    order = sorted(heights, key=heights.__getitem__, reverse=True)
    text = ", ".join(f"{shape} {heights[shape]:.3f}" for shape in order)
    return Verdict(set(order[:2]) == {"ellipsoid", "truncated-prism"}, f"maxima: {text}")


def energies_differ(laws: FigureStatistics, source: str) -> Verdict | None:
    """Mean against most probable energies."""
    every = _all(laws, source)
    if not every:
        return None
    names = [name for name in ("translational", "rotational") if name in every[0].mean]
    parts, holds = [], True
    for name in names:

        def gap(law: SampleStatistics, name: str = name) -> float:
            return abs(law.mean[name] - law.mode[name])

        least, where = _worst(every, gap)
        same = sum(gap(law) <= 0.01 for law in every)
        holds &= same == 0
        parts.append(
            f"{name}: smallest difference {least:.4f} ({where})"
            + (f", too small in {same} of {len(every)} cases" if same else "")
        )
    return Verdict(holds, "; ".join(parts))


def scattered_everywhere(laws: FigureStatistics, source: str) -> Verdict | None:
    """Spread of the rebound angle of the mixture."""
    curve = laws.curve(source, MIXTURE)
    if not curve:
        return None
    least = min(curve, key=lambda law: law.scattering_deg)
    text = f"smallest {least.scattering_deg:.1f}° (at {least.alpha_deg:g}°)"
    return Verdict(least.scattering_deg > 5.0, text)


def scattering_strongest_at_normal(laws: FigureStatistics, source: str) -> Verdict | None:
    """Angle of the widest spread of the mixture."""
    curve = laws.curve(source, MIXTURE)
    if not curve:
        return None
    most, last = max(curve, key=lambda law: law.scattering_deg), curve[-1]
    text = (
        f"largest {most.scattering_deg:.1f}° (at {most.alpha_deg:g}°), "
        f"{last.scattering_deg:.1f}° at {last.alpha_deg:g}°"
    )
    return Verdict(most is last and last.alpha_deg == 90.0, text)


def indicatrix_maxima(law: SampleStatistics) -> list[float]:
    """Angles alpha2 [degrees] of the maxima of the 2D indicatrix.

    A maximum counts if it stands out by a twentieth of the highest.
    """
    density = gaussian_filter1d(law.scattering.astype(np.float64), _SMOOTHING)
    # at grazing impact the highest bin may be the first
    peaks, _ = find_peaks(np.pad(density, 1), prominence=0.05 * density.max())
    return [float((k - 0.5) * 180.0 / SCATTERING_BINS) for k in peaks]


def _maxima(
    laws: FigureStatistics, source: str, angles: tuple[float, float], number: int
) -> Verdict | None:
    low, high = angles
    chosen = [law for law in laws.curve(source, MIXTURE) if low <= law.alpha_deg <= high]
    if not chosen:
        return None
    found = {law.alpha_deg: len(indicatrix_maxima(law)) for law in chosen}
    wrong = [f"{n} at {angle:g}°" for angle, n in found.items() if n != number]
    text = f"{number} at every angle of {len(found)}" if not wrong else ", ".join(wrong)
    return Verdict(not wrong, text)


def one_maximum_below_70(laws: FigureStatistics, source: str) -> Verdict | None:
    """Maxima of the 2D indicatrix of the mixture below 70 degrees."""
    return _maxima(laws, source, (0.0, 69.0), 1)


def two_maxima_from_70(laws: FigureStatistics, source: str) -> Verdict | None:
    """Maxima of the 2D indicatrix of the mixture from 70 degrees on."""
    return _maxima(laws, source, (70.0, 90.0), 2)


def spheres_are_regular(laws: FigureStatistics, source: str) -> Verdict | None:
    """Range of the rebound angle of spheres."""
    if source != DIRECT:
        return None
    widest = max(high - low for low, high in laws.sphere_deg.values())
    return Verdict(widest < 1e-9, f"widest range {widest:.1e} degrees")
