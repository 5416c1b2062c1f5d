"""``tablegen report``: the evidence from the command line."""

import json
from pathlib import Path

import click

from sampler.files.atomic import write_text
from tablegen.studies.report.error_against_time import gather_evidence
from tablegen.studies.report.report_data import compile_dossier, map_accuracy, record
from tablegen.studies.report.report_page import report_page, require_plotly
from tablegen.studies.report.report_text import evidence_text
from tablegen.studies.report.stability_results import read_study


def run(
    table: str,
    quick: bool,
    beside: tuple[str, ...],
    seed: int,
    json_file: Path | None,
    html_file: Path | None,
    stability_file: Path | None,
    progress: bool,
) -> int:
    """Run ``tablegen report``; parameters are the options of `tablegen.commands.report`."""
    if html_file:
        # what is missing shows before the work, not after
        require_plotly()
    if stability_file:
        read_study(stability_file)
    evidence = gather_evidence(table, beside, quick=quick, seed=seed, progress=progress)
    click.echo(evidence_text(evidence))
    if json_file is None and html_file is None:
        return 0
    atlas = map_accuracy(table, quick, seed, progress)
    if json_file:
        text = json.dumps(record(evidence, atlas), indent=1, allow_nan=False)
        write_text(json_file, text + "\n")
    if html_file:
        page = report_page(compile_dossier(evidence, atlas, stability_file, progress))
        write_text(html_file, page)
        click.echo(f"{html_file}: {len(page.encode()) / 1e6:.1f} MB")
    return 0
