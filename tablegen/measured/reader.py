"""Files of measured rebounds, checked; tables/MEASUREMENTS.md describes them.

A file that cannot be used is refused with one line that names file, line and column.
"""

import csv
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from sampler.errors import InputError
from sampler.files import commented_fields, find_measurements, read_file
from sampler.formats.bounds import is_line
from tablegen.config.messages import shown
from tablegen.measured.columns import COLUMNS, DEMANDED, NUMBERS, TEXTS, allowed
from tablegen.measured.records import QUANTITIES, SPREAD, Measurements, Moments

#: Most bytes and most rows of a file.
_MOST_BYTES = 2**22
_MOST_ROWS = 10_000

#: A number as people write one: float() would also take nan, infinity, 1_000 and other digits.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)

#: Separators that stand in some files for the comma.
_OTHERS = {";": "semicolons", "\t": "tabs"}


class _Line(NamedTuple):
    """Cells of a line, and its number in the file."""

    number: int
    cells: list[str]


class _Row(NamedTuple):
    """Cells of a row by column, and the place of the row for messages."""

    place: str
    cells: Mapping[str, str]

    def refuse(self, column: str, got: str, words: str) -> InputError:
        """Error of a cell."""
        return InputError(f"{self.place}, {column}: got {got}, allowed: {words}")


def read_measurements(name_or_path: str | os.PathLike[str]) -> Measurements:
    """Read measured rebounds.

    Parameters
    ----------
    name_or_path : str or path-like
        A name that comes with the package, such as "grant-tabakoff-1975", or the path of a file.

    Returns
    -------
    Measurements

    Raises
    ------
    InputError
        If there is no such file or name, or the file cannot be used: one line with the file, the
        line, the column, what was given and what is allowed.
    """
    path = find_measurements(name_or_path)
    data = read_file("measurements", path, _MOST_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path.name}: got byte {error.object[error.start]:#04x} at position {error.start}, "
            "allowed: UTF-8 text"
        ) from error
    return parse_measurements(text, path.stem, path.name)


def parse_measurements(text: str, name: str, origin: str) -> Measurements:
    """Read measured rebounds from the text of a file.

    Parameters
    ----------
    text : str
    name : str
        Of the measurements.
    origin : str
        Where the text comes from, to open every error message.

    Returns
    -------
    Measurements

    Raises
    ------
    InputError
        As for `read_measurements`.
    """
    text = re.sub("\r\n?", "\n", text)
    lines = list(_lines(text, origin))
    if not lines:
        raise InputError(f"{origin}: got no line but comments, allowed: a line of column names")
    columns = _columns(lines[0], origin)
    rows = [_row(line, columns, origin) for line in lines[1:]]
    if not 0 < len(rows) <= _MOST_ROWS:
        raise InputError(f"{origin}: got {len(rows)} rows, allowed: 1 to {_MOST_ROWS}")
    numbers = np.array([_numbers(row) for row in rows])
    of = {column: numbers[:, k] for k, column in enumerate(NUMBERS)}
    _check_unique(rows, of)
    texts = {column: tuple(row.cells.get(column, "") for row in rows) for column in TEXTS}
    return Measurements(
        name=name,
        alpha_deg=of["alpha_deg"],
        speed=of["speed"],
        moments={q: Moments(of[q], of[q + SPREAD]) for q in QUANTITIES},
        count=of["count"],
        source=texts["source"],
        remarks=texts["remarks"],
        about=commented_fields(text),
    )


