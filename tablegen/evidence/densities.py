"""Figures 5, 6 and 8: densities of velocities and of the angular velocity at some angles."""

from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from tablegen.evidence.sample_statistics import (
    DENSITY,
    DIRECT,
    TABLE,
    FigureStatistics,
    SampleStatistics,
)
from tablegen.model.float_array import FloatArray
from tablegen.presentation import MIXTURE, SYMBOLS, Picture, new_figure, numbered

#: Angles that are drawn, and a colour and line style for each; viridis without its yellow end.
_ANGLES = {
    15.0: ("#440154", "-"),
    30.0: ("#3b528b", "--"),
    45.0: ("#21918c", "-."),
    60.0: ("#35a048", ":"),
    90.0: ("#c77700", "-"),
}

_FIGURES = (
    (5, "u", "Densities of the tangential velocity", (-0.6, 0.95)),
    (6, "v", "Densities of the normal velocity", (0.0, 0.65)),
    (8, "omega_z", "Densities of the angular velocity", (-1.6, 1.2)),
)


_TITLES = ("(a) ellipsoids, direct", "(b) prisms, direct", "mixture: direct areas, table lines")


def _density(sample: SampleStatistics, name: str) -> tuple[FloatArray, FloatArray]:
    """Centres of the bins and density in them."""
    low, high, bins = DENSITY[name]
    edges = np.linspace(low, high, bins + 1)
    smoothed = np.asarray(gaussian_filter1d(sample.density[name].astype(np.float64), 1.0))
    return 0.5 * (edges[1:] + edges[:-1]), smoothed / (sample.count * (edges[1] - edges[0]))


def _draw_shape(axes: Any, statistics: FigureStatistics, shape: str, name: str) -> None:
    for alpha_deg, (colour, style) in _ANGLES.items():
        sample = statistics.at(DIRECT, shape, alpha_deg)
        if sample is not None:
            look = {"color": colour, "linestyle": style, "label": f"{alpha_deg:g}°"}
            axes.plot(*_density(sample, name), **look)


def _draw_mixture(axes: Any, statistics: FigureStatistics, name: str) -> None:
    """Direct simulation as areas, the table as lines."""
    for alpha_deg, (colour, _) in _ANGLES.items():
        direct, drawn = (statistics.at(source, MIXTURE, alpha_deg) for source in (DIRECT, TABLE))
        if direct is not None:
            axes.fill_between(*_density(direct, name), color=colour, alpha=0.28, linewidth=0)
        if drawn is not None:
            axes.plot(*_density(drawn, name), color=colour, linewidth=1.1)


def density_figures(statistics: FigureStatistics) -> list[Picture]:
    """Draw densities of ellipsoids and prisms, as the paper does, and of the mixture."""
    pictures = []
    for number, name, title, limits in _FIGURES:
        figure = new_figure(11.5, 4.3)
        columns = figure.subplots(1, 3)
        _draw_shape(columns[0], statistics, "ellipsoid", name)
        _draw_shape(columns[1], statistics, "prism", name)
        _draw_mixture(columns[2], statistics, name)
        for axes, words in zip(columns, _TITLES, strict=True):
            axes.set(xlabel=SYMBOLS[name], xlim=limits)
            axes.set_ylim(bottom=0.0)
            axes.set_title(words, loc="left")
        columns[0].set_ylabel("density")
        handles, labels = columns[0].get_legend_handles_labels()
        figure.legend(
            handles,
            labels,
            loc="outside lower center",
            ncols=len(labels),
            title=r"impact angle $\alpha_1$",
        )
        alternative = (
            f"{title} at impact angles of 15, 30, 45, 60 and 90 degrees and 200 m/s, in three "
            "plots: ellipsoids and prisms from direct simulation, and the mixture from direct "
            "simulation as areas with the table's as lines on their edges."
        )
        pictures.append(numbered(figure, number, title, alternative))
    return pictures
