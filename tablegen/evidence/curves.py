"""Figures 3, 4, 7, 9 and 10: means and most probable values against the impact angle."""

from typing import Any

from tablegen.evidence.sample_statistics import (
    DIRECT,
    TABLE,
    FigureStatistics,
    SampleStatistics,
)
from tablegen.presentation import (
    ANGLE_LABEL,
    COLOURS,
    MARKERS,
    MIXTURE,
    SYMBOLS,
    TABLE_COLOUR,
    Picture,
    new_figure,
    numbered,
)

#: Panels of each figure: quantity and whether its mean or its most probable value.
_MEAN, _MODE = "mean", "mode"
_WORDS = {_MEAN: "mean", _MODE: "most probable"}

_FIGURES = (
    (3, "Mean and most probable tangential velocity", (("u", _MEAN), ("u", _MODE))),
    (4, "Mean and most probable normal velocity", (("v", _MEAN), ("v", _MODE))),
    (7, "Mean and most probable angular velocity", (("omega_z", _MEAN), ("omega_z", _MODE))),
    (9, "Mean energies", (("translational", _MEAN), ("rotational", _MEAN))),
    (10, "Most probable energies", (("translational", _MODE), ("rotational", _MODE))),
)


def _points(
    curve: list[SampleStatistics], quantity: str, which: str
) -> tuple[list[float], list[float]]:
    """Angles and values of those samples that have the quantity."""
    chosen = [s for s in curve if quantity in s.mean]
    return [s.alpha_deg for s in chosen], [getattr(s, which)[quantity] for s in chosen]


def _absolute(sample: SampleStatistics, quantity: str, value: float) -> float:
    """Of two equal maxima about zero at normal impact the paper shows the positive one."""
    return abs(value) if quantity == "u" and sample.alpha_deg == 90.0 else value


def _draw_panel(axes: Any, statistics: FigureStatistics, quantity: str, which: str) -> None:
    for shape in statistics.shapes(DIRECT):
        curve = statistics.curve(DIRECT, shape)
        x, y = _points(curve, quantity, which)
        if which == _MODE:
            y = [_absolute(sample, quantity, value) for sample, value in zip(curve, y, strict=True)]
        axes.plot(
            x,
            y,
            color=COLOURS[shape],
            marker=MARKERS[shape],
            markersize=4,
            linewidth=2.2 if shape == MIXTURE else 1.2,
            label=f"{shape}, direct",
        )
    x, y = _points(statistics.curve(TABLE, MIXTURE), quantity, which)
    if x:
        axes.plot(
            x,
            y,
            color=TABLE_COLOUR,
            linestyle="none",
            marker="o",
            markersize=9,
            markerfacecolor="none",
            markeredgewidth=1.8,
            label="mixture, table",
        )
    axes.set(xlabel=ANGLE_LABEL, ylabel=f"{_WORDS[which]} {SYMBOLS[quantity]}", xlim=(0, 92))
    axes.set_xticks(range(0, 91, 15))


def curve_figures(statistics: FigureStatistics) -> list[Picture]:
    """Draw the figures whose abscissa is the impact angle."""
    pictures = []
    for number, title, panels in _FIGURES:
        figure = new_figure(9.5, 4.6)
        columns = figure.subplots(1, 2)
        for axes, letter, (quantity, which) in zip(columns, "ab", panels, strict=True):
            _draw_panel(axes, statistics, quantity, which)
            axes.set_title(f"({letter})", loc="left")
        handles, labels = columns[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        alternative = (
            f"Two plots against the impact angle from 5 to 90 degrees at 200 m/s: "
            f"{title[0].lower()}{title[1:]} of ellipsoids, prisms, truncated prisms, tetrahedra "
            "and their mixture from direct simulation, and of the mixture from the table, as "
            "circles. The numbers are in laws.json."
        )
        pictures.append(numbered(figure, number, title, alternative))
    return pictures
