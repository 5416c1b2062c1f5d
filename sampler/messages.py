"""Rows that a batch refused or moved to the edge of the table: their messages and their number.

A batch reports a row and a code. The argument to blame is found from the arguments of the row.
"""

import math
import threading
import warnings
from typing import Any

import numpy as np

from sampler import errors
from sampler.arguments import MAX_ROUGHNESS, Call, told_apart
from sampler.errors import InputError, OutsideTableWarning
from sampler.formats.binary_layout import SPEED_INDEPENDENT
from sampler.formats.bounds import ANY_SPEED, INERTIA, LEAST_RATIO, ROUNDING
from sampler.library import Report

_LEAVES = "one that lets the particle leave the wall"

#: Argument to blame for a code and the allowed values, for conditions and for impacts.
_CONDITIONS = {
    errors.NOT_APPROACHING: ("alpha1", f"above 0, at most pi/2 rad, {math.pi / 2.0}"),
    errors.SPEED_NOT_POSITIVE: ("speed", "above 0 m/s"),
    errors.GRAIN_NOT_KNOWN: (
        "grain",
        f"a shape code of the population, and b/a and c/b from {LEAST_RATIO:g} to 1",
    ),
}
_IMPACTS = _CONDITIONS | {
    errors.NOT_APPROACHING: (
        "velocity",
        "towards the wall, (velocity - wall_velocity) . normal < 0",
    ),
    errors.SPEED_NOT_POSITIVE: ("velocity", "1e-150 m/s or more relative to the wall"),
    errors.NORMAL_NOT_USABLE: ("normal", "any length but zero"),
    errors.HALF_SIZE_NOT_POSITIVE: ("half_size", "1e-30 m or more"),
    errors.ROUGHNESS_NOT_USABLE: ("roughness", f"0 to {MAX_ROUGHNESS:g} rad"),
    errors.TILT_NOT_FOUND: ("roughness", _LEAVES),
    errors.CASCADE_NOT_ENDED: ("roughness", _LEAVES),
}


class Counts:
    """Numbers of draws outside a table, and of draws that extrapolate its laws."""

    def __init__(self) -> None:
        self.clamped = self.extrapolated = 0
        self._lock = threading.Lock()

    def add(self, clamped: int, extrapolated: int) -> bool:
        """Add to the counts, from any thread; tell whether the first clamped draw is among them."""
        with self._lock:
            first = self.clamped == 0 and clamped > 0
            self.clamped += clamped
            self.extrapolated += extrapolated
        return first

    def __reduce__(self) -> tuple[type["Counts"], tuple[()]]:
        return Counts, ()


class Counting:
    """The part that `Table` and `DeviceTable` share: bad rows are refused, clamped ones counted."""

    outside: str
    _counts: Counts

    @property
    def clamped(self) -> int:
        """Number of draws so far that lay outside the table, in angle, speed or spin."""
        return self._counts.clamped

    @property
    def extrapolated(self) -> int:
        """Number of draws so far with an impact speed outside the file's ``valid_speed``."""
        return self._counts.extrapolated

    def _finish(self, header: Any, call: Call, report: Report, stacklevel: int) -> None:
        """Refuse the first bad row of a call, or count its rows outside the table."""
        clamped, bad = report.clamped_row, report.bad_row
        if clamped >= 0 and self.outside == "raise" and not 0 <= bad < clamped:
            raise InputError(outside_message(header, call, clamped))
        if bad >= 0:
            raise InputError(row_message(call, bad, report.code))
        if self._counts.add(report.clamped, report.extrapolated):
            told = outside_warning(header, call, clamped, report.clamped)
            # of the line that drew
            warnings.warn(told, OutsideTableWarning, stacklevel=stacklevel)


def row_message(call: Call, row: int, code: int) -> str:
    """Write the message on a row that a batch refused.

    Parameters
    ----------
    call : Call
        Arguments of `Table.sample` or of `Table.rebound`.
    row, code : int
        As the batch reported them.
    """
    if code == errors.NOT_FINITE:
        bad = (name for name in call.rows.arrays if not np.isfinite(call.at(name, row)).all())
        name, allowed = next(bad, ""), "finite numbers"
        if not name:  # each number is finite; a square is not
            name, allowed = _too_large(call, row)
    else:
        name, allowed = (_IMPACTS if "velocity" in call.rows.arrays else _CONDITIONS)[code]
    given = ", ".join(
        told_apart(float(x), math.pi / 2.0) for x in np.atleast_1d(call.at(name, row))
    )
    return f"{name}: got {given} at {call.place(row)}, allowed: {allowed}"


def outside_message(header: Any, call: Call, row: int) -> str:
    """Write the message on a row that lies outside the table.

    Parameters
    ----------
    header : record
        Of the table's image.
    call, row
        As for `row_message`.
    """
    at = call.place(row)
    found = (_outside_spin_law if _spins(header, call) else _outside_nodes)(header, call, row)
    if found is None:
        return (
            f"roughness: got a facet or a further bounce outside of the table at {at}, "
            "allowed: none with outside='raise'"
        )
    name, value, (low, high), unit, note = found
    return (
        f"{name}: got {told_apart(value, low, high, digits=6)}{unit} at {at}, allowed: "
        f"{low:.6g} to {high:.6g}{unit}{note}, the range of the table {header['pair'].decode()}"
    )


def _spins(header: Any, call: Call) -> bool:
    """Tell whether a call draws from the spin law."""
    given = not {"spin", "omega", "grain"}.isdisjoint(call.rows.arrays)
    own = "velocity" in call.rows.arrays and header["n_shapes"] > 0 and not call.rows.fresh
    return bool(given or own)


