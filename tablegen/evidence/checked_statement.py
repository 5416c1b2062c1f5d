"""Statements of the paper that can be checked: each with its text, its criterion and its check.

A check goes through the statistics of one source and yields findings: whether one agrees with the
statement, and what was measured. The statement holds if all do. Without a finding the source cannot
tell: a table holds the mixture, without collisions and rotational energies.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from tablegen.evidence.sample_statistics import DIRECT, FigureStatistics

#: Whether a finding agrees with the statement, and what was measured.
Findings = Iterator[tuple[bool, str]]


@dataclass(frozen=True)
class Verdict:
    """Whether a statement holds (None: it is not about this pair), and what was measured."""

    holds: bool | None
    measured: str


class Check(NamedTuple):
    """A statement of the paper and its check."""

    #: Where in the paper; the statement in our words; what must be found for it to hold.
    place: str
    text: str
    criterion: str
    #: From the statistics and a source to a `Verdict`, or None where the source cannot tell.
    verdict: Callable[[FigureStatistics, str], Verdict | None]


class Checks(dict[str, Check]):
    """Checks by name, in the order of the paper."""

    def statement(
        self,
        place: str,
        text: str,
        criterion: str,
        *,
        direct_only: bool = False,
        head: str = "",
        between: str = "; ",
    ) -> Callable[[Callable[[FigureStatistics, str], Findings]], None]:
        """Make the function that follows the check of a statement.

        Parameters
        ----------
        place, text, criterion : str
            As in `Check`.
        direct_only : bool
            Whether a table cannot tell.
        head, between : str
            Before what was measured, and between the findings.
        """

        def register(findings: Callable[[FigureStatistics, str], Findings]) -> None:
            def verdict(statistics: FigureStatistics, source: str) -> Verdict | None:
                if direct_only and source != DIRECT:
                    return None
                found = list(findings(statistics, source))
                texts = between.join(text for _, text in found)
                return Verdict(all(bool(ok) for ok, _ in found), head + texts) if found else None

            self[findings.__name__.lstrip("_")] = Check(place, text, criterion, verdict)

        return register
