"""``tablegen figures``: the figures of the paper, and numbers beside its own."""

from pathlib import Path

import click

from sampler import options
from sampler.errors import InputError
from sampler.files import write_bytes
from sampler.options import DONE
from tablegen.commands import shared
from tablegen.config.defaults import FIGURES_COUNT, FIGURES_QUICK_COUNT


@click.command(
    cls=options.Command,
    short_help="Draw the figures of the paper, with numbers beside its own.",
    epilog=options.examples(
        "tablegen figures --output figures",
        "tablegen figures my-pair.h5 --output figures --count 1000000",
    ),
)
@click.argument("table", type=options.TABLE, metavar="[T.h5]", default="corundum-steel")
@click.option(
    "--output",
    required=True,
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder for the figures and the page.",
)
@click.option(
    "--count",
    type=options.SAMPLES,
    metavar="N",
    help=f"Number of particles of each shape at each angle; by default {FIGURES_COUNT}.",
)
@click.option(
    "--quick", is_flag=True, help=f"Simulate only {FIGURES_QUICK_COUNT} particles of each shape."
)
@options.seed("Seed of the simulations and draws.")
@options.overwrite
@options.progress
def figures(
    table: str, output: Path, count: int | None, quick: bool, seed: int, progress: bool
) -> int:
    """Draw Figures 3 to 10, 12 and 13 of Panfilov & Tsirkunov (2022), with numbers beside its own.

    The command simulates each shape and the mixture at angles from 5 to 90 degrees. The speed is
    200 m/s, or the nearest speed at which the pair of the table was measured. The mixture is also
    drawn from the table. The folder gets figure-03.svg to figure-13.svg, and paper.html with all
    of them. For corundum-steel, the pair of the paper, the page also has tables of our numbers
    beside those of the paper.
    """
    from tablegen.config.config import stored_config
    from tablegen.evidence.methods import load_whole
    from tablegen.evidence.paper import PAGE, make_paper
    from tablegen.presentation import require_matplotlib

    require_matplotlib("tablegen figures")
    if output.is_file():
        raise InputError("--output", problem=f"{output} is a file", remedy="give a folder")
    files_before = [*output.glob("figure-*"), output / PAGE]
    for file in files_before if output.exists() else [output]:
        shared.check_written(file)
    loaded = load_whole(table)
    config = stored_config(loaded.config, f"{table}: config")
    particles = count or (FIGURES_QUICK_COUNT if quick else FIGURES_COUNT)
    files = make_paper(loaded, config, particles, seed, progress)
    output.mkdir(exist_ok=True)
    for name, data in files.items():
        write_bytes(output / name, data)
    click.echo(f"{output}: {', '.join(files)}")
    return DONE
