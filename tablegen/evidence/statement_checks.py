"""The paper's statements on velocities, collisions, spins and energies (Section 2), checked."""

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from scipy.ndimage import gaussian_filter1d

from tablegen.config.defaults import MIXTURE
from tablegen.evidence.checked_statement import Checks, Findings
from tablegen.evidence.sample_statistics import (
    DENSITY,
    FigureStatistics,
    SampleStatistics,
)
from tablegen.model.float_array import FloatArray

CHECKS = Checks()

#: Largest asymmetry that counts as symmetric; see
#: `tablegen.evidence.sample_statistics.asymmetry`.
_SYMMETRIC = 5.0

#: Smoothing of densities before maxima are sought, in bins.
_SMOOTHING = 3.0


def _where(sample: SampleStatistics) -> str:
    return f"{sample.shape}, {sample.alpha_deg:g}°"


def _curves(statistics: FigureStatistics, source: str) -> Iterator[list[SampleStatistics]]:
    return (statistics.curve(source, shape) for shape in statistics.shapes(source))


def _all(statistics: FigureStatistics, source: str) -> list[SampleStatistics]:
    return [sample for curve in _curves(statistics, source) for sample in curve]


def _normal(
    statistics: FigureStatistics, source: str, without: tuple[str, ...] = ()
) -> list[SampleStatistics]:
    return [s for s in _all(statistics, source) if s.alpha_deg == 90.0 and s.shape not in without]


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def _mode_against_mean(
    samples: Iterable[SampleStatistics],
    name: str,
    words: str,
    too_small: Callable[[SampleStatistics, float], bool],
) -> tuple[bool, str]:
    """Smallest difference of mean and most probable value, and how many are too small."""
    gaps = [(abs(s.mean[name] - s.mode[name]), s) for s in samples]
    least, where = min(gaps, key=lambda pair: pair[0])
    same = sum(too_small(sample, gap) for gap, sample in gaps)
    text = words.format(f"{least:.4f}") + f" ({_where(where)})"
    return not same, text + (f", too small in {same} of {len(gaps)} cases" if same else "")


@CHECKS.statement(
    "Section 2, Figures 3 and 4",
    "The mean and the most probable value of u⁺ and of v⁺ differ much at all impact angles.",
    "the two differ by more than 0.01 V and by 5 standard errors, every shape and angle",
)
def _means_differ_from_modes(statistics: FigureStatistics, source: str) -> Findings:
    every = _all(statistics, source)
    for name in ("u", "v") if every else ():

        def too_small(sample: SampleStatistics, gap: float, name: str = name) -> bool:
            return gap < max(0.01, 5.0 * sample.error[name])

        yield _mode_against_mean(every, name, name + "⁺: smallest difference {} V", too_small)


def _folded_density(sample: SampleStatistics) -> FloatArray:
    """Smoothed density of |u|, from zero on."""
    low, high, bins = DENSITY["u"]
    counts = sample.density["u"].astype(np.float64)
    zero = round(-low / (high - low) * bins)
    width = min(zero, bins - zero)
    both = counts[zero : zero + width] + counts[zero - width : zero][::-1]
    return np.asarray(gaussian_filter1d(both, _SMOOTHING, mode="reflect"))


def _peak_of_u(sample: SampleStatistics) -> tuple[float, float]:
    """Position of the maximum of the density of |u|, and the density at zero over it.

    A maximum that exceeds the density at zero by less than four standard errors is at zero.
    """
    low, high, bins = DENSITY["u"]
    density = _folded_density(sample)
    top = int(density.argmax())
    # a Gaussian averages 2 sqrt(pi) times its width in bins; at the edge, half as many
    averaged = 2.0 * np.sqrt(np.pi) * _SMOOTHING
    noise = np.sqrt(density[top] / averaged + density[0] / (0.5 * averaged))
    if density[top] - density[0] < 4.0 * noise:
        top = 0
    position = 0.0 if top == 0 else (top + 0.5) * (high - low) / bins
    return position, float(density[0] / density[top])


@CHECKS.statement(
    "Section 2, Figure 3",
    "At normal impact the most probable u⁺ is zero for every shape but the prism.",
    "the peak of the density of |u⁺| is at zero",
    head="peak of |u⁺| at: ",
    between=", ",
)
def _tangential_mode_is_zero(statistics: FigureStatistics, source: str) -> Findings:
    for sample in _normal(statistics, source, without=("prism",)):
        peak = _peak_of_u(sample)[0]
        yield peak == 0.0, f"{sample.shape} {peak:.2f}"


@CHECKS.statement(
    "Section 2, Figure 5",
    "For prisms at normal impact the density of u⁺ has two equal maxima on both sides of a "
    "minimum at zero.",
    "the density at zero is below 97 % of the maximum, and u⁺ is symmetric",
)
def _prisms_have_two_maxima(statistics: FigureStatistics, source: str) -> Findings:
    sample = statistics.at(source, "prism", 90.0)
    if sample is not None:
        position, ratio = _peak_of_u(sample)
        skew = sample.asymmetry["u"]
        text = f"maxima at ±{position:.2f}, density at zero {_percent(ratio)} of them"
        holds = position > 0.0 and ratio < 0.97 and skew <= _SYMMETRIC
        yield holds, f"{text}, asymmetry {skew:.1f}"


