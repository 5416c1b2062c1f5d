"""Act on the codes of rows: refuse rows, or count flags and warn."""

import math
import threading
import warnings
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sampler import errors
from sampler.arguments import Call, text_beside
from sampler.covered import Covered, ends_text
from sampler.errors import CODES, FLAGS, InputError, OutsideTableWarning
from sampler.formats.bounds import ANY_SPEED
from sampler.library import Report

#: Half-size [m] above which one warning asks for the unit: it is nearly always micrometres.
_LARGE = 0.1

_CODES = {code.number: code for code in CODES}


class RowCodes:
    """The part of a table that refuses rows by their codes, or counts them and warns.

    A copy counts from zero.

    Parameters
    ----------
    pair : str
        Name of the material pair.
    covered : Covered
    outside : {"clamp", "raise"}
        As of `sampler.Table`.

    Attributes
    ----------
    counts : dict of int
        Numbers of draws so far, by the kinds of `sampler.errors.FLAGS`.
    warns : bool
        Whether the first draw of each kind gives a warning.
    """

    def __init__(self, pair: str, covered: Covered, outside: Literal["clamp", "raise"]) -> None:
        self.pair, self.covered, self.outside = pair, covered, outside
        self.counts, self.warns = dict.fromkeys(FLAGS, 0), True
        self._warned_of_size = False
        self._lock = threading.Lock()

    def __reduce__(self) -> tuple[type["RowCodes"], tuple[str, Covered, str]]:
        return RowCodes, (self.pair, self.covered, self.outside)

    def refused_rows(self, report: Report) -> NDArray[np.bool_] | None:
        """Return which rows have an error, or are outside where that is one; None if none has."""
        raises = self.outside == "raise" and any(report.counts[:3])
        if report.codes is None or not (report.bad or raises):
            return None
        refused: NDArray[np.bool_] = report.codes < 0
        return refused | ((report.codes & errors.OUTSIDE) != 0) if raises else refused

    def refuse(self, call: Call, report: Report) -> None:
        """Raise the `InputError` of the first row of a call that is refused, if any is."""
        refused, codes = self.refused_rows(report), report.codes
        if refused is not None and codes is not None:
            row = int(refused.argmax())
            code = int(codes[row])
            raise row_refusal(call, row, code) if code < 0 else self._outside(call, row, code)

    def count(self, call: Call, report: Report, stacklevel: int) -> None:
        """Count the flags of rows without errors; warn of each kind once, at the line that drew."""
        self._warn_of_size(call, stacklevel + 1)
        if report.codes is None:
            return
        codes, numbers = report.codes, dict(zip(FLAGS, report.counts, strict=True))
        for kind in self._add(numbers):
            row = int(((codes > 0) & ((codes & FLAGS[kind]) != 0)).argmax())
            if FLAGS[kind] & errors.OUTSIDE:
                first = self._outside(call, row, FLAGS[kind])
            elif kind == "extrapolated":
                first = self._extrapolated(call, row)
            else:
                first = call.refusal(row, kind, problem=_CODES[FLAGS[kind]].text)
            warnings.warn(OutsideTableWarning(first, numbers[kind], kind), stacklevel=stacklevel)

    def _warn_of_size(self, call: Call, stacklevel: int) -> None:
        """Warn once of half-sizes that are probably not in metres."""
        sizes = call.rows.arrays.get("half_size")
        if sizes is None or self._warned_of_size or not (sizes > _LARGE).any():
            return
        self._warned_of_size = True
        row = int((sizes > _LARGE).argmax())
        problem = f"{float(sizes[row]):.6g} m is very large"
        remedy = "give metres: 20 micrometres are 20e-6"
        warnings.warn(
            str(call.refusal(row, "half_size", problem=problem).replaced(remedy=remedy)),
            stacklevel=stacklevel,
        )

    def _add(self, numbers: dict[str, int]) -> list[str]:
        """Add numbers, from any thread; return the kinds that were met for the first time."""
        with self._lock:
            new = [kind for kind, number in numbers.items() if number and not self.counts[kind]]
            for kind, number in numbers.items():
                self.counts[kind] += number
        return new if self.warns else []

    def _outside(self, call: Call, row: int, code: int) -> InputError:
        """Make the error of a row that lies outside the table."""
        arrays, covered, allowed = call.rows.arrays, self.covered, str(self.covered)
        kind = next(kind for kind, flag in FLAGS.items() if code & flag)
        name = {"angle": "alpha1"}.get(kind, kind)
        if "velocity" in arrays:
            name = "omega" if kind == "spin" else "velocity"
        alpha1, speed, spin = _impact(call, row)
        angles = covered.alpha_deg + (covered.spin_alpha_deg or ())
        degrees = text_beside(math.degrees(alpha1), *angles, digits=6)
        given = f"{degrees} deg, {text_beside(speed, *covered.speed or (), digits=6)} m/s"
        if covered.spin is not None and not {"spin", "omega"}.isdisjoint(arrays):
            given += f", spin {text_beside(spin, *covered.spin, digits=6)}"
            if kind == "speed":
                allowed += " (a particle that spins counts as having V (1 + k spin^2)^(1/2))"
            if kind == "spin" and "inertia" in arrays and spin <= covered.spin[1]:
                inertia = f"{float(call.at('inertia', row)):.6g}"
                return call.refusal(
                    row,
                    "inertia",
                    inertia,
                    "from the smallest to the largest moment of inertia of the grain, over m a^2, "
                    "or 0 if it is not known",
                )
        if kind == "speed" and covered.speed is None:
            allowed = f"speeds from {ends_text(ANY_SPEED)} m/s"
        if "roughness" in arrays:
            given += " or on a facet of its rough wall"
        allowed += f", the range of the table {self.pair}"
        return call.refusal(row, name, f"an impact at {given}", allowed)

    def _extrapolated(self, call: Call, row: int) -> InputError:
        """Make the message on a row at a speed at which the pair was not measured."""
        name = "velocity" if "velocity" in call.rows.arrays else "speed"
        measured = self.covered.measured or (0.0, ANY_SPEED[1])
        _, speed, spin = _impact(call, row)
        turning = f" and spin {spin:.6g}" if spin > 0.0 else ""
        problem = (
            f"where the law of {self.pair} is extrapolated: it was measured at "
            f"{ends_text(measured)} m/s"
        )
        return call.refusal(row, name, f"{speed:.6g} m/s{turning}", problem=problem)


