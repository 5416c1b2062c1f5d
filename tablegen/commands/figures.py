"""``tablegen figures``: its options and its help."""

from pathlib import Path
from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options
from tablegen.configuration.defaults import FIGURES_COUNT, FIGURES_QUICK_COUNT


@click.command(
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
    type=options.Whole(1000, 10**9),
    metavar="N",
    help=f"Particles of each shape at each angle; {FIGURES_COUNT} by default.",
)
@click.option("--quick", is_flag=True, help=f"{FIGURES_QUICK_COUNT} particles.")
@options.seed("Seed of the simulations and draws.")
@options.progress
def figures(**given: Any) -> int:
    """Draw Figures 3 to 13 of Panfilov & Tsirkunov (2022), and check what the paper says.

    Each shape and the mixture come from direct simulation at 200 m/s and angles from 5 to 90
    degrees; the mixture also from the table. The folder gets figure-03.svg to figure-13.svg, the
    numbers behind them (laws.json), and every statement of the paper that can be checked, with
    what was measured (statements.md, statements.json). The statements are about the paper's pair
    and particles, corundum-steel: for others they are measured and not judged.
    """
    return work("tablegen.commands.figures_command", **given)