@CHECKS.statement(
    "Section 2, table",
    "At normal impact fewer than half of the particles of any shape collide only once.",
    "share of single collisions below 50 %",
    direct_only=True,
    between=", ",
)
def _singles_below_half(statistics: FigureStatistics, source: str) -> Findings:
    for sample in _normal(statistics, source):
        yield sample.singles < 0.5, f"{sample.shape} {_percent(sample.singles)}"


@CHECKS.statement(
    "Section 2, table",
    "At normal impact the particles of all shapes but ellipsoids mostly collide twice or more "
    "often.",
    "share of repeated collisions above that of single ones, ellipsoids left out",
    direct_only=True,
    between=", ",
)
def _repeated_prevail(statistics: FigureStatistics, source: str) -> Findings:
    for sample in _normal(statistics, source, without=("ellipsoid", MIXTURE)):
        share = 1.0 - sample.singles
        yield share > 0.5, f"{sample.shape} {_percent(share)}"


@CHECKS.statement(
    "Section 2",
    "With falling impact angle the share of single collisions changes, for every shape, not "
    "monotonically.",
    "the share both rises and falls, by 4 standard errors",
    direct_only=True,
)
def _singles_not_monotonic(statistics: FigureStatistics, source: str) -> Findings:
    for curve in _curves(statistics, source):
        shares = np.array([sample.singles for sample in curve])
        noise = 4.0 * np.sqrt(0.5 / curve[0].count)
        # rises to its maximum and falls from it, or falls to its minimum and rises from it
        inner = [k for k in (shares.argmax(), shares.argmin()) if 0 < k < len(shares) - 1]
        turns = any(
            min(abs(shares[k] - shares[0]), abs(shares[k] - shares[-1])) > noise for k in inner
        )
        middle = "monotonic"
        if turns:
            middle = f"{_percent(shares[inner[0]])} at {curve[inner[0]].alpha_deg:g}°"
        first = f"{curve[0].shape} {_percent(shares[0])} at {curve[0].alpha_deg:g}°"
        yield turns, f"{first}, {middle}, {_percent(shares[-1])} at 90°"


@CHECKS.statement(
    "Section 2",
    "At every angle and for every shape 25 to 70 % of the particles collide twice or more often.",
    "smallest and largest share within 25 to 70 %",
    direct_only=True,
)
def _repeated_within_range(statistics: FigureStatistics, source: str) -> Findings:
    every = [sample for sample in _all(statistics, source) if sample.shape != MIXTURE]
    ends = [pick(every, key=lambda sample: 1.0 - sample.singles) for pick in (min, max)]
    low, high = (1.0 - sample.singles for sample in ends)
    text = " to ".join(f"{_percent(1.0 - end.singles)} ({_where(end)})" for end in ends)
    yield low >= 0.25 and high <= 0.70, f"from {text}"


@CHECKS.statement(
    "Section 2, Figure 7",
    "The mean and the most probable Ωz are not positive, for every shape and angle.",
    "at most 5 standard errors (mean) and 0.02 V/a (most probable) above zero",
)
def _spin_not_positive(statistics: FigureStatistics, source: str) -> Findings:
    every = _all(statistics, source)
    if every:
        mean = max(every, key=lambda sample: sample.mean["omega_z"] / sample.error["omega_z"])
        height = mean.mean["omega_z"] / mean.error["omega_z"]
        text = f"largest mean {mean.mean['omega_z']:+.4f} V/a, {height:+.1f} standard errors"
        yield height <= 5.0, f"{text} ({_where(mean)})"
        mode = max(every, key=lambda sample: sample.mode["omega_z"])
        value = mode.mode["omega_z"]
        yield value <= 0.02, f"largest most probable {value:+.4f} V/a ({_where(mode)})"


@CHECKS.statement(
    "Section 2",
    "The share of particles with Ωz > 0 grows with the impact angle.",
    "no step down by more than 4 standard errors",
)
def _positive_spin_grows(statistics: FigureStatistics, source: str) -> Findings:
    for curve in _curves(statistics, source):
        shares = np.array([sample.positive_spin for sample in curve])
        # one more count keeps the error of an empty pair above zero
        errors = np.sqrt((shares[1:] + shares[:-1]) / curve[0].count + 1.0 / curve[0].count ** 2)
        steps = np.diff(shares) / errors
        down = int(steps.argmin())
        grows = steps[down] > -4.0
        text = f"{curve[0].shape} {_percent(shares[0])} to {_percent(shares[-1])}"
        yield grows, text + ("" if grows else f", falls to {curve[down + 1].alpha_deg:g}°")


