"""Codes of rows: what a table covers, and which rows are refused, or counted and warned of."""

import math
import re
import threading
import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler import errors
from sampler.arguments import Call, shown_apart
from sampler.errors import CODES, FLAGS, InputError, OutsideTableWarning
from sampler.formats.bounds import ANY_SPEED
from sampler.library import Report

Ends = tuple[float, float]

#: Arguments that may be to blame for an error, and what is allowed of them, by its code.
_ALLOWED = {
    code.number: dict(re.findall(r"(\w+): allowed: ([^;]*)", code.text)) for code in CODES
} | {errors.GRAIN_NOT_KNOWN: {"grain": "a shape code and ratios that the table was made for"}}


class Covered(NamedTuple):
    """What a table covers; in words, by `str`.

    The speed of a particle that spins is the one that it would have if all of its kinetic energy
    were translation, V (1 + k spin^2)^(1/2).
    """

    #: Impact angles, degrees, of fresh grains that arrive without spin, from the law of first
    #: impacts, and speeds, m/s; None: any.
    alpha_deg: Ends
    speed: Ends | None
    #: Sizes of the spin before the impact times a/V; None: there is no spin law.
    spin: Ends | None
    #: Speeds at which the law of the pair was measured, m/s; None: it holds at any.
    measured: Ends | None
    #: Impact angles, degrees, of all other draws, from the spin law; None: as `alpha_deg`.
    spin_alpha_deg: Ends | None = None

    @classmethod
    def of(
        cls, ends: dict[str, Ends], has_spin: bool, spin_alpha_deg: Ends | None = None
    ) -> "Covered":
        """Make it of what ``rbt_covered`` gives, without the rounding of units."""
        low, high = (round(math.degrees(end), 12) for end in ends["alpha1"])
        speed, measured = (
            None if ends[name][1] >= ANY_SPEED[1] else ends[name] for name in ("speed", "measured")
        )
        least, most = ends["spin"]
        spin = (round(least, 9), round(most, 9)) if has_spin else None
        other = spin_alpha_deg if spin_alpha_deg != (low, high) else None
        return cls((low, high), speed, spin, measured, other)

    def __str__(self) -> str:
        low, high = self.alpha_deg
        parts = [f"{low:g} to {high:g} deg" if low > 0.0 else "any angle"]
        if self.spin_alpha_deg is not None:
            others = f"{_to(self.spin_alpha_deg)} deg"
            parts = [f"{others} (fresh grains without spin: {parts[0]})"]
        parts += ["any speed" if self.speed is None else f"{_to(self.speed)} m/s"]
        if self.spin is not None:
            parts += [f"spin {_to(self.spin)}" if self.spin[1] < 1e9 else "any spin"]
        return ", ".join(parts).replace("spin 0 to", "spin to")


def _to(ends: Ends) -> str:
    return f"{ends[0]:g} to {ends[1]:g}"


class Counts:
    """Numbers of draws with each kind of flag; a copy begins anew."""

    def __init__(self) -> None:
        self.by_kind = dict.fromkeys(FLAGS, 0)
        self._lock = threading.Lock()

    def add(self, numbers: dict[str, int]) -> list[str]:
        """Add numbers, from any thread; tell which kinds were met for the first time."""
        with self._lock:
            new = [kind for kind, number in numbers.items() if number and not self.by_kind[kind]]
            for kind, number in numbers.items():
                self.by_kind[kind] += number
        return new

    def __reduce__(self) -> tuple[type["Counts"], tuple[()]]:
        return Counts, ()


