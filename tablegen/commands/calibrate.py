"""Command ``tablegen calibrate``: fit contact laws to measured rebounds."""

import re
import shlex
from pathlib import Path
from time import process_time
from typing import Any

import click

from sampler import options
from sampler.files import json_text, write_bytes, write_text
from sampler.options import DONE, MISSED
from tablegen.commands import shared
from tablegen.commands.shared import CONFIG

#: Form of the names that follow ``--free NAME``.
_NAME = r"\+?pair\."


class _ManyNames(options.Command):
    """Command that takes ``--free A B`` as ``--free A --free B``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Repeat the flag before each name."""
        words = list[str]()
        for word in args:
            if len(words) > 1 and words[-2] == "--free" and re.match(_NAME, word):
                words.append("--free")
            words.append(word)
        return super().parse_args(ctx, words)


@click.command(
    cls=_ManyNames,
    short_help="Fit contact laws to measured rebounds.",
    epilog=options.examples(
        "tablegen calibrate grant-tabakoff-1975 --output sand.toml",
        "tablegen calibrate my.csv --output my.toml --grains rounded --picture fit.png",
        "tablegen calibrate my.csv --output my.toml --pair corundum-steel \\",
        "    --free pair.restitution.coefficient pair.resistance.strength",
    ),
)
@click.argument("measured", type=shared.MEASURED, metavar="F.csv|NAME")
@options.output("FITTED.toml", ".toml", help_text="Pair file to write.")
@click.option(
    "--grains",
    metavar="NAME|FILE.toml",
    help="Population of grains: angular, subangular, subrounded, rounded or well-rounded; or that "
    "of a file or a shipped pair. By default all five are tried.",
)
@click.option(
    "--pair",
    "start",
    type=CONFIG,
    metavar="START.toml",
    help="Pair of which the form of the laws and the grains are kept, and only numbers are fitted.",
)
@click.option(
    "--free",
    multiple=True,
    metavar="NAME ...",
    help="Fields of the pair to fit; by default all that have an effect. +NAME adds a field to "
    "these. If you give a wrong name, the command lists the names that it knows.",
)
@options.seed("Seed of the particles.")
@shared.speed("Impact speed of rows that state none.")
@options.json_file("Write all fits and their numbers to this JSON file.")
@shared.picture("Draw the measurements, the fit and the fitted laws.")
@options.overwrite
@options.threads
@options.progress
def calibrate(
    measured: str,
    output: Path,
    start: str | None,
    json_file: Path | None,
    picture: Path | None,
    **settings: Any,
) -> int:
    """Fit contact laws to measured rebounds (a name, or a .csv file).

    For each population of grains, the command finds the smoothest laws that give all measured means
    within their tolerances. It takes the population with the least misfit, which weighs means and
    spreads together. If its laws do not give all means, the exit status is 1. The comments of the
    new file say how the pair was fitted.
    """
    from tablegen.config.config import load_config
    from tablegen.measured.calibrate import calibrate as fit
    from tablegen.measured.fit_text import fit_lines
    from tablegen.measured.pictures import fit_picture

    pair = load_config(start) if start is not None else None
    calibration = fit(measured, output, start=pair, **settings)
    if json_file is not None:
        write_text(json_file, json_text(calibration.to_dict()))
    if picture is not None:
        write_bytes(picture, fit_picture(calibration, picture.name))
    for line in fit_lines(calibration):
        click.echo(line)
    click.echo(
        f"{output}: the fitted pair {calibration.config.name}; {process_time():.0f} s of CPU time"
    )
    if calibration.missed:
        return MISSED
    table = output.with_suffix(".h5")
    click.echo(
        f"next: tablegen generate {shlex.quote(str(output))} --output {shlex.quote(str(table))}"
    )
    return DONE
