"""Pictures of measured and simulated rebounds against the impact angle."""

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np

from tablegen.config.complaints import shown
from tablegen.measured.compare import MeasuredComparison
from tablegen.measured.measurements import QUANTITIES, SPREAD
from tablegen.measured.result import Calibration, ComparedNumber, Fit
from tablegen.presentation import ANGLE_LABEL, COLOURS, Picture, new_figure, settings, written

#: Colours and line styles of the simulations of a comparison, one for each speed, repeated.
_COLOURS = tuple(COLOURS[name] for name in ("ellipsoid", "truncated-prism", "tetrahedron"))
_LINES = ("-", "--", "-.", ":")


def comparison_picture(comparison: MeasuredComparison, name: str) -> Picture:
    """Draw a panel for each measured quantity: means with bands of one standard deviation.

    The ending of the name of the file selects the format.
    """
    quantities = list(comparison.means)
    columns = min(len(quantities), 2)
    lines = -(-len(quantities) // columns)
    with settings():
        figure = new_figure(4.6 * columns + 0.4, 3.7 * lines + 0.7)
        panels = figure.subplots(lines, columns, squeeze=False).flat
        for axes, quantity in zip(panels, quantities, strict=False):
            _draw_panel(axes, comparison, quantity)
        for axes in list(panels)[len(quantities) :]:
            axes.remove()
        handles: dict[str, Any] = {}
        for axes in figure.axes:
            handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=2)
        title = f"{comparison.pair} beside {comparison.measured.name}"
        alternative = (
            f"{len(quantities)} plots against the impact angle: means and standard deviations "
            f"measured ({comparison.measured.name}) and simulated ({comparison.pair})."
        )
        return written(figure, name, title, alternative)


def _draw_panel(axes: Any, comparison: MeasuredComparison, quantity: str) -> None:
    """Draw a simulated line with a band for each speed, and measured points with bars."""
    mean, spread = comparison.means[quantity], comparison.spreads[quantity]
    alpha, rows = comparison.measured.alpha_deg, np.isfinite(mean.measured)
    speeds = np.unique(comparison.speed[rows])
    for k, speed in enumerate(speeds):
        of = np.flatnonzero(rows & (comparison.speed == speed))
        of = of[np.argsort(alpha[of], kind="stable")]
        x, y, s = alpha[of], mean.simulated[of], spread.simulated[of]
        colour, line = _COLOURS[k % len(_COLOURS)], _LINES[k % len(_LINES)]
        label = f"simulated, {comparison.pair}" + (f", {speed:g} m/s" if speeds.size > 1 else "")
        axes.plot(x, y, color=colour, linestyle=line, label=label)
        band = f"{label}, ± 1 standard deviation"
        axes.fill_between(x, y - s, y + s, color=colour, alpha=0.18, linewidth=0, label=band)
    bars = np.isfinite(spread.measured) & rows
    label = f"measured, {comparison.measured.name}"
    axes.errorbar(
        alpha[rows],
        mean.measured[rows],
        yerr=np.where(bars, spread.measured, 0.0)[rows] if bars.any() else None,
        color=COLOURS["prism"],
        linestyle="none",
        marker="o",
        markersize=5,
        capsize=3,
        label=f"{label}, ± 1 standard deviation" if bars.any() else label,
    )
    axes.set(xlabel=ANGLE_LABEL, ylabel=QUANTITIES[quantity].label, xlim=(0, 92))
    axes.set_xticks(range(0, 91, 15))


