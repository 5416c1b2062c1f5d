"""All figures of the paper with its table and its statements."""

import importlib.util
from dataclasses import dataclass
from itertools import chain
from typing import Any

from sampler.table import Table
from tablegen.config.config import Config
from tablegen.evidence.curves import curve_figures
from tablegen.evidence.densities import density_figures
from tablegen.evidence.sample_statistics import (
    ANGLES,
    DIRECT,
    SHAPES,
    FigureStatistics,
    make_statistics,
)
from tablegen.evidence.scattering import scattering_figures
from tablegen.evidence.statements import Statement, check_statements, is_of_the_paper
from tablegen.presentation import Picture, settings
from tablegen.tasks.progress import bar

#: The paper's table: shares of particles with 1, 2, 3, 4, 5 and more collisions, normal impact.
PAPER_TABLE = {
    "ellipsoid": (42.2, 31.2, 8.9, 4.3, 2.6, 10.8),
    "prism": (13.3, 40.1, 19.5, 14.6, 5.4, 7.1),
    "truncated-prism": (25.9, 37.7, 17.8, 9.7, 4.8, 4.1),
    "tetrahedron": (5.2, 12.8, 9.3, 7.9, 8.3, 56.5),
}

#: Head of `collision_rows`.
COLLISION_HEAD = ("shape", "source", "1", "2", "3", "4", "5", "> 5")


@dataclass(frozen=True)
class PaperFigures:
    """Figures, statistics and statements."""

    #: Particles of each shape at each angle.
    count: int
    statistics: FigureStatistics
    #: By the number of the figure.
    pictures: tuple[Picture, ...]
    statements: tuple[Statement, ...]


def make_paper_figures(
    table: Table, config: Config, count: int, seed: int, progress: bool = False
) -> PaperFigures | None:
    """Simulate, draw and check everything.

    Parameters
    ----------
    table : Table
    config : Config
        Pair, population and numerics of the direct simulation.
    count : int
        Particles of each shape at each angle.
    seed : int
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    PaperFigures or None
        None where matplotlib is not installed.
    """
    if importlib.util.find_spec("matplotlib") is None:
        return None
    steps = len(ANGLES) * len(SHAPES)
    with bar(progress, total=steps, desc="samples of the figures") as counted:
        statistics = make_statistics(table, config, count, seed, counted.update)
    with settings():
        made = (draw(statistics) for draw in (curve_figures, density_figures, scattering_figures))
        ordered = sorted(chain(*made), key=lambda picture: picture.name)
    return PaperFigures(count, statistics, tuple(ordered), tuple(check_statements(statistics)))


def collision_rows(statistics: FigureStatistics) -> list[list[str]]:
    """Cells of the paper's table in per cent; the paper's too if pair and particles are its own."""
    rows, of_the_paper = [], is_of_the_paper(statistics.config)
    for shape, paper in PAPER_TABLE.items():
        sample = statistics.at(DIRECT, shape, 90.0)
        if sample is not None and sample.collisions is not None:
            rows.append([shape, "direct", *(f"{100.0 * share:.1f}" for share in sample.collisions)])
        if of_the_paper:
            rows.append([shape, "paper", *(f"{share:.1f}" for share in paper)])
    return rows


def to_dict(gallery: PaperFigures) -> dict[str, Any]:
    """Numbers of all samples, JSON-ready."""
    return {
        "count": gallery.count,
        "seed": gallery.statistics.seed,
        "laws": [sample.to_dict() for sample in gallery.statistics.samples.values()],
        "sphere_alpha2_deg": [
            {"alpha_deg": alpha_deg, "alpha2_deg": low}
            for alpha_deg, (low, _) in gallery.statistics.sphere_deg.items()
        ],
    }
