"""``tablegen stability``: the study from the command line."""

from pathlib import Path

import click

from sampler.files.atomic import write_text
from tablegen.config import load_config
from tablegen.studies.stability.cases import FULL, QUICK, Grid
from tablegen.studies.stability.stability_page import study_page
from tablegen.studies.stability.stability_study import run_study
from tablegen.studies.stability.stability_text import study_json, study_text

HOLDS, FAILS = 0, 1


def run(
    pair: str,
    quick: bool,
    count: int,
    seed: int,
    shape: tuple[str, ...],
    aspect: tuple[tuple[float, float], ...],
    alpha: tuple[float, ...],
    speed: tuple[float, ...],
    spin: tuple[float, ...],
    threads: int | None,
    json_file: Path | None,
    html_file: Path | None,
    progress: bool,
) -> int:
    """Run ``tablegen stability``; parameters are the options of `tablegen.commands.stability`."""
    axes = Grid(shape, aspect, alpha, speed, spin)
    study = run_study(
        load_config(pair),
        list((QUICK if quick else FULL).narrowed(axes).cases()),
        count=count,
        seed=seed,
        threads=threads,
        progress=progress,
    )
    click.echo(study_text(study))
    if json_file:
        write_text(json_file, study_json(study))
    if html_file:
        write_text(html_file, study_page(study))
    return HOLDS if study.holds else FAILS
