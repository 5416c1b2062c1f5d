"""``tablegen figures``: the figures and statements of the paper."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler.commands import options
from sampler.commands.program import DONE
from sampler.errors import InputError
from sampler.files.atomic import check_output, write_bytes
from sampler.files.locate import find_table
from tablegen.config.defaults import FIGURES_COUNT, FIGURES_QUICK_COUNT

if TYPE_CHECKING:
    from tablegen.evidence.all_figures import PaperFigures

#: Names of the files that the folder gets: pictures, as a pattern, and texts.
_PICTURES = "figure-[0-9][0-9].[ps][nv]g"
_TEXTS = ("statements.md", "statements.json", "laws.json")


@click.command(
    cls=options.Command,
    short_help="Draw the figures of the paper, and check what it says.",
    epilog=options.examples(
        "tablegen figures --output figures",
        "tablegen figures my-pair.h5 --output figures --count 1000000",
    ),
)
@click.argument("table", type=options.TABLE, metavar="[T.h5]", default="corundum-steel")
@click.option(
    "--output", required=True, type=click.Path(path_type=Path), metavar="DIR", help="A folder."
)
@click.option(
    "--count",
    type=options.SAMPLES,
    metavar="N",
    help=f"Particles of each shape at each angle; {FIGURES_COUNT} by default.",
)
@click.option("--quick", is_flag=True, help=f"{FIGURES_QUICK_COUNT} particles.")
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
    import sampler
    from tablegen.config.config import stored_config
    from tablegen.evidence.all_figures import make_paper_figures
    from tablegen.evidence.statement_text import statements_text
    from tablegen.presentation import require_matplotlib

    require_matplotlib("tablegen figures")
    _check_folder(output, table)
    loaded = sampler.load(table)
    config = stored_config(loaded.config, f"{table}: config")
    particles = count or (FIGURES_QUICK_COUNT if quick else FIGURES_COUNT)
    gallery = make_paper_figures(loaded, config, particles, seed, progress)
    assert gallery is not None  # matplotlib is there
    _write_all(gallery, output)
    click.echo(statements_text(gallery.statements))
    files = f"{len(gallery.pictures)} figures, statements.md, statements.json, laws.json"
    click.echo(f"{output}: {files}")
    return DONE


def _check_folder(path: Path, table: str) -> None:
    """Check that a folder can be written, or made in a folder that exists; links are followed."""
    path = Path(os.path.realpath(path))
    parent = path if path.exists() else path.parent
    if not (parent.is_dir() and os.access(parent, os.W_OK)):
        raise InputError(
            f"--output: got {path}, allowed: a folder that can be written, or a new one in such"
        )
    made = (*path.glob(_PICTURES), *(path / name for name in _TEXTS))
    for file in made if path.exists() else ():
        check_output(file, [find_table(table)])


def _write_all(gallery: "PaperFigures", folder: Path) -> None:
    """Write each file whole."""
    from tablegen.evidence import statement_text as text

    Path(os.path.realpath(folder)).mkdir(exist_ok=True)
    files = {picture.name: picture.data for picture in gallery.pictures}
    texts = text.statements_page(gallery), text.statements_json(gallery), text.laws_json(gallery)
    files |= {name: words.encode() for name, words in zip(_TEXTS, texts, strict=True)}
    for name, data in files.items():
        write_bytes(folder / name, data)
