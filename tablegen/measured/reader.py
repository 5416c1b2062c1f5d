"""Reader of files of measured rebounds, which tables/MEASUREMENTS.md describes.

A file that cannot be used is refused with one line that names file, line and column.
"""

import csv
import math
import os
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from sampler.errors import InputError
from sampler.files import commented_fields, find_measurements, parse_number
from sampler.limits import Bounds
from tablegen.config.complaints import shown
from tablegen.config.config import read_text
from tablegen.measured.measurements import QUANTITIES, SPREAD, Measurements, Moments
from tablegen.model.model_bounds import ALPHA_DEG, SPEED

#: Columns of numbers and of texts.
NUMBERS = ("alpha_deg", "speed", *(q + end for q in QUANTITIES for end in ("", SPREAD)), "count")
TEXTS = ("source", "remarks")
COLUMNS = (*NUMBERS, *TEXTS)

#: Columns that a file must have, with a value in every row.
REQUIRED = ("alpha_deg", "source")

_MOST_ROWS = 10_000

#: Quantity whose spread may stand without its mean.
_OUT = "out_of_plane_deg"

#: Largest omega_z a/V: the energy of the impact spins a fibre of b/a = 0.1 by 16.
_MOST_SPIN = 20.0

#: Restitutions may exceed their bound by this part, because published digits are rounded.
_ROUNDING = 1e-3

#: A right angle, rounded up, in radians.
_RIGHT_ANGLE = 1.571

#: Separators that some programs write in place of commas; tabs were read as spaces.
_OTHER_SEPARATORS = {";": "semicolons", " ": "tabs or spaces"}


class _Line(NamedTuple):
    """Cells of a line."""

    file: str
    number: int
    cells: Sequence[str]
    #: Names of the columns.
    columns: Sequence[str] = ()

    def cell(self, column: str) -> str:
        """Give the cell of a column; empty if there is none."""
        return dict(zip(self.columns, self.cells, strict=True)).get(column, "")

    def refusal(self, given: str, allowed: str, column: str = "") -> InputError:
        """Make the error of a line with a wrong value, or of one cell."""
        place = f"line {self.number}" + (f", {column}" if column else "")
        return InputError(place, given, allowed, source=self.file)

    def lack(self, problem: str, remedy: str, column: str = "") -> InputError:
        """Make the error of a line, or of one cell, in which something is missing."""
        place = f"line {self.number}" + (f", {column}" if column else "")
        return InputError(place, problem=problem, remedy=remedy, source=self.file)


def read_measurements(name_or_path: str | os.PathLike[str]) -> Measurements:
    """Read measured rebounds.

    Parameters
    ----------
    name_or_path : str or path-like
        Name that comes with the package, such as "grant-tabakoff-1975", or path of a file.

    Returns
    -------
    Measurements

    Raises
    ------
    InputError
        If there is no such file or name, or if the file cannot be used. The message names the file,
        the line and the column.

    Notes
    -----
    tables/MEASUREMENTS.md describes the file.

    Examples
    --------
    >>> from tablegen import read_measurements
    >>> data = read_measurements("grant-tabakoff-1975")
    >>> data.alpha_deg.size, float(data.moments["e_n"].mean[0])
    (9, 0.7307)
    """
    path = find_measurements(name_or_path)
    return parse_measurements(read_text(path), path.stem, path.name)


