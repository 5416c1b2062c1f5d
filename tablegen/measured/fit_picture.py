"""Picture of a calibration: means with bands of their spreads against the angle, and residuals."""

from typing import Any

import numpy as np

from tablegen.measured.comparison_picture import LABELS
from tablegen.measured.records import QUANTITIES, SPREAD
from tablegen.measured.result import Calibration, FittedNumber
from tablegen.presentation import (
    ANGLE_LABEL,
    Picture,
    new_figure,
    settings,
    written,
)

_MEASURED, _SIMULATED = "#000000", "#0072b2"


def fit_picture(made: Calibration, name: str) -> Picture:
    """Draw measured and simulated numbers of a calibration, and their residuals.

    Parameters
    ----------
    made : Calibration
    name : str
        Of the picture's file; its ending says which kind of picture it is.

    Returns
    -------
    Picture
    """
    there = {number.column.removesuffix(SPREAD) for number in made.numbers}
    quantities = [quantity for quantity in QUANTITIES if quantity in there]
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


def _of(made: Calibration, column: str, held_out: bool | None = None) -> list[FittedNumber]:
    """Numbers of a column, in the order of their angles."""
    found = [
        n
        for n in made.numbers
        if n.column == column and (held_out is None or n.held_out is held_out)
    ]
    return sorted(found, key=lambda number: number.alpha_deg)


def _draw_fit(ax: Any, made: Calibration, quantity: str) -> None:
    spreads = {number.row: number for number in _of(made, quantity + SPREAD)}
    means = _of(made, quantity)
    ax.set_ylabel(LABELS[quantity])
    if not means:  # a spread alone, about a mean that symmetry makes zero
        found = _of(made, quantity + SPREAD)
        at = [one.alpha_deg for one in found]
        ax.plot(at, [one.measured for one in found], "o", color=_MEASURED, label="measured")
        ax.plot(at, [one.simulated for one in found], color=_SIMULATED, label="simulated")
        ax.set_ylabel(f"{LABELS[quantity]}, spread")
        return
    angle = np.array([one.alpha_deg for one in means])
    simulated = np.array([one.simulated for one in means])
    wide = [one for one in means if one.row in spreads]
    if wide:
        places = np.array([one.alpha_deg for one in wide])
        middle = np.array([one.simulated for one in wide])
        half = np.array([spreads[one.row].simulated for one in wide])
        ax.fill_between(
            places,
            middle - half,
            middle + half,
            color=_SIMULATED,
            alpha=0.2,
            lw=0,
            label="± simulated spread",
        )
        ax.errorbar(
            places,
            [one.measured for one in wide],
            [spreads[one.row].measured for one in wide],
            fmt="none",
            color=_MEASURED,
            capsize=3,
            lw=1,
            label="± measured spread",
        )
    ax.plot(angle, simulated, color=_SIMULATED, label="simulated")
    for held_out, face in ((False, _MEASURED), (True, "white")):
        part = [one for one in means if one.held_out is held_out]
        if part:
            ax.plot(
                [one.alpha_deg for one in part],
                [one.measured for one in part],
                "o",
                ms=5,
                color=_MEASURED,
                mfc=face,
                label="held out" if held_out else "measured",
            )


def _draw_residuals(ax: Any, made: Calibration, quantity: str) -> None:
    ax.axhline(0.0, color="#888888", lw=1)
    ax.set_ylabel("simulated − measured")
    for column, marker, label in ((quantity, "o", "mean"), (quantity + SPREAD, "^", "spread")):
        found = _of(made, column)
        if found:
            ax.errorbar(
                [one.alpha_deg for one in found],
                [one.residual for one in found],
                [one.predicted for one in found],
                fmt=marker,
                ms=5,
                color=_SIMULATED,
                capsize=2,
                lw=1,
                label=label,
                mfc=_SIMULATED if marker == "o" else "white",
            )