class Counting:
    """What `Table` and `DeviceTable` share: codes are refused, or counted and warned of."""

    outside: str
    pair: str
    covered: Covered
    _counts: Counts

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of draws so far: angle, speed or spin outside the table, extrapolated."""
        return dict(self._counts.by_kind)

    @property
    def extrapolated(self) -> int:
        """Number of draws so far at speeds at which the pair was not measured."""
        return self._counts.by_kind["extrapolated"]

    def _refused(self, report: Report) -> NDArray[np.bool_] | None:
        """Tell which rows have an error, or are outside where that is one; None: none has."""
        raises = self.outside == "raise" and any(report.counts[:3])
        if report.codes is None or not (report.bad or raises):
            return None
        refused: NDArray[np.bool_] = report.codes < 0
        return refused | ((report.codes & errors.OUTSIDE) != 0) if raises else refused

    def _refuse(self, call: Call, report: Report) -> None:
        """Raise the `InputError` of the first row of a call that is refused."""
        refused, codes = self._refused(report), report.codes
        if refused is not None and codes is not None:
            row = int(refused.argmax())
            if codes[row] < 0:
                raise InputError(row_message(call, row, int(codes[row])))
            raise InputError(self._outside(call, row, int(codes[row])))

    def _count(self, call: Call, report: Report, stacklevel: int) -> None:
        """Count the flags of rows without errors; warn of each kind once, at the line that drew."""
        if report.codes is None:
            return
        codes, numbers = report.codes, dict(zip(FLAGS, report.counts, strict=True))
        for kind in self._counts.add(numbers):
            row = int(((codes > 0) & ((codes & FLAGS[kind]) != 0)).argmax())
            rows = f"{numbers[kind]} of the rows of this call"
            if kind == "extrapolated":
                line = f"{self._extrapolated(call, row)} for {rows}"
            else:
                line = f"{self._outside(call, row, FLAGS[kind])}; {rows} took its nearest condition"
            line += "; table.counts goes on counting, without further warnings"
            warnings.warn(line, OutsideTableWarning, stacklevel=stacklevel)

    def _outside(self, call: Call, row: int, code: int) -> str:
        """Say that a row lies outside the table."""
        arrays, covered, allowed = call.rows.arrays, self.covered, str(self.covered)
        kind = next(kind for kind, flag in FLAGS.items() if code & flag)
        name = {"angle": "alpha1"}.get(kind, kind)
        if "velocity" in arrays:
            name = "omega" if kind == "spin" else "velocity"
        alpha1, speed, spin = _impact(call, row)
        angles = covered.alpha_deg + (covered.spin_alpha_deg or ())
        degrees = shown_apart(math.degrees(alpha1), *angles, digits=6)
        given = f"{degrees} deg, {shown_apart(speed, *covered.speed or (), digits=6)} m/s"
        if covered.spin is not None and not {"spin", "omega"}.isdisjoint(arrays):
            given += f", spin {shown_apart(spin, *covered.spin, digits=6)}"
            if kind == "speed":
                allowed += (
                    "; with a spin, V_e must not be below the least speed or above those of the "
                    "spin law: V_e is a speed with the energy of rotation, V (1 + k spin^2)^(1/2)"
                )
            if kind == "spin" and "inertia" in arrays and spin <= covered.spin[1]:
                inertia = float(call.at("inertia", row))
                return (
                    f"inertia: got {inertia:.6g} at {call.place(row)}, allowed: from the smallest "
                    "to the largest moment of inertia of the grain, over m a^2, or 0: not known"
                )
        if "roughness" in arrays:
            given += " or on a facet of its rough wall"
        return (
            f"{name}: got an impact at {given} at {call.place(row)}, allowed: {allowed}, the range "
            f"of the table {self.pair}"
        )

    def _extrapolated(self, call: Call, row: int) -> str:
        """Say that the law of the pair is extrapolated."""
        name = "velocity" if "velocity" in call.rows.arrays else "speed"
        measured = self.covered.measured or (0.0, ANY_SPEED[1])
        _, speed, spin = _impact(call, row)
        turning = f" and spin {spin:.6g}" if spin > 0.0 else ""
        return (
            f"{name}: got {speed:.6g} m/s{turning} at {call.place(row)}, but {self.pair} "
            f"was measured at {_to(measured)} m/s: extrapolated; how sure: docs/does-it-matter.md"
        )


def row_message(call: Call, row: int, code: int) -> str:
    """Write the message on a row with an error, of `Table.sample` or of `Table.rebound`."""
    arrays, allowed = call.rows.arrays, _ALLOWED[code]
    name = next((name for name in allowed if name in arrays), "")
    said = allowed.get(name, "")
    if code == errors.NOT_FINITE:
        given = {n: np.abs(call.at(n, row)).max() for n in arrays if n not in ("index", "hit")}
        bad = [n for n, size in given.items() if not np.isfinite(size)]
        # else each number is finite; a square is not
        name = bad[0] if bad else max(given, key=given.__getitem__)
        said = "finite numbers" if bad else "speeds and spins times a/V below 1e150"
        if not bad and "inertia" in arrays and call.at("inertia", row) < 0.0:
            name, said = "inertia", "0, not known, or more"
    elif not name:
        text = next(each.text for each in CODES if each.number == code)
        return f"{text}, at {call.place(row)}"
    numbers = np.atleast_1d(call.at(name, row))
    values = ", ".join(shown_apart(float(x), math.pi / 2.0) for x in numbers)
    return f"{name}: got {values} at {call.place(row)}, allowed: {said}"


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
