"""Messages on a row that a batch kernel could not use: field, value, row, what is allowed.

A kernel reports a row and a code. Which argument is to blame is found here, from the arguments of
that row.
"""

import math
from typing import Any

import numpy as np

from sampler.arguments import MAX_ROUGHNESS, Rows, place, told_apart
from sampler.drawing.condition_status import is_outside
from sampler.errors import (
    CASCADE_NOT_ENDED,
    HALF_SIZE_NOT_POSITIVE,
    NORMAL_NOT_USABLE,
    NOT_APPROACHING,
    NOT_FINITE,
    ROUGHNESS_NOT_USABLE,
    SPEED_NOT_POSITIVE,
    TILT_NOT_FOUND,
)
from sampler.formats.bounds import INERTIA, SpinArrays, TableArrays
from sampler.formats.spin_buffer import law_in

_LEAVES = "one that lets the particle leave the wall"

#: Argument to blame for a code and what is allowed, for conditions and for impacts.
_CONDITIONS = {
    NOT_APPROACHING: ("alpha1", f"above 0, at most pi/2 rad, {math.pi / 2.0}"),
    SPEED_NOT_POSITIVE: ("speed", "above 0 m/s"),
}
_IMPACTS = {
    NOT_APPROACHING: ("velocity", "towards the wall, (velocity - wall_velocity) . normal < 0"),
    SPEED_NOT_POSITIVE: ("velocity", "1e-150 m/s or more relative to the wall"),
    NORMAL_NOT_USABLE: ("normal", "any length but zero"),
    HALF_SIZE_NOT_POSITIVE: ("half_size", "1e-30 m or more"),
    ROUGHNESS_NOT_USABLE: ("roughness", f"0 to {MAX_ROUGHNESS:g} rad"),
    TILT_NOT_FOUND: ("roughness", _LEAVES),
    CASCADE_NOT_ENDED: ("roughness", _LEAVES),
}


def _text(value: Any) -> str:
    return ", ".join(told_apart(float(x), math.pi / 2.0) for x in np.atleast_1d(value))


def row_message(rows: Rows, row: int, code: int) -> str:
    """Message on a row for which a batch kernel reported an error.

    Parameters
    ----------
    rows : Rows
        Arguments of `Table.sample` or of `Table.rebound`.
    row, code : int
        As the kernel reported them.
    """
    if code == NOT_FINITE:
        bad = (name for name in rows.values if not np.isfinite(rows.at(name, row)).all())
        name, allowed = next(bad, ""), "finite numbers"
        if not name:  # each number is finite; a square is not
            name, allowed = _too_large(rows, row)
    else:
        name, allowed = (_IMPACTS if "velocity" in rows.values else _CONDITIONS)[code]
    got = f"got {_text(rows.at(name, row))} at {place(row, rows.shape)}"
    return f"{name}: {got}, allowed: {allowed}"


def _too_large(rows: Rows, row: int) -> tuple[str, str]:
    """Argument whose square is no number any more, and what is allowed."""
    if "velocity" not in rows.values:
        return "spin", "a magnitude below 1e150, and of the speed too"
    relative = rows.at("velocity", row) - rows.at("wall_velocity", row)
    if "omega" in rows.values and math.hypot(*relative) < 1e150:
        return "omega", "a magnitude below 1e150 times V/a"
    return "velocity", "a magnitude below 1e150 m/s"


def _spin_squared(rows: Rows, row: int, speed: float) -> float:
    """Square of the spin times a/V of a row that has one."""
    if "spin" in rows.values:
        spin = rows.at("spin", row)
    else:
        spin = rows.at("omega", row) * (float(rows.at("half_size", row)) / speed)
    return float(spin @ spin)


def _outside_spin_law(law: SpinArrays, rows: Rows, row: int) -> tuple[str, float, Any, str]:
    """Find what lies outside of the spin law: name, value, ends and unit."""
    alpha1, speed = _condition(rows, row)
    if not law.alpha_low <= alpha1 <= law.alpha_high:
        return "alpha1", alpha1, (law.alpha_first, law.alpha_last), "rad"
    effective = speed * math.sqrt(1.0 + INERTIA * _spin_squared(rows, row, speed))
    ends = (law.speed_first, law.speed_last)
    if law.speed_low <= effective <= law.speed_high:
        return "", effective, ends, ""
    return "speed", effective, ends, "m/s of V (1 + 2/3 |spin|^2)^(1/2)"


def _outside_nodes(arrays: TableArrays, rows: Rows, row: int) -> tuple[str, float, Any, str]:
    """Find the same for the law of particles that arrive without spin."""
    alpha1, speed = _condition(rows, row)
    if is_outside(alpha1, arrays.alpha):
        return "alpha1", alpha1, (arrays.alpha.first, arrays.alpha.last), "rad"
    name = "speed" if is_outside(speed, arrays.speed) else ""
    return name, speed, (arrays.speed.first, arrays.speed.last), "m/s"


def _condition(rows: Rows, row: int) -> tuple[float, float]:
    """Impact angle (rad) and speed (m/s) of a row."""
    if "velocity" not in rows.values:
        return float(rows.at("alpha1", row)), float(rows.at("speed", row))
    relative = rows.at("velocity", row) - rows.at("wall_velocity", row)
    normal = rows.at("normal", row)
    normal = normal / np.abs(normal).max()
    normal = normal / np.linalg.norm(normal)
    approach = -float(relative @ normal)
    tangential = float(np.linalg.norm(relative + approach * normal))
    return math.atan2(approach, tangential), math.hypot(*relative)


def outside_message(arrays: TableArrays, rows: Rows, row: int) -> str:
    """Message on a row whose condition lies outside the table."""
    at = place(row, rows.shape)
    if "spin" in rows.values or "omega" in rows.values:
        name, value, ends, unit = _outside_spin_law(law_in(arrays), rows, row)
    else:
        name, value, ends, unit = _outside_nodes(arrays, rows, row)
    if not name:
        return (
            f"roughness: got a facet or a further bounce outside of the table at {at}, "
            "allowed: none with outside='raise'"
        )
    return (
        f"{name}: got {told_apart(value, *ends)} at {at}, allowed: "
        f"from {ends[0]:.9g} to {ends[1]:.9g} {unit}, the range of the table"
    )


def outside_warning(arrays: TableArrays, rows: Rows, row: int, clamped: int) -> str:
    """Message on the first draws of a table that were moved to its edge.

    Parameters
    ----------
    arrays, rows, row
        As for `outside_message`, of the first of them.
    clamped : int
        How many of the call they are.
    """
    return (
        f"{outside_message(arrays, rows, row)}; {clamped} draw{'s' * (clamped > 1)} of this "
        "call took the nearest condition of the table instead. table.clamped goes on counting, "
        "without further warnings"
    )
