"""Pictures of measured and simulated rebounds against the impact angle."""

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

    The ending of the name of the file selects the format.
    """
    fit = made.chosen
    quantities = [q for q in QUANTITIES if _numbers_of(fit, q)]
    with settings():
        figure = new_figure(0.6 + 3.6 * (len(quantities) + 1), 5.8)
        axes = figure.subplots(2, len(quantities) + 1, sharex=True, squeeze=False)
        for k, quantity in enumerate(quantities):
            _draw_numbers(axes[0, k], _numbers_of(fit, quantity))
            axes[0, k].set_ylabel(QUANTITIES[quantity].label)
            _draw_numbers(axes[1, k], _numbers_of(fit, quantity + SPREAD))
            axes[1, k].set_ylabel("spread")
        for ax, law in zip(axes[:, -1], ("restitution", "resistance"), strict=True):
            _draw_law(ax, getattr(fit.config.pair, law))
            ax.set_ylabel(f"law of {law}")
        for ax in axes[1]:
            ax.set_xlabel(ANGLE_LABEL)
        axes[1, -1].set_xlabel("angle at the contact [°]")
        axes[0, 0].legend()
        title = f"{made.config.name}: measured and fitted rebounds, {fit.grains} grains"
        words = f"{title}: means, spreads and both laws against the angle"
        return written(figure, name, title, words)


def _numbers_of(fit: Fit, column: str) -> list[ComparedNumber]:
    """Select the numbers of a column, in the order of speeds and angles."""
    numbers = [number for number in fit.numbers if number.column == column]
    return sorted(numbers, key=lambda number: (number.speed or 0.0, number.alpha_deg))


def _draw_numbers(ax: Any, numbers: list[ComparedNumber]) -> None:
    """Draw measured numbers with their errors, and a simulated line for each speed."""
    for k, (speed, group) in enumerate(groupby(numbers, key=lambda number: number.speed)):
        part, colour = list(group), _COLOURS[k % len(_COLOURS)]
        angle = [one.alpha_deg for one in part]
        label = "" if speed is None else f", {speed:g} m/s"
        ax.plot(angle, [one.simulated for one in part], color=colour, label=f"simulated{label}")
        known = any(one.error for one in part)
        bars = [(one.error if known else one.tolerance) or 0.0 for one in part]
        words = f"measured{label}, with {'standard error' if known else 'tolerance'}"
        look = {"fmt": "o", "ms": 4, "color": colour, "mfc": "white", "capsize": 2}
        ax.errorbar(angle, [one.measured for one in part], bars, label=words, **look)


def _draw_law(ax: Any, law: Any) -> None:
    """Draw a tabulated law; others have their numbers written."""
    if law.law != "tabulated":
        numbers = law.model_dump(exclude={"source", "law", "valid_speed"}, exclude_none=True)
        text = "\n".join([law.law, *(f"{k} = {shown(v)}" for k, v in numbers.items())])
        ax.text(0.05, 0.95, text, transform=ax.transAxes, va="top", fontsize=7)
        return
    ax.plot(law.angle_deg, np.array(law.value), marker="o", ms=3)
    ax.set_ylim(bottom=0.0)
