"""Pictures of measured and simulated rebounds against the impact angle."""

from typing import Any

import numpy as np

from tablegen.measured.compare import MeasuredComparison
from tablegen.measured.measurements import QUANTITIES, SPREAD
from tablegen.measured.result import Calibration, FittedNumber
from tablegen.model.float_array import FloatArray
from tablegen.presentation import ANGLE_LABEL, COLOURS, Picture, new_figure, settings, written

#: Colours and line styles of the simulations of a comparison, one for each speed, repeated.
_COLOURS = tuple(COLOURS[name] for name in ("ellipsoid", "truncated-prism", "tetrahedron"))
_LINES = ("-", "--", "-.", ":")

#: Colours of a fit.
_MEASURED, _SIMULATED = "#000000", "#0072b2"


def comparison_picture(found: MeasuredComparison, name: str) -> Picture:
    """Draw a panel for each measured quantity: means with bands of one standard deviation.

    The ending of the name of the file selects the format.
    """
    quantities = list(found.means)
    columns = min(len(quantities), 2)
    lines = -(-len(quantities) // columns)
    with settings():
        figure = new_figure(4.6 * columns + 0.4, 3.7 * lines + 0.7)
        panels = figure.subplots(lines, columns, squeeze=False).flat
        for axes, quantity in zip(panels, quantities, strict=False):
            _draw_panel(axes, found, quantity)
        for axes in list(panels)[len(quantities) :]:
            axes.remove()
        handles: dict[str, Any] = {}
        for axes in figure.axes:
            handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=2)
        title = f"{found.pair} beside {found.measured.name}"
        alternative = (
            f"{len(quantities)} plots against the impact angle: means and standard deviations "
            f"measured ({found.measured.name}) and simulated ({found.pair})."
        )
        return written(figure, name, title, alternative)


def _draw_panel(axes: Any, found: MeasuredComparison, quantity: str) -> None:
    """Draw a simulated line with a band for each speed, and measured points with bars."""
    mean, spread = found.means[quantity], found.spreads[quantity]
    alpha, rows = found.measured.alpha_deg, np.isfinite(mean.measured)
    speeds = np.unique(found.speed[rows])
    for k, speed in enumerate(speeds):
        of = np.flatnonzero(rows & (found.speed == speed))
        of = of[np.argsort(alpha[of], kind="stable")]
        x, y, s = alpha[of], mean.simulated[of], spread.simulated[of]
        colour, line = _COLOURS[k % len(_COLOURS)], _LINES[k % len(_LINES)]
        label = f"simulated, {found.pair}" + (f", {speed:g} m/s" if speeds.size > 1 else "")
        axes.plot(x, y, color=colour, linestyle=line, label=label)
        band = f"{label}, ± 1 standard deviation"
        axes.fill_between(x, y - s, y + s, color=colour, alpha=0.18, linewidth=0, label=band)
    bars = np.isfinite(spread.measured) & rows
    label = f"measured, {found.measured.name}"
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
    """Draw measured and simulated numbers of a calibration, and below them the residuals.

    The ending of the name of the file selects the format.
    """
    fitted = {number.column.removesuffix(SPREAD) for number in made.numbers}
    quantities = [quantity for quantity in QUANTITIES if quantity in fitted]
    with settings():
        figure = new_figure(0.6 + 4.0 * len(quantities), 5.6)
        axes = figure.subplots(
            2, len(quantities), sharex=True, squeeze=False, height_ratios=(2.0, 1.0)
        )
        for k, quantity in enumerate(quantities):
            _draw_fit(axes[0, k], made, quantity)
            _draw_residuals(axes[1, k], made, quantity)
            axes[1, k].set_xlabel(ANGLE_LABEL)
        axes[0, 0].legend()
        axes[1, 0].legend()
        title = f"{made.config.name}: measured and fitted rebounds"
        words = f"{title}; {', '.join(quantities)} against impact angle, with residuals below"
        return written(figure, name, title, words)


def _numbers(made: Calibration, column: str) -> list[FittedNumber]:
    """Select the numbers of a column, in the order of their angles."""
    found = [number for number in made.numbers if number.column == column]
    return sorted(found, key=lambda number: number.alpha_deg)


def _array(numbers: list[FittedNumber], field: str) -> FloatArray:
    return np.array([getattr(number, field) for number in numbers])


def _draw_fit(ax: Any, made: Calibration, quantity: str) -> None:
    """Draw simulated means with a band of their spread, and measured ones with bars."""
    means, spreads = _numbers(made, quantity), _numbers(made, quantity + SPREAD)
    label = QUANTITIES[quantity].label
    if not means:  # by symmetry the mean is zero
        angle = _array(spreads, "alpha_deg")
        ax.plot(angle, _array(spreads, "measured"), "o", color=_MEASURED, label="measured")
        ax.plot(angle, _array(spreads, "simulated"), color=_SIMULATED, label="simulated")
        ax.set_ylabel(f"{label}, spread")
        return
    ax.set_ylabel(label)
    by_row = {number.row: number for number in spreads}
    wide = [number for number in means if number.row in by_row]
    if wide:
        beside = [by_row[number.row] for number in wide]
        angle, middle = _array(wide, "alpha_deg"), _array(wide, "simulated")
        half = _array(beside, "simulated")
        band = {"color": _SIMULATED, "alpha": 0.2, "lw": 0, "label": "± simulated spread"}
        ax.fill_between(angle, middle - half, middle + half, **band)
        bars = {"fmt": "none", "color": _MEASURED, "capsize": 3, "lw": 1}
        measured, sizes = _array(wide, "measured"), _array(beside, "measured")
        ax.errorbar(angle, measured, sizes, label="± measured spread", **bars)
    ax.plot(
        _array(means, "alpha_deg"), _array(means, "simulated"), color=_SIMULATED, label="simulated"
    )
    for held_out, label, face in ((False, "measured", _MEASURED), (True, "held out", "white")):
        part = [number for number in means if number.held_out is held_out]
        if part:
            points = _array(part, "alpha_deg"), _array(part, "measured")
            ax.plot(*points, "o", ms=5, color=_MEASURED, mfc=face, label=label)


def _draw_residuals(ax: Any, made: Calibration, quantity: str) -> None:
    """Draw residuals of means and spreads, with the standard errors of the fit."""
    ax.axhline(0.0, color="#888888", lw=1)
    ax.set_ylabel("simulated − measured")
    for column, label, marker, face in (
        (quantity, "mean", "o", _SIMULATED),
        (quantity + SPREAD, "spread", "^", "white"),
    ):
        found = _numbers(made, column)
        if found:
            values = (_array(found, field) for field in ("alpha_deg", "residual", "predicted"))
            look = {"ms": 5, "color": _SIMULATED, "capsize": 2, "lw": 1, "mfc": face}
            ax.errorbar(*values, fmt=marker, label=label, **look)
