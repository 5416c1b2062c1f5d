"""Text and JSON of a comparison with measurements."""

import math
from typing import Any

import numpy as np

from sampler.files.json_text import json_text
from tablegen.measured.compare import Agreement, MeasuredComparison
from tablegen.measured.measurements import QUANTITIES
from tablegen.tasks.text_table import table_lines

_HEAD = ("measured", "simulated", "+-", "diff", "in errors")


def comparison_text(found: MeasuredComparison) -> str:
    """Write a table for each measured quantity."""
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


def _quantity_lines(found: MeasuredComparison, name: str) -> list[str]:
    """Write the table of a quantity, and a summary of the means and one of the spreads."""
    digits = QUANTITIES[name].digits
    head = ["angle", "m/s"]
    columns = [[f"{a:.4g}" for a in found.measured.alpha_deg], _speeds(found)]
    summary = []
    for part, agreement in (("mean", found.means[name]), ("spread", found.spreads[name])):
        if agreement.rms is None:
            continue
        # errors of measurements are seldom known
        shown = len(_HEAD) if np.isfinite(agreement.in_errors).any() else len(_HEAD) - 1
        head += [f"{part} {_HEAD[0]}", *_HEAD[1:shown]]
        columns += _columns(agreement, digits)[:shown]
        summary.append(
            f"  {part}: rms deviation {agreement.rms:.{digits}f}, "
            f"largest {agreement.largest:.{digits}f}"
        )
    cells = list(zip(*columns, strict=True))
    rows = [cells[k] for k in np.flatnonzero(np.isfinite(found.means[name].measured))]
    return [QUANTITIES[name].title, *(f"  {line}" for line in table_lines(head, rows)), *summary]


def _speeds(found: MeasuredComparison) -> list[str]:
    """Write the speed of each row."""
    unstated = np.isnan(found.measured.speed)
    pairs = zip(found.speed, unstated, strict=True)
    return ["any" if free and found.speed_independent else f"{v:.4g}" for v, free in pairs]


def _columns(agreement: Agreement, digits: int) -> list[list[str]]:
    """Write the columns of means, or of spreads, in the order of `_HEAD`."""
    columns = (
        (agreement.measured, digits),
        (agreement.simulated, digits),
        (agreement.simulated_error, digits + 1),
        (agreement.deviation, digits),
        (agreement.in_errors, 1),
    )
    return [
        ["-" if math.isnan(value) else f"{value:.{places}f}" for value in values]
        for values, places in columns
    ]


def comparison_json(found: MeasuredComparison) -> str:
    """Write everything as JSON; null: not measured, undefined or unknown."""
    summary = {
        name: {
            f"{part}_{measure}_deviation": getattr(agreements[name], measure)
            for part, agreements in (("mean", found.means), ("spread", found.spreads))
            for measure in ("rms", "largest")
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


def _row(found: MeasuredComparison, row: int) -> dict[str, Any]:
    """Collect the numbers of a row."""
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


def _agreement_at(agreement: Agreement, row: int) -> dict[str, float | None]:
    """Collect the numbers of a mean, or of a spread."""
    return {
        "measured": _number(agreement.measured[row]),
        "measured_error": _number(agreement.measured_error[row]),
        "simulated": _number(agreement.simulated[row]),
        "simulated_error": _number(agreement.simulated_error[row]),
        "deviation": _number(agreement.deviation[row]),
        "deviation_over_error": _number(agreement.in_errors[row]),
    }


def _number(value: float) -> float | None:
    """Turn NaN into None."""
    return None if math.isnan(value) else float(value)
