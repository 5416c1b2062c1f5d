"""``tablegen figures``: the paper's figures and statements from the command line."""

import os
from pathlib import Path

import click

import sampler
from sampler.atomic import atomic_output
from sampler.errors import InputError
from tablegen import options
from tablegen.config import parse_config
from tablegen.figures.gallery import Gallery, make_gallery
from tablegen.figures.style import require_matplotlib
from tablegen.figures.text import laws_json, statements_json, statements_page, statements_text

#: Particles of each shape at each angle.
_COUNT, _QUICK_COUNT = 200_000, 20_000


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


def _write_all(gallery: Gallery, folder: Path) -> None:
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


@click.command(
    short_help="Draw the figures of the paper, and check what it says.",
    epilog=options.examples(
        "tablegen figures --output figures",
        "tablegen figures my-pair.h5 --output figures --count 1000000",
    ),
)
@click.argument("table", metavar="[T.h5]", default="corundum-steel")
@click.option(
    "--output", required=True, type=click.Path(path_type=Path), metavar="DIR", help="A folder."
)
@click.option(
    "--count",
    type=options.Whole(1000, 10**9),
    metavar="N",
    help=f"Particles of each shape at each angle; {_COUNT} by default.",
)
@click.option("--quick", is_flag=True, help=f"{_QUICK_COUNT} particles.")
@options.seed("Seed of the simulations and draws.")
@options.progress
def figures(
    table: str, output: Path, count: int | None, quick: bool, seed: int, progress: bool
) -> int:
    """Draw Figures 3 to 13 of Panfilov & Tsirkunov (2022), and check what the paper says.

    Each shape and the mixture come from direct simulation at 200 m/s and angles from 5 to 90
    degrees; the mixture also from the table. The folder gets figure-03.svg to figure-13.svg, the
    numbers behind them (laws.json), and every statement of the paper that can be checked, with
    what was measured (statements.md, statements.json). The statements are about the paper's pair
    and particles, corundum-steel: for others they are measured and not judged.
    """
    require_matplotlib("tablegen figures")
    folder = _folder(output)
    loaded = sampler.load(table)
    config = parse_config(loaded.config, f"{table}: config")
    particles = count or (_QUICK_COUNT if quick else _COUNT)
    gallery = make_gallery(loaded, config, particles, seed, progress)
    assert gallery is not None  # matplotlib is there
    _write_all(gallery, folder)
    click.echo(statements_text(gallery.statements))
    files = f"{len(gallery.pictures)} figures, statements.md, statements.json, laws.json"
    click.echo(f"{folder}: {files}")
    return 0
