"""Simulated rebounds beside measured ones, as text for a terminal and as JSON."""

import math
from typing import Any

import numpy as np

from sampler.files.json_text import json_text
from tablegen.measured.compare import Agreement, MeasuredComparison
from tablegen.model.float_array import FloatArray
from tablegen.presentation import table_lines

#: What a quantity is called, and the digits behind the point with which it is printed.
_TITLES = {
    "e_n": ("e_n, normal restitution v+/|v-|", 3),
    "e_t": ("e_t, tangential restitution u+/u-", 3),
    "rebound_angle_deg": ("rebound angle from the wall [degrees]", 2),
    "out_of_plane_deg": ("angle out of the impact plane [degrees]", 2),
    "omega_z": ("omega_z, spin times a/V", 3),
}

_HEAD = ("measured", "simulated", "+-", "diff", "in errors")


def _shown(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _columns(agreement: Agreement, digits: int) -> list[list[str]]:
    """Cells of a mean or of a spread, one column after another."""
    columns = (
        (agreement.measured, digits),
        (agreement.simulated, digits),
        (agreement.simulated_error, digits + 1),
        (agreement.deviation, digits),
        (agreement.in_errors, 1),
    )
    return [[_shown(value, places) for value in values] for values, places in columns]


def _root_mean_square(deviation: FloatArray) -> float | None:
    known = deviation[np.isfinite(deviation)]
    return float(np.sqrt(np.mean(known**2))) if known.size else None


def _largest(deviation: FloatArray) -> float | None:
    known = np.abs(deviation[np.isfinite(deviation)])
    return float(known.max()) if known.size else None


def _speeds(found: MeasuredComparison) -> list[str]:
    """Speed of each row in words."""
    unstated = np.isnan(found.measured.speed)
    pairs = zip(found.speed, unstated, strict=True)
    return ["any" if free and found.speed_independent else f"{v:.4g}" for v, free in pairs]


def _quantity_lines(found: MeasuredComparison, name: str) -> list[str]:
    """Table of a quantity, and its deviations in a line for means and one for spreads."""
    title, digits = _TITLES[name]
    head, columns = ["angle", "m/s"], [[f"{a:.4g}" for a in found.measured.alpha_deg]]
    columns.append(_speeds(found))
    summary = []
    for part, agreement in (("mean", found.means[name]), ("spread", found.spreads[name])):
        rms, most = _root_mean_square(agreement.deviation), _largest(agreement.deviation)
        if rms is None:
            continue
        # errors of measurements are seldom known
        shown = len(_HEAD) if np.isfinite(agreement.in_errors).any() else len(_HEAD) - 1
        head += [f"{part} {_HEAD[0]}", *_HEAD[1:shown]]
        columns += _columns(agreement, digits)[:shown]
        summary.append(f"  {part}: rms deviation {rms:.{digits}f}, largest {most:.{digits}f}")
    cells = list(zip(*columns, strict=True))
    rows = [cells[k] for k in np.flatnonzero(np.isfinite(found.means[name].measured))]
    return [title, *(f"  {line}" for line in table_lines(head, rows)), *summary]


def comparison_text(found: MeasuredComparison) -> str:
    """Tables for a terminal, one for each measured quantity.

    Parameters
    ----------
    found : MeasuredComparison
    """
    shape = found.shape or "all shapes"
    wall = f"facets tilted by {found.wall_tilt_deg:g} degrees" if found.wall_tilt_deg else "smooth"
    lines = [
        f"{found.pair} ({shape}; wall {wall}) beside {found.measured.name}",
        f"{found.count} particles of each shape at each condition, seed {found.seed}",
    ]
    for name in found.means:
        lines += ["", *_quantity_lines(found, name)]
    lines += ["", "+-: chance error of the simulation, one standard deviation"]
    lines += ["diff: simulated less measured; in errors: over the standard error of both"]
    return "\n".join(lines)


def _number(value: float) -> float | None:
    return None if math.isnan(value) else float(value)


def _agreement_at(agreement: Agreement, row: int) -> dict[str, Any]:
    fields = {
        "measured": agreement.measured,
        "measured_error": agreement.measured_error,
        "simulated": agreement.simulated,
        "simulated_error": agreement.simulated_error,
        "deviation": agreement.deviation,
        "deviation_over_error": agreement.in_errors,
    }
    return {name: _number(values[row]) for name, values in fields.items()}


def _row(found: MeasuredComparison, row: int) -> dict[str, Any]:
    data = found.measured
    quantities = {
        name: {
            "mean": _agreement_at(found.means[name], row),
            "spread": _agreement_at(found.spreads[name], row),
        }
        for name in found.means
    }
    return {
        "alpha_deg": float(data.alpha_deg[row]),
        "speed": float(found.speed[row]),
        "speed_stated": not math.isnan(data.speed[row]),
        "count": _number(data.count[row]),
        "source": data.source[row],
        "remarks": data.remarks[row],
        **quantities,
    }


def comparison_json(found: MeasuredComparison) -> str:
    """Everything as JSON text; null: not measured, not defined or not known.

    Parameters
    ----------
    found : MeasuredComparison
    """
    summary = {
        name: {
            f"{part}_{what}_deviation": of(agreements[name].deviation)
            for part, agreements in (("mean", found.means), ("spread", found.spreads))
            for what, of in (("rms", _root_mean_square), ("largest", _largest))
        }
        for name in found.means
    }
    return json_text(
        {
            "pair": found.pair,
            "shape": found.shape,
            "measurements": found.measured.name,
            "about": dict(found.measured.about),
            "count": found.count,
            "seed": found.seed,
            "wall_tilt_deg": found.wall_tilt_deg,
            "speed_independent": found.speed_independent,
            "summary": summary,
            "rows": [_row(found, row) for row in range(len(found.speed))],
        }
    )