def _lines(text: str, origin: str) -> Iterator[_Line]:
    """Lines with cells; a cell with a comma is quoted, and none goes over several lines."""
    for number, line in enumerate(text.split("\n"), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        place = f"{origin}: line {number}"
        if not is_line(line.replace("\t", " ")):
            allowed_there = "text without control characters"
            raise InputError(f"{place}: got {shown(line.strip())}, allowed: {allowed_there}")
        try:
            (cells,) = csv.reader([line], strict=True, skipinitialspace=True)
        except csv.Error as error:
            allowed_there = "cells with commas between them, quoted where they hold one"
            raise InputError(f"{place}: got {error}, allowed: {allowed_there}") from None
        yield _Line(number, [cell.strip() for cell in cells])


def _columns(header: _Line, origin: str) -> list[str]:
    """Column names of a file."""
    place = f"{origin}: line {header.number}"
    names = header.cells
    for separator, words in _OTHERS.items():
        if len(names) == 1 and separator in names[0]:
            raise InputError(f"{place}: got {words} between columns, allowed: commas")
    for k, column in enumerate(names):
        if column not in COLUMNS:
            words = ", ".join(COLUMNS)
            raise InputError(f"{place}: got column {shown(column)}, allowed: {words}")
        if column in names[:k]:
            raise InputError(f"{place}: got column {shown(column)} twice, allowed: once")
    for column in DEMANDED:
        if column not in names:
            words = f"{', '.join(DEMANDED)} and one of {', '.join(QUANTITIES)} at least"
            raise InputError(f"{place}: column {shown(column)} is missing, allowed: {words}")
    if not set(QUANTITIES) & set(names):
        words = f"one of {', '.join(QUANTITIES)} at least"
        raise InputError(f"{place}: got no measured quantity, allowed: {words}")
    return names


def _row(line: _Line, columns: Sequence[str], origin: str) -> _Row:
    place = f"{origin}: line {line.number}"
    if len(line.cells) != len(columns):
        raise InputError(f"{place}: got {len(line.cells)} cells, allowed: {len(columns)}")
    row = _Row(place, dict(zip(columns, line.cells, strict=True)))
    for column in DEMANDED:
        if not row.cells[column]:
            raise row.refuse(column, "an empty cell", "a value in every row")
    return row


def _numbers(row: _Row) -> list[float]:
    """Numbers of a row in the order of `NUMBERS`; NaN for an empty cell."""
    values = {column: _number(row, column) for column in NUMBERS}
    alpha_deg = values["alpha_deg"]
    for column, value in values.items():
        if math.isnan(value):
            continue
        quantity = column.removesuffix(SPREAD)
        if quantity == "e_t" and alpha_deg == 90.0:
            raise row.refuse(column, row.cells[column], "an empty cell at 90 degrees")
        range_ = allowed(column, alpha_deg)
        if not range_.holds(value) or (column == "count" and value != math.floor(value)):
            raise row.refuse(column, row.cells[column], range_.words)
        if math.isnan(values.get(quantity, 0.0)):
            raise row.refuse(column, row.cells[column], f"a spread beside its mean, {quantity}")
    if all(math.isnan(values[quantity]) for quantity in QUANTITIES):
        words = f"a value for one of {', '.join(QUANTITIES)} at least"
        raise InputError(f"{row.place}: got no measured quantity, allowed: {words}")
    return list(values.values())


def _number(row: _Row, column: str) -> float:
    cell = row.cells.get(column, "")
    if not cell:
        return math.nan
    if not _NUMBER.fullmatch(cell):
        raise row.refuse(column, shown(cell), "a number, or an empty cell")
    return float(cell)


def _check_unique(rows: Sequence[_Row], of: Mapping[str, np.ndarray]) -> None:
    """Refuse a quantity that is given twice at the same angle and speed."""
    seen: dict[tuple[str, float, float | None], str] = {}
    for k, row in enumerate(rows):
        speed = None if math.isnan(of["speed"][k]) else of["speed"][k]
        for quantity in QUANTITIES:
            key = quantity, of["alpha_deg"][k], speed
            if math.isnan(of[quantity][k]):
                continue
            if key in seen:
                at = f"{key[1]:g} degrees" + ("" if speed is None else f" and {speed:g} m/s")
                first = seen[key].rpartition(" ")[2]
                raise row.refuse(quantity, f"a second value at {at}", f"that of line {first} only")
            seen[key] = row.place