def fit_picture(made: Calibration, name: str) -> Picture:
    """Draw measured and simulated numbers of the chosen fit, its spreads, and both laws.

    The ending of the name of the file selects the format. Each speed has one colour in all panels;
    a spread without its mean, as that out of the plane, has a panel too.
    """
    fit = made.chosen
    quantities = [q for q in QUANTITIES if _numbers_of(fit, q)]
    spreads = [q + SPREAD for q in QUANTITIES if _numbers_of(fit, q + SPREAD)]
    speeds = sorted({number.speed for number in fit.numbers}, key=lambda speed: speed or 0.0)
    with settings():
        columns = [*quantities, *spreads]
        rows = 1 + bool(spreads)
        width = -(-(len(columns) + 2) // rows)
        figure = new_figure(0.6 + 3.6 * width, 1.3 + 2.6 * rows)
        panels = list(figure.subplots(rows, width, squeeze=False).flat)
        for ax, column in zip(panels, columns, strict=False):
            label = QUANTITIES[column.removesuffix(SPREAD)].label
            ax.set_ylabel(f"spread of {label}" if column in spreads else label)
            ax.set_xlabel(ANGLE_LABEL)
            _draw_numbers(ax, _numbers_of(fit, column), speeds)
        of_laws = panels[len(columns) : len(columns) + 2]
        for ax, law in zip(of_laws, ("restitution", "resistance"), strict=True):
            _draw_law(ax, getattr(fit.config.pair, law), speeds)
            ax.set(xlabel="angle at the contact [°]", ylabel=f"law of {law}")
        for ax in panels[len(columns) + 2 :]:
            ax.remove()
        handles: dict[str, Any] = {}
        for ax in figure.axes:
            handles |= dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=3)
        title = f"{made.config.name}: measured and fitted rebounds, {fit.grains} grains"
        words = f"{title}: means, spreads and both laws against the angle"
        return written(figure, name, title, words)


def _numbers_of(fit: Fit, column: str) -> list[ComparedNumber]:
    """Select the numbers of a column, in the order of speeds and angles."""
    numbers = [number for number in fit.numbers if number.column == column]
    return sorted(numbers, key=lambda number: (number.speed or 0.0, number.alpha_deg))


def _look_of(speed: float | None, speeds: Sequence[float | None]) -> tuple[str, str, str]:
    """Choose the colour and the line style of a speed, and its words in a legend."""
    k = min(range(len(speeds)), key=lambda k: abs((speeds[k] or 0.0) - (speed or 0.0)))
    words = "" if speed is None or len(speeds) < 2 else f", {speed:g} m/s"
    return _COLOURS[k % len(_COLOURS)], _LINES[k // len(_COLOURS) % len(_LINES)], words


def _draw_numbers(ax: Any, numbers: list[ComparedNumber], speeds: Sequence[float | None]) -> None:
    """Draw measured numbers with their errors, and a simulated line for each speed."""
    known = any(one.error for one in numbers)
    for speed, group in groupby(numbers, key=lambda number: number.speed):
        part, (colour, line, label) = list(group), _look_of(speed, speeds)
        angle = [one.alpha_deg for one in part]
        simulated = [one.simulated for one in part]
        ax.plot(angle, simulated, line, color=colour, label=f"simulated{label}")
        bars = [(one.error if known else one.tolerance) or 0.0 for one in part]
        words = f"measured{label}, with {'standard error' if known else 'tolerance'}"
        if not any(bars):
            words = f"measured{label}"
        look = {"fmt": "o", "ms": 4, "color": colour, "mfc": "white", "capsize": 2}
        ax.errorbar(angle, [one.measured for one in part], bars, label=words, **look)


def _draw_law(ax: Any, law: Any, speeds: Sequence[float | None]) -> None:
    """Draw a tabulated law, a curve for each of its speeds; others have their numbers written."""
    if law.law != "tabulated":
        numbers = law.model_dump(exclude={"source", "law", "valid_speed"}, exclude_none=True)
        text = "\n".join([law.law, *(f"{k} = {shown(v)}" for k, v in numbers.items())])
        ax.text(0.05, 0.95, text, transform=ax.transAxes, va="top", fontsize=7)
        return
    values = np.array(law.value).reshape(len(law.angle_deg), -1)
    of = law.speed if values.shape[1] > 1 else [speeds[0]]
    for column, speed in zip(values.T, of, strict=True):
        colour, line, label = _look_of(speed, speeds)
        shade = colour if values.shape[1] > 1 or len(speeds) < 2 else "#000000"
        words = "law" + (label if values.shape[1] > 1 else "")
        ax.plot(law.angle_deg, column, line, color=shade, marker="s", ms=3, label=words)
    ax.set_ylim(bottom=0.0)
