"""Paper of Panfilov and Tsirkunov (2022): its figures, and our numbers beside its own, as files."""

from collections.abc import Callable, Iterable

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from sampler.table import Table
from tablegen.config.config import Config
from tablegen.evidence.page import Section, render_page
from tablegen.evidence.paper_figures import paper_pictures
from tablegen.evidence.paper_statistics import (
    ANGLES,
    SCATTERING_BINS,
    SHAPES,
    SPEED,
    FigureStatistics,
    SampleStatistics,
    make_statistics,
)
from tablegen.model.float_array import FloatArray
from tablegen.presentation import TextTable
from tablegen.progress import bar

#: Shares of particles with 1, 2, 3, 4, 5 and more collisions at normal impact [%].
COLLISIONS = {
    "ellipsoid": (42.2, 31.2, 8.9, 4.3, 2.6, 10.8),
    "prism": (13.3, 40.1, 19.5, 14.6, 5.4, 7.1),
    "truncated-prism": (25.9, 37.7, 17.8, 9.7, 4.8, 4.1),
    "tetrahedron": (5.2, 12.8, 9.3, 7.9, 8.3, 56.5),
}

#: File of ``tablegen figures`` beside the pictures.
PAGE = "paper.html"

#: Samples of one shape, or of the table, by rising angle.
_Curve = list[SampleStatistics]


def _percent(shares: Iterable[float]) -> str:
    return " ".join(f"{share:.1f}" for share in shares)


def _collisions(curve: _Curve) -> str:
    shares = curve[-1].collisions
    return "" if shares is None else _percent(100.0 * shares)


def _rotational(curve: _Curve) -> str:
    top = max(curve, key=lambda sample: sample.mean.get("rotational", 0.0))
    height = top.mean.get("rotational")
    return "" if height is None else f"{height:.3f} at {top.alpha_deg:g}°"


def _translational(curve: _Curve) -> str:
    means = [sample.mean["translational"] for sample in curve]
    return f"{means[0]:.3f} to {means[-1]:.3f}, {np.diff(means).max(initial=-1.0):+.4f}"


def _largest_spin(curve: _Curve) -> str:
    return ", ".join(
        f"{max(getattr(sample, which)['omega_z'] for sample in curve):+.4f}"
        for which in ("mean", "mode")
    )


def _positive_spin(curve: _Curve) -> str:
    shares = [sample.positive_spin for sample in curve]
    return f"{shares[0]:.3f} to {shares[-1]:.3f}, {np.diff(shares).min(initial=1.0):+.4f}"


def _offset(curve: _Curve) -> str:
    """Give the largest mean of what is symmetric about zero, in standard errors."""
    normal = "w", "omega_x", "omega_y", "u", "omega_z"
    offsets = (
        abs(sample.mean[name]) / max(sample.error[name], 1e-12)  # spheres do not scatter
        for sample in curve
        for name in (normal if sample.alpha_deg == 90.0 else normal[:3])
    )
    return f"{max(offsets):.1f}"


def _mode_at_normal(curve: _Curve) -> str:
    # of two equal maxima either may be the mode
    return "".join(f"{abs(s.mode['u']):.2f}" for s in curve if s.alpha_deg == 90.0)


def indicatrix_maxima(scattering: FloatArray) -> list[float]:
    """Angles alpha2 [degrees] of maxima that stand out by a twentieth of the highest."""
    density = gaussian_filter1d(scattering, 3.0)
    # at grazing impact the highest bin may be the first
    peaks, _ = find_peaks(np.pad(density, 1), prominence=0.05 * density.max())
    return [float((k - 0.5) * 180.0 / SCATTERING_BINS) for k in peaks]


def _two_maxima(curve: _Curve) -> str:
    two = (s.alpha_deg for s in curve if len(indicatrix_maxima(s.scattering)) == 2)
    return " ".join(f"{alpha_deg:g}" for alpha_deg in two) or "none"


#: What a number is, what the paper says, and ours of a curve; "" where a table cannot tell.
_NUMBERS: tuple[tuple[str, str, Callable[[_Curve], str]], ...] = (
    ("1, 2, 3, 4, 5, more collisions at 90° [%]", "above", _collisions),
    ("greatest rotational energy", "at 15 to 20°; ellipsoid, truncated-prism", _rotational),
    ("translational energy, largest step", "falls", _translational),
    ("largest mean, largest most probable Ωz [V/a]", "not above 0", _largest_spin),
    ("share with Ωz > 0, least step", "grows", _positive_spin),
    ("largest mean of w, Ωx, Ωy, at 90° u, Ωz [standard errors]", "symmetric", _offset),
    ("most probable |u| at 90° [V]", "0, of prisms not", _mode_at_normal),
    ("α₁ where α₂ has two maxima [°]", "of the mixture 70 to 90", _two_maxima),
)


def number_table(statistics: FigureStatistics) -> TextTable:
    """Put our numbers of each shape, the mixture and the table beside the paper's."""
    rows = [
        ["collisions, paper", "", *(_percent(COLLISIONS.get(x, ())) for x in statistics.curves)]
    ]
    for words, paper, ours in _NUMBERS:
        curves = (list(curve.values()) for curve in statistics.curves.values())
        rows.append([words, paper, *(ours(curve) if curve else "" for curve in curves)])
    head = ("number", "paper", *statistics.curves)
    return TextTable("Numbers beside the paper's", head, rows, "words")


def make_paper(
    table: Table, config: Config, count: int, seed: int, progress: bool = False
) -> dict[str, bytes]:
    """Make the files of ``tablegen figures`` by name, of `count` particles of a shape and angle."""
    with bar(progress, total=len(ANGLES) * len(SHAPES), desc="samples of the figures") as counted:
        statistics = make_statistics(table, config, count, seed, counted.update)
    pictures = paper_pictures(statistics)
    said = f"{config.name}: {count:,} particles of each shape at each angle, {SPEED:g} m/s."
    title = "Panfilov & Tsirkunov (2022), corundum on steel"
    page = render_page(title, [Section(title, [said, number_table(statistics), *pictures])])
    return {picture.name: picture.data for picture in pictures} | {PAGE: page.encode()}