def row_refusal(call: Call, row: int, code: int) -> InputError:
    """Make the error of a row with a negative code, of a draw or a rebound."""
    arrays = call.rows.arrays
    if code == errors.NOT_FINITE:
        name, allowed = _not_finite(call, row)
    else:
        all_allowed = _CODES[code].allowed
        name = next((name for name in all_allowed if name in arrays), "")
        if not name:
            return call.refusal(row, "", problem=_CODES[code].text)
        allowed = all_allowed[name]
    numbers = np.atleast_1d(call.at(name, row))
    values = ", ".join(text_beside(float(x), math.pi / 2.0) for x in numbers)
    return call.refusal(row, name, values, allowed)


def _not_finite(call: Call, row: int) -> tuple[str, str]:
    """Find the argument of a row that is not finite, or too large; return what is allowed."""
    arrays = call.rows.arrays
    sizes = {n: np.abs(call.at(n, row)).max() for n in arrays if n not in ("index", "hit")}
    for name, size in sizes.items():
        if not np.isfinite(size):
            return name, "finite numbers"
    if "inertia" in arrays and call.at("inertia", row) < 0.0:
        return "inertia", "0, if it is not known, or more"
    # each number is finite; a square is not
    return max(sizes, key=sizes.__getitem__), "speeds and spins times a/V below 1e150"


def _impact(call: Call, row: int) -> tuple[float, float, float]:
    """Compute impact angle (rad), speed (m/s) and size of the spin of a row, on the mean wall."""
    arrays = call.rows.arrays
    if "velocity" not in arrays:
        spin = call.at("spin", row) if "spin" in arrays else np.zeros(3)
        return float(call.at("alpha1", row)), float(call.at("speed", row)), math.hypot(*spin)
    wall = call.at("wall_velocity", row) if "wall_velocity" in arrays else 0.0
    relative, normal = call.at("velocity", row) - wall, call.at("normal", row)
    normal = normal / np.abs(normal).max()
    normal = normal / np.linalg.norm(normal)
    approach, speed = -float(relative @ normal), math.hypot(*relative)
    tangential = float(np.linalg.norm(relative + approach * normal))
    omega = call.at("omega", row) if "omega" in arrays else np.zeros(3)
    spin_size = math.hypot(*omega) * float(call.at("half_size", row)) / speed
    return math.atan2(approach, tangential), speed, spin_size