def outside_warning(header: Any, call: Call, row: int, clamped: int) -> str:
    """Write the warning on the first draws outside of a table."""
    return (
        f"{outside_message(header, call, row)}; {clamped} draw{'s' * (clamped > 1)} of this "
        "call lay outside, and took the nearest angle and speed of the table. table.clamped goes "
        "on counting, without further warnings"
    )


def is_outside(value: float, ends: tuple[float, float]) -> bool:
    """Tell whether a value lies off an axis by more than the rounding of a unit conversion."""
    return not ends[0] * (1.0 - ROUNDING) <= value <= ends[1] * (1.0 + ROUNDING)


def speed_limits(header: Any) -> tuple[float, float]:
    """Give the speeds beyond which a condition is outside: any, if rebounds do not depend on it."""
    if header["flags"] & SPEED_INDEPENDENT:
        return ANY_SPEED
    return float(header["speed_first"]), float(header["speed_last"])


#: Argument, value, ends of the range, unit, and what the range is at.
_Outside = tuple[str, float, tuple[float, float], str, str]


def _outside_angle(call: Call, alpha1: float, ends: Any) -> _Outside | None:
    """Give the impact angle, in degrees, where it is outside of its range."""
    first, last = float(ends[0]), float(ends[1])
    if not is_outside(alpha1, (first, last)):
        return None
    # written as rounded as the unit's conversion is
    low, high = (float(f"{math.degrees(end):.12g}") for end in (first, last))
    if "velocity" in call.rows.arrays:
        return "velocity", math.degrees(alpha1), (low, high), " deg", " from the wall"
    return "alpha1", math.degrees(alpha1), (low, high), " deg", ""


def _speed_name(call: Call) -> str:
    return "velocity" if "velocity" in call.rows.arrays else "speed"


def _outside_nodes(header: Any, call: Call, row: int) -> _Outside | None:
    """Find what lies outside the law of first impacts."""
    alpha1, speed = _condition(call, row)
    speeds = speed_limits(header)
    found = _outside_angle(call, alpha1, (header["alpha_first"], header["alpha_last"]))
    if found is None and is_outside(speed, speeds):
        found = _speed_name(call), speed, speeds, " m/s", ""
    return found


def _outside_spin_law(header: Any, call: Call, row: int) -> _Outside | None:
    """Find what lies outside the spin law, of speeds V_e, in terms of what was given."""
    alpha1, speed = _condition(call, row)
    found = _outside_angle(call, alpha1, header["spin_alpha"])
    if found is not None:
        return found
    low, high = (float(x) for x in header["spin_speed"])
    size = math.sqrt(_spin_squared(call, row, speed))
    factor = math.sqrt(1.0 + INERTIA * size**2)
    per_spin = speed  # of the unit in which the spin was given
    if "velocity" in call.rows.arrays:
        per_spin = speed / float(call.at("half_size", row))
    least, most = (float(x) for x in header["spin_size"])
    if is_outside(size, (least, most)):
        if "spin" in call.rows.arrays:
            return "spin", size, (least, most), "", " in size"
        return "omega", size * per_spin, (least * per_spin, most * per_spin), " rad/s", ""
    if header["flags"] & SPEED_INDEPENDENT or not is_outside(speed * factor, (low, high)):
        return None
    if "omega" not in call.rows.arrays:
        note = " with this spin" if size > 0.0 else ""
        return _speed_name(call), speed, (low / factor, high / factor), " m/s", note
    turning = INERTIA * (size * speed) ** 2  # the part of V_e^2 that stays where V changes
    if turning > high**2:
        most = high / math.sqrt(INERTIA) / speed * per_spin
        return "omega", size * per_spin, (0.0, most), " rad/s", ""
    speeds = math.sqrt(max(low**2 - turning, 0.0)), math.sqrt(high**2 - turning)
    return "velocity", speed, speeds, " m/s", " with this angular velocity" * (size > 0.0)


def _condition(call: Call, row: int) -> tuple[float, float]:
    """Compute impact angle (rad) and speed (m/s) of a row."""
    if "velocity" not in call.rows.arrays:
        return float(call.at("alpha1", row)), float(call.at("speed", row))
    relative = _relative(call, row)
    normal = call.at("normal", row)
    normal = normal / np.abs(normal).max()
    normal = normal / np.linalg.norm(normal)
    approach = -float(relative @ normal)
    tangential = float(np.linalg.norm(relative + approach * normal))
    return math.atan2(approach, tangential), math.hypot(*relative)


def _relative(call: Call, row: int) -> Any:
    """Give the velocity relative to the wall."""
    wall = call.at("wall_velocity", row) if "wall_velocity" in call.rows.arrays else 0.0
    return call.at("velocity", row) - wall


def _too_large(call: Call, row: int) -> tuple[str, str]:
    """Find the argument whose square is no number any more, and the allowed values."""
    if "velocity" not in call.rows.arrays:
        return "spin", "a magnitude below 1e150, and of the speed too"
    if "omega" in call.rows.arrays and math.hypot(*_relative(call, row)) < 1e150:
        return "omega", "a magnitude below 1e150 times V/a"
    return "velocity", "a magnitude below 1e150 m/s"


def _spin_squared(call: Call, row: int, speed: float) -> float:
    """Compute the square of the spin times a/V of a row."""
    if "spin" in call.rows.arrays:
        spin = call.at("spin", row)
    elif "omega" in call.rows.arrays:
        spin = call.at("omega", row) * (float(call.at("half_size", row)) / speed)
    else:
        spin = np.zeros(3)
    return float(spin @ spin)
