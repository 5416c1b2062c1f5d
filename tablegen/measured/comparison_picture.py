"""Simulated means and spreads beside measured ones, against the impact angle."""

from pathlib import Path
from typing import Any

import numpy as np

from sampler.errors import InputError
from tablegen.measured.compare import MeasuredComparison
from tablegen.measured.records import QUANTITIES
from tablegen.model.float_array import FloatArray
from tablegen.presentation import (
    ANGLE_LABEL,
    COLOURS,
    Picture,
    new_figure,
    settings,
    written,
)

#: Labels of the ordinates.
LABELS = {
    "e_n": r"normal restitution $v^+/|v^-|$",
    "e_t": r"tangential restitution $u^+/u^-$",
    "rebound_angle_deg": "rebound angle [°]",
    "out_of_plane_deg": "angle out of the impact plane [°]",
    "omega_z": r"spin $\Omega_z^+\,a/V$",
}

#: Endings that a picture may have.
KINDS = (".png", ".pdf", ".svg")

#: Of the simulation, a colour and a line style for each speed, which repeat; and of measurements.
_SIMULATED = tuple(COLOURS[name] for name in ("ellipsoid", "truncated-prism", "tetrahedron"))
_LINES = ("-", "--", "-.", ":")
_MEASURED = COLOURS["prism"]


def check_picture(path: Path) -> Path:
    """Refuse a name from whose end no kind of picture follows.

    Raises
    ------
    InputError
        If it ends in none of `KINDS`.
    """
    if path.suffix.lower() not in KINDS:
        raise InputError(f"--picture: got {path}, allowed: a name in {', '.join(KINDS)}")
    return path


def comparison_picture(found: MeasuredComparison, name: str) -> Picture:
    """Draw a panel for each measured quantity: means with bands of one standard deviation.

    Parameters
    ----------
    found : MeasuredComparison
    name : str
        Of the file; its ending says which kind of picture it is.

    Returns
    -------
    Picture
    """
    quantities = [quantity for quantity in QUANTITIES if quantity in found.means]
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


def _sorted(x: FloatArray, *others: FloatArray) -> list[FloatArray]:
    """Arrays in the order of the first."""
    order = np.argsort(x, kind="stable")
    return [array[order] for array in (x, *others)]


def _draw_panel(axes: Any, found: MeasuredComparison, quantity: str) -> None:
    """Draw simulated lines with bands, one for each speed, and measured points with bars."""
    mean, spread = found.means[quantity], found.spreads[quantity]
    alpha, rows = found.measured.alpha_deg, np.isfinite(mean.measured)
    speeds = np.unique(found.speed[rows])
    for k, speed in enumerate(speeds):
        of = rows & (found.speed == speed)
        x, y, s = _sorted(alpha[of], mean.simulated[of], spread.simulated[of])
        colour, line = _SIMULATED[k % len(_SIMULATED)], _LINES[k % len(_LINES)]
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
        color=_MEASURED,
        linestyle="none",
        marker="o",
        markersize=5,
        capsize=3,
        label=f"{label}, ± 1 standard deviation" if bars.any() else label,
    )
    axes.set(xlabel=ANGLE_LABEL, ylabel=LABELS[quantity], xlim=(0, 92))
    axes.set_xticks(range(0, 91, 15))