def parse_measurements(text: str, name: str, file: str) -> Measurements:
    """Read measured rebounds from the text of a file, whose name is for error messages."""
    lines = _lines(text, file)
    if not lines:
        problem, remedy = "has no line but comments", "begin with a line of column names"
        raise InputError("", problem=problem, remedy=remedy, source=file)
    lines = _without_empty_ends(lines)
    _check_columns(lines[0])
    rows = [line._replace(columns=lines[0].cells) for line in lines[1:]]
    if not 0 < len(rows) <= _MOST_ROWS:
        raise InputError("", f"{len(rows)} rows", f"1 to {_MOST_ROWS}", source=file)
    numbers = [_numbers_of_row(row) for row in rows]
    _check_degrees(rows, numbers)
    _check_unique(rows, numbers)
    arrays = {column: np.array([values[column] for values in numbers]) for column in NUMBERS}
    texts = {column: tuple(row.cell(column) for row in rows) for column in TEXTS}
    return Measurements(
        name=name,
        alpha_deg=arrays["alpha_deg"],
        speed=arrays["speed"],
        moments={q: Moments(arrays[q], arrays[q + SPREAD]) for q in QUANTITIES},
        count=arrays["count"],
        source=texts["source"],
        remarks=texts["remarks"],
        about=commented_fields(text),
    )


def _lines(text: str, file: str) -> list[_Line]:
    """Split the header and the rows into cells; a quoted cell may span several lines.

    Comments stand above the header. Below it a line that begins with # may be a row.
    """
    cells_of = list[_Line]()
    lines = enumerate((f"{line}\n" for line in text.split("\n")), start=1)
    for number, line in lines:
        # Excel writes empty rows as commas, and quotes a comment that holds a comma.
        if not line.strip(" \t,\n"):
            continue
        if line.lstrip().startswith(("#", '"#')):
            if not cells_of:
                continue
            remedy = "delete it, or move a comment above the names of the columns"
            raise _Line(file, number, ()).lack("a row begins with #", remedy)
        rest = chain([line], (further for _, further in lines))
        try:
            cells = next(csv.reader(rest, strict=True, skipinitialspace=True))
        except csv.Error as error:
            remedy = "put commas between cells, and quotes around a cell that holds a comma"
            raise _Line(file, number, ()).lack(str(error), remedy) from None
        cells_of.append(_Line(file, number, [" ".join(cell.split()) for cell in cells]))
    return cells_of


def _without_empty_ends(lines: Sequence[_Line]) -> list[_Line]:
    """Leave out the empty cells after the named columns, which Excel writes as trailing commas."""
    names = list(lines[0].cells)
    while names and not names[-1]:
        names.pop()
    kept = []
    for line in lines:
        cells = list(line.cells)
        while len(cells) > len(names) and not cells[-1]:
            cells.pop()
        kept.append(line._replace(cells=cells))
    return kept


def _check_columns(header: _Line) -> None:
    names, one_of = header.cells, f"one of {', '.join(QUANTITIES)} at least"
    for separator, words in _OTHER_SEPARATORS.items():
        if len(names) == 1 and separator in names[0]:
            raise header.refusal(f"{words} between columns", "commas")
    for k, column in enumerate(names):
        if column not in COLUMNS:
            raise header.refusal(f"column {shown(column)}", ", ".join(COLUMNS))
        if column in names[:k]:
            raise header.refusal(f"column {shown(column)} twice", "each column once")
    for column in REQUIRED:
        if column not in names:
            remedy = f"give {', '.join(REQUIRED)} and {one_of}"
            raise header.lack(f"column {shown(column)} is missing", remedy)
    if not set(QUANTITIES) & set(names):
        raise header.lack("there is no measured quantity", f"give {one_of}")


