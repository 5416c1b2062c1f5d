"""All that a report shows: error against run time, and what only its page needs."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sampler
from sampler.formats.hdf5 import TableContents
from tablegen.config.config import Config, stored_config
from tablegen.evidence.accuracy_map import AccuracyMap, make_accuracy_map, steps
from tablegen.evidence.all_figures import PaperFigures, make_paper_figures
from tablegen.evidence.budget import FULL, QUICK
from tablegen.evidence.error_against_time import ErrorAgainstTime
from tablegen.evidence.histograms import View, make_views
from tablegen.evidence.stability_results import brief_study, read_study
from tablegen.evidence.stability_study import Study
from tablegen.model.float_array import FloatArray
from tablegen.progress import bar


@dataclass(frozen=True)
class ReportData:
    """What the page of a report shows."""

    evidence: ErrorAgainstTime
    #: Of the table.
    config: Config
    #: Attributes of the table's file.
    identity: dict[str, str]
    #: By name. Accuracy that the table carries.
    stored: dict[str, FloatArray]
    atlas: AccuracyMap
    views: tuple[View, ...]
    stability: Study
    #: Figures of the paper; None where matplotlib is not installed.
    gallery: PaperFigures | None


def _identity(contents: TableContents) -> dict[str, str]:
    """Provenance of a table as text; the version of the format as "major.minor"."""
    found = {**contents.attributes, "content_sha256": contents.content_sha256}
    found["format_version"] = ".".join(map(str, found["format_version"]))
    names = ("pair", "content_sha256", "seed", "software_version", "format_version")
    return {name: str(found[name]) for name in names}


def map_accuracy(name_or_path: str, quick: bool, seed: int, progress: bool) -> AccuracyMap:
    """Accuracy map of a table.

    Parameters
    ----------
    name_or_path : str
    quick : bool
    seed : int
    progress : bool
        Show a progress bar on standard error.
    """
    budget = QUICK if quick else FULL
    table = sampler.load(name_or_path)
    config = stored_config(table.config, f"{name_or_path}: config")
    with bar(progress, total=steps(table, budget), desc="accuracy map") as counted:
        return make_accuracy_map(table, config, budget, seed, counted.update)


def collect_report_data(
    evidence: ErrorAgainstTime,
    atlas: AccuracyMap,
    stability_file: Path | None,
    progress: bool = False,
) -> ReportData:
    """Add to error against run time what the page shows besides.

    Parameters
    ----------
    evidence : ErrorAgainstTime
    atlas : AccuracyMap
    stability_file : Path, optional
        What ``tablegen stability --json`` wrote; a brief study is run if None.
    progress : bool
        Show progress bars on standard error.

    Raises
    ------
    InputError
        If the stability file cannot be used.
    """
    budget, seed = evidence.effort, evidence.seed
    if stability_file is not None:
        study = read_study(stability_file)
    table = sampler.load(evidence.table)
    config = stored_config(table.config, f"{evidence.table}: config")
    rows, columns = budget.views
    with bar(progress, total=rows * columns, desc="joint views") as counted:
        views = make_views(table, config, budget, seed, counted.update)
    if stability_file is None:
        study = brief_study(config, evidence.quick, seed % 2**32, progress)
    return ReportData(
        evidence=evidence,
        config=config,
        identity=_identity(table.contents),
        stored=table.accuracy,
        atlas=atlas,
        views=tuple(views),
        stability=study,
        gallery=make_paper_figures(table, config, budget.figures, seed, progress),
    )


def record(evidence: ErrorAgainstTime, atlas: AccuracyMap) -> dict[str, Any]:
    """Every number of a report, JSON-ready."""
    return {**evidence.to_dict(), "atlas": atlas.to_dict()}
