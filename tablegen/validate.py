"""Whether a table holds the accuracy that it declares."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import sampler
from sampler.errors import InputError
from sampler.table import Table
from tablegen.accuracy import Comparison
from tablegen.choices import VALIDATE_CONDITIONS
from tablegen.config import AccuracyTargets, parse_config
from tablegen.measure import measure, missed_targets, pick_conditions


@dataclass(frozen=True)
class Validation:
    """Outcome of a validation.

    Attributes
    ----------
    table : str
        Name or path that was given.
    content_sha256 : str
        Checksum of the table.
    seed : int
    declared : AccuracyTargets
        What the table's configuration declares.
    comparisons : list of Comparison
    missed : list of str
        One line for each declared accuracy that was missed.
    """

    table: str
    content_sha256: str
    seed: int
    declared: AccuracyTargets
    comparisons: list[Comparison]
    missed: list[str]

    @property
    def holds(self) -> bool:
        """Whether every declared accuracy holds at every condition."""
        return not self.missed

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready dictionary with every number."""
        record = {k: v for k, v in asdict(self).items() if k not in ("comparisons", "declared")}
        return {
            **record,
            "holds": self.holds,
            "declared": self.declared.model_dump(),
            "software_version": sampler.__version__,
            "conditions": [c.to_dict() for c in self.comparisons],
        }


def validate(
    name_or_path: str | Path,
    *,
    conditions: int = VALIDATE_CONDITIONS,
    seed: int = 1,
    samples: int | None = None,
    progress: bool = False,
) -> Validation:
    """Compare a table with fresh direct simulation at conditions that are not nodes.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a table that comes with the package, or path of a .h5 file.
    conditions : int
        Number of conditions, 1 or more.
    seed : int
        Chooses the conditions and all random numbers, 0 to 2**64 - 1.
    samples : int, optional
        States a side at each condition, 1000 or more; by default as many as the declared accuracy
        needs.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    Validation

    Raises
    ------
    InputError
        If the file is not a table, its configuration cannot be read, or an argument is out of
        range.
    """
    if conditions < 1:
        raise InputError(f"conditions: got {conditions}, allowed: 1 or more")
    if samples is not None and samples < 1000:
        raise InputError(f"samples: got {samples}, allowed: 1000 or more")
    if not 0 <= seed < 2**64:
        raise InputError(f"seed: got {seed}, allowed: 0 to 2**64 - 1")
    table: Table = sampler.load(name_or_path)
    config = parse_config(table.config, f"{name_or_path}: config")
    comparisons = measure(
        table,
        config,
        pick_conditions(table, conditions, seed),
        seed=seed,
        samples=samples,
        progress=progress,
    )
    return Validation(
        table=str(name_or_path),
        content_sha256=table.contents.content_sha256,
        seed=seed,
        declared=config.accuracy,
        comparisons=comparisons,
        missed=missed_targets(comparisons, config.accuracy),
    )
