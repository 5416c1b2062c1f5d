"""Statements of the paper's text that can be checked, with what our model and a table say."""

from dataclasses import asdict, dataclass, replace
from typing import Any

from tablegen.config.config import Config, load_config
from tablegen.evidence import scattering_checks, statement_checks
from tablegen.evidence.checked_statement import Check, Verdict
from tablegen.evidence.sample_statistics import DIRECT, TABLE, FigureStatistics


@dataclass(frozen=True)
class Statement:
    """A statement, how it was checked, and what came out."""

    #: Where in the paper.
    place: str
    #: In our words.
    text: str
    #: What must be found for it to hold.
    criterion: str
    #: None where the source cannot tell.
    direct: Verdict | None
    table: Verdict | None

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return asdict(self)


#: Every check, in the order of the paper.
CHECKS = statement_checks.CHECKS | scattering_checks.CHECKS

#: What the text says and cannot be checked here, with the reason.
NOT_CHECKED = (
    "A mixture agrees better with the measured velocities than one shape does, and the agreement "
    "is good (Figures 3 and 4): the measured values are in the figures only, not in the text.",
    "No rebound depends on the size of the particle: it holds by construction here, velocities "
    "being in V and angular velocities in V/a.",
)


def is_of_the_paper(config: Config) -> bool:
    """Whether laws and particles are those of the paper, whatever they are called."""

    def matter(of: Config) -> tuple[object, ...]:
        pair = of.pair
        restitution = pair.restitution.model_dump(exclude={"source", "valid_speed"})
        resistance = pair.resistance.model_dump(exclude={"source"})
        return restitution, resistance, of.population.model_dump()

    return matter(config) == matter(load_config("corundum-steel"))


def check_statements(statistics: FigureStatistics) -> list[Statement]:
    """Check every statement against direct simulation and the table.

    Parameters
    ----------
    statistics : FigureStatistics
        Of another pair or other particles than the paper's, statements are measured but not judged.
    """
    judged = is_of_the_paper(statistics.config)

    def verdict(check: Check, source: str) -> Verdict | None:
        found = check.verdict(statistics, source)
        return found if found is None or judged else replace(found, holds=None)

    return [
        Statement(*check[:3], verdict(check, DIRECT), verdict(check, TABLE))
        for check in CHECKS.values()
    ]