def _numbers_of_row(row: _Line) -> dict[str, float]:
    """Read and check the numbers of a row; NaN for an empty cell."""
    if len(row.cells) != len(row.columns):
        raise row.refusal(f"{len(row.cells)} cells", f"{len(row.columns)}, one for each column")
    for column in REQUIRED:
        if not row.cell(column):
            raise row.lack("the cell is empty", "give a value in every row", column)
    values = {column: _number(row, column) for column in NUMBERS}
    if math.isnan(values[_OUT]) and not math.isnan(values[_OUT + SPREAD]):
        values[_OUT] = 0.0  # by symmetry: few measure this mean
    for column, value in values.items():
        if math.isnan(value):
            continue
        given, quantity = row.cell(column), column.removesuffix(SPREAD)
        if quantity == "e_t" and values["alpha_deg"] == 90.0:
            raise row.refusal(given, "an empty cell at 90 degrees", column)
        allowed = _bounds(column, values["alpha_deg"])
        if not allowed.low <= value <= allowed.high or (column == "count" and value % 1.0):
            raise row.refusal(given, allowed.words, column)
        if math.isnan(values.get(quantity, 0.0)):
            raise row.refusal(given, f"a spread beside its mean only; give {quantity}", column)
    if all(math.isnan(values[quantity]) for quantity in QUANTITIES):
        remedy = f"give a value for one of {', '.join(QUANTITIES)} at least"
        raise row.lack("there is no measured quantity", remedy)
    return values


def _check_degrees(rows: Sequence[_Line], numbers: Sequence[Mapping[str, float]]) -> None:
    """Refuse angles that are all within a right angle in radians, if there are several."""
    angles = {values["alpha_deg"] for values in numbers}
    if len(angles) > 1 and max(angles) <= _RIGHT_ANGLE:
        given = f"angles up to {max(angles):g}, which look like radians"
        raise rows[0].refusal(given, "degrees from the wall", "alpha_deg")


def _number(row: _Line, column: str) -> float:
    """Read the number of a cell; NaN if it is empty."""
    cell = row.cell(column)
    if not cell:
        return math.nan
    value = parse_number(cell)
    if not math.isfinite(value):
        raise row.refusal(shown(cell), "a number, or an empty cell", column)
    return value


def _hinted(low: float, high: float, hint: str) -> Bounds:
    return Bounds(low, high, text=f"{low:.4g} to {high:.4g} ({hint})")


def _bounds(column: str, alpha_deg: float) -> Bounds:
    """Find the values that a column may hold at an impact angle [degrees]."""
    if column == "alpha_deg":
        return _hinted(ALPHA_DEG.low, ALPHA_DEG.high, "degrees from the wall")
    if column == "speed":
        return _hinted(SPEED.low, SPEED.high, "m/s")
    if column == "count":
        return _hinted(1.0, 1e9, "a whole number of particles")
    quantity = column.removesuffix(SPREAD)
    angle, hint = math.radians(alpha_deg), "degrees"
    if quantity in ("e_n", "e_t"):
        # all the energy of the impact in one component
        high = (1.0 + _ROUNDING) / (math.sin(angle) if quantity == "e_n" else math.cos(angle))
        low = 0.0 if quantity == "e_n" else -high
        hint = f"at {alpha_deg:g} degrees from the wall; a fraction, not per cent"
    elif quantity == "omega_z":
        low, high, hint = -_MOST_SPIN, _MOST_SPIN, "times a/V, not rad/s"
    else:
        low, high = (0.0, 180.0) if quantity == "rebound_angle_deg" else (-90.0, 90.0)
    if column == quantity:
        return _hinted(low, high, hint)
    return _hinted(0.0, 0.5 * (high - low), hint)


def _check_unique(rows: Sequence[_Line], numbers: Sequence[Mapping[str, float]]) -> None:
    """Refuse two values of one quantity at the same angle and speed."""
    seen: dict[tuple[str, float, float | None], int] = {}
    for row, values in zip(rows, numbers, strict=True):
        alpha_deg = values["alpha_deg"]
        speed = None if math.isnan(values["speed"]) else values["speed"]
        for quantity in QUANTITIES:
            if math.isnan(values[quantity]):
                continue
            place = (quantity, round(alpha_deg, 6), speed and float(f"{speed:.9g}"))
            first = seen.setdefault(place, row.number)
            if first != row.number:
                at = f"{alpha_deg:g} degrees" + ("" if speed is None else f" and {speed:g} m/s")
                only = f"that of line {first} only"
                raise row.refusal(f"a second value at {at}", only, quantity)
