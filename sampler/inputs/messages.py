"""Messages on a row that a batch kernel could not use: field, value, row, what is allowed.

A kernel reports a row and a code. Which argument is to blame is found here, from the arguments of
that row.
"""

import math
from typing import Any

import numpy as np

from sampler.drawing.condition_status import is_outside
from sampler.errors import (
    CASCADE_NOT_ENDED,
    HALF_SIZE_NOT_POSITIVE,
    NORMAL_NOT_USABLE,
    NOT_APPROACHING,
    NOT_FINITE,
    SPEED_NOT_POSITIVE,
    TILT_NOT_FOUND,
)
from sampler.formats.table_arrays import TableArrays
from sampler.inputs.rows import Rows, place
from sampler.inputs.told_apart import told_apart

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
        if not name:  # each number is finite; the square of the velocity is not
            name, allowed = "velocity", "a magnitude below 1e150 m/s"
    else:
        name, allowed = (_IMPACTS if "velocity" in rows.values else _CONDITIONS)[code]
    got = f"got {_text(rows.at(name, row))} at {place(row, rows.shape)}"
    return f"{name}: {got}, allowed: {allowed}"


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
    alpha1, speed = _condition(rows, row)
    at = place(row, rows.shape)
    if is_outside(alpha1, arrays.alpha):
        name, value, axis, unit = "alpha1", alpha1, arrays.alpha, "rad"
    elif is_outside(speed, arrays.speed):
        name, value, axis, unit = "speed", speed, arrays.speed, "m/s"
    else:
        return (
            f"roughness: got a facet or a further bounce outside of the table at {at}, "
            "allowed: none with outside='raise'"
        )
    return (
        f"{name}: got {told_apart(value, axis.first, axis.last)} at {at}, allowed: "
        f"from {axis.first:.9g} to {axis.last:.9g} {unit}, the range of the table"
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
