"""``tablegen figures``: the paper's figures and statements from the command line."""

import os
from pathlib import Path

import click

import sampler
from sampler.errors import InputError
from sampler.files.atomic import atomic_output
from tablegen.config import parse_config
from tablegen.configuration.defaults import FIGURES_COUNT, FIGURES_QUICK_COUNT
from tablegen.studies.paper_figures.all_figures import PaperFigures, make_paper_figures
from tablegen.studies.paper_figures.statement_text import (
    laws_json,
    statements_json,
    statements_page,
    statements_text,
)
from tablegen.studies.paper_figures.style import require_matplotlib


def _folder(path: Path) -> Path:
    """Folder for the figures, which may be a new one in a folder that exists.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    parent = path if path.exists() else path.absolute().parent
    if not (parent.is_dir() and os.access(parent, os.W_OK)):
        raise InputError(
            f"--output: got {path}, allowed: a folder that can be written, or a new one in such"
        )
    return path


def _write_all(gallery: PaperFigures, folder: Path) -> None:
    """Write each file whole."""
    folder.mkdir(exist_ok=True)
    files = {picture.name: picture.data for picture in gallery.pictures}
    for name, text in (
        ("statements.md", statements_page(gallery)),
        ("statements.json", statements_json(gallery)),
        ("laws.json", laws_json(gallery)),
    ):
        files[name] = text.encode("utf-8")
    for name, data in files.items():
        with atomic_output(folder / name) as temporary:
            temporary.write_bytes(data)


def run(table: str, output: Path, count: int | None, quick: bool, seed: int, progress: bool) -> int:
    """Run ``tablegen figures``; parameters are the options of `tablegen.commands.figures`."""
    require_matplotlib("tablegen figures")
    folder = _folder(output)
    loaded = sampler.load(table)
    config = parse_config(loaded.config, f"{table}: config")
    particles = count or (FIGURES_QUICK_COUNT if quick else FIGURES_COUNT)
    gallery = make_paper_figures(loaded, config, particles, seed, progress)
    assert gallery is not None  # matplotlib is there
    _write_all(gallery, folder)
    click.echo(statements_text(gallery.statements))
    files = f"{len(gallery.pictures)} figures, statements.md, statements.json, laws.json"
    click.echo(f"{folder}: {files}")
    return 0
