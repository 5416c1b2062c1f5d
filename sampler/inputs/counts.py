"""How many draws of a table were clamped or extrapolated, and what is said of the first."""

import warnings

from sampler.arguments import Rows
from sampler.drawing.threads import Counter, Report
from sampler.errors import InputError, OutsideTableWarning
from sampler.formats.bounds import TableArrays
from sampler.messages import outside_message, outside_warning


class Counts:
    """Counts to which any thread may add; those of a copy are 0."""

    def __init__(self) -> None:
        self.clamped, self.extrapolated = Counter(), Counter()

    def add(
        self, arrays: TableArrays, rows: Rows, report: Report, outside: str, stacklevel: int
    ) -> None:
        """Count the draws of a call; with ``outside`` "raise" refuse the first that is outside.

        Warns of the first that was moved to the edge of the table, once a table.
        """
        if report.clamped and outside == "raise":
            raise InputError(outside_message(arrays, rows, report.clamped_row))
        self.extrapolated.add(report.extrapolated)
        if report.clamped and self.clamped.add(report.clamped):
            told = outside_warning(arrays, rows, report.clamped_row, report.clamped)
            # of the line that drew
            warnings.warn(told, OutsideTableWarning, stacklevel=stacklevel)


class Counting:
    """Properties of what draws: how many of its draws were clamped or extrapolated."""

    _counts: Counts

    @property
    def clamped(self) -> int:
        """How many draws so far lay outside the table and were moved to its edge."""
        return self._counts.clamped.value

    @property
    def extrapolated(self) -> int:
        """How many draws so far had an impact speed outside the file's ``valid_speed``."""
        return self._counts.extrapolated.value
