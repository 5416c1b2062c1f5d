"""All that a report shows: the evidence, and what only its page needs."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sampler
from sampler.files.locate import find_table
from tablegen.config import Config, parse_config
from tablegen.model.float_array import FloatArray
from tablegen.studies.paper_figures.all_figures import Gallery, make_gallery
from tablegen.studies.report import accuracy_map as atlases
from tablegen.studies.report.accuracy_map import Atlas, make_atlas
from tablegen.studies.report.budget import FULL, QUICK
from tablegen.studies.report.error_against_time import Evidence
from tablegen.studies.report.file_identity import identity
from tablegen.studies.report.histograms import View, make_views
from tablegen.studies.report.stability_results import brief_study, read_study
from tablegen.studies.stability.stability_study import Study
from tablegen.tasks.progress import bar


@dataclass(frozen=True)
class Dossier:
    """What the page of a report shows.

    Attributes
    ----------
    evidence : Evidence
    config : Config
        Of the table.
    identity : dict
        Attributes of the table's file.
    stored : dict from name to array
        Accuracy that the table carries.
    atlas : Atlas
    views : tuple of View
    stability : Study
    gallery : Gallery or None
        Figures of the paper; None where matplotlib is not installed.
    """

    evidence: Evidence
    config: Config
    identity: dict[str, str]
    stored: dict[str, FloatArray]
    atlas: Atlas
    views: tuple[View, ...]
    stability: Study
    gallery: Gallery | None


def map_accuracy(name_or_path: str, quick: bool, seed: int, progress: bool) -> Atlas:
    """Accuracy map of a table.

    Parameters
    ----------
    name_or_path : str
    quick : bool
    seed : int
    progress : bool
        Show a progress bar on standard error.
    """
    effort = QUICK if quick else FULL
    table = sampler.load(name_or_path)
    config = parse_config(table.config, f"{name_or_path}: config")
    with bar(progress, total=atlases.steps(table, effort), desc="accuracy map") as counted:
        return make_atlas(table, config, effort, seed, counted.update)


def compile_dossier(
    evidence: Evidence, atlas: Atlas, stability_file: Path | None, progress: bool = False
) -> Dossier:
    """Add to the evidence what the page shows besides.

    Parameters
    ----------
    evidence : Evidence
    atlas : Atlas
    stability_file : Path, optional
        What ``tablegen stability --json`` wrote; a brief study is run if None.
    progress : bool
        Show progress bars on standard error.

    Returns
    -------
    Dossier

    Raises
    ------
    InputError
        If the stability file cannot be used.
    """
    effort, seed = evidence.effort, evidence.seed
    if stability_file is not None:
        study = read_study(stability_file)
    table = sampler.load(evidence.table)
    config = parse_config(table.config, f"{evidence.table}: config")
    rows, columns = effort.views
    with bar(progress, total=rows * columns, desc="joint views") as counted:
        views = make_views(table, config, effort, seed, counted.update)
    if stability_file is None:
        study = brief_study(config, evidence.quick, seed % 2**32, progress)
    return Dossier(
        evidence=evidence,
        config=config,
        identity=identity(find_table(evidence.table)),
        stored=table.accuracy,
        atlas=atlas,
        views=tuple(views),
        stability=study,
        gallery=make_gallery(table, config, effort.figures, seed, progress),
    )


def record(evidence: Evidence, atlas: Atlas) -> dict[str, Any]:
    """Every number of a report, JSON-ready."""
    return {**evidence.to_dict(), "atlas": atlas.to_dict()}