@CHECKS.statement(
    "Section 2, Figure 8",
    "At normal impact the density of Ωz is symmetric about zero.",
    "asymmetry at most 5 (chance: 1 in 900,000)",
    head="asymmetry: ",
    between=", ",
)
def _normal_spin_is_symmetric(statistics: FigureStatistics, source: str) -> Findings:
    for sample in _normal(statistics, source):
        skew = sample.asymmetry["omega_z"]
        yield skew <= _SYMMETRIC, f"{sample.shape} {skew:.1f}"


@CHECKS.statement(
    "Section 2",
    "The densities of Ωx and Ωy are symmetric about zero at every angle.",
    "asymmetry at most 5 (chance: 1 in 900,000 each), every shape and angle",
    head="largest asymmetry: ",
)
def _transverse_spin_is_symmetric(statistics: FigureStatistics, source: str) -> Findings:
    largest = 0.0
    for curve in _curves(statistics, source):
        skews = [max(s.asymmetry["omega_x"], s.asymmetry["omega_y"]) for s in curve]
        worst = int(np.argmax(skews))
        largest = max(largest, skews[worst])
        text = f"{curve[worst].shape} {skews[worst]:.1f} ({curve[worst].alpha_deg:g}°)"
        yield skews[worst] <= _SYMMETRIC, text
    if largest > _SYMMETRIC:
        yield False, "a tetrahedron of unequal half-sizes is chiral"


@CHECKS.statement(
    "Section 2, Figure 9",
    "Particles lose much kinetic energy in the rebound.",
    "mean loss of kinetic energy, translational and rotational, above 5 % at every angle",
    direct_only=True,
)
def _energy_is_lost(statistics: FigureStatistics, source: str) -> Findings:
    losses = [
        (1.0 - sample.mean["translational"] - sample.mean["rotational"], _where(sample))
        for sample in _all(statistics, source)
    ]
    least, where = min(losses, key=lambda pair: pair[0])
    yield least > 0.05, f"smallest mean loss {_percent(least)} ({where})"


@CHECKS.statement(
    "Section 2, Figure 9",
    "The mean translational energy falls monotonically with rising impact angle.",
    "falls at every step of 5°",
)
def _translational_falls(statistics: FigureStatistics, source: str) -> Findings:
    for curve in _curves(statistics, source):
        means = np.array([sample.mean["translational"] for sample in curve])
        steps = np.diff(means)
        text = f"{curve[0].shape} {means[0]:.3f} to {means[-1]:.3f}"
        yield bool(np.all(steps < 0.0)), f"{text}, least step {steps.max():+.4f}"


def _peak_of_rotational(curve: list[SampleStatistics]) -> tuple[float, float]:
    """Angle and height of the highest mean rotational energy."""
    means = np.array([sample.mean["rotational"] for sample in curve])
    top = int(means.argmax())
    if not 0 < top < len(means) - 1:
        return curve[top].alpha_deg, float(means[top])
    left, middle, right = means[top - 1 : top + 2]
    offset = 0.5 * (left - right) / (left - 2.0 * middle + right)
    step = curve[top + 1].alpha_deg - curve[top].alpha_deg
    return curve[top].alpha_deg + offset * step, float(middle)


@CHECKS.statement(
    "Section 2, Figure 9",
    "The mean rotational energy has its maximum at 15 to 20°, for every shape and the mixture.",
    "maximum of a parabola through the highest point and its neighbours within 15 to 20°",
    direct_only=True,
    head="maximum at: ",
    between=", ",
)
def _rotational_peak(statistics: FigureStatistics, source: str) -> Findings:
    for curve in _curves(statistics, source):
        angle = _peak_of_rotational(curve)[0]
        yield 15.0 <= angle <= 20.0, f"{curve[0].shape} {angle:.1f}°"


@CHECKS.statement(
    "Section 2, Figure 9",
    "Ellipsoids and truncated prisms have the greatest rotational energy.",
    "their maxima are above those of prisms and tetrahedra",
    direct_only=True,
)
def _greatest_rotational(statistics: FigureStatistics, source: str) -> Findings:
    heights = {c[0].shape: _peak_of_rotational(c)[1] for c in _curves(statistics, source)}
    heights.pop(MIXTURE, None)
    order = sorted(heights, key=heights.__getitem__, reverse=True)
    text = ", ".join(f"{shape} {heights[shape]:.3f}" for shape in order)
    yield set(order[:2]) == {"ellipsoid", "truncated-prism"}, f"maxima: {text}"


@CHECKS.statement(
    "Section 2, Figure 10",
    "The most probable energies differ much from the mean ones.",
    "translational and rotational differ by more than 0.01 of the energy before, every shape "
    "and angle",
)
def _energies_differ(statistics: FigureStatistics, source: str) -> Findings:
    every = _all(statistics, source)
    for name in ("translational", "rotational"):
        if every and name in every[0].mean:
            words = name + ": smallest difference {}"
            yield _mode_against_mean(every, name, words, lambda _, gap: gap <= 0.01)
