"""Command ``tablegen calibrate``: fit a material pair to measured rebounds."""

import re
from pathlib import Path
from time import process_time
from typing import Any

import click

from sampler import options
from sampler.files import json_text, write_bytes, write_text
from sampler.options import DONE, MISSED
from tablegen.commands import shared
from tablegen.commands.generate import resumable
from tablegen.commands.shared import CONFIG
from tablegen.config.defaults import CALIBRATE_COUNT

#: Options that may be followed by several values, and the form of those after the first.
_MANY = {"--free": r"(pair|population)\.|wall_tilt_deg", "--hold-out": r"[0-9.]+$"}


class _ManyValues(options.Command):
    """Command that takes ``--free A B`` as ``--free A --free B``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Repeat the flag before each value."""
        words, flag = list[str](), ""
        for word in args:
            if flag and words[-1] != flag and re.match(_MANY[flag], word):
                words.append(flag)
            elif not flag or words[-1] != flag:
                flag = word if word in _MANY else ""
            words.append(word)
        return super().parse_args(ctx, words)


@click.command(
    cls=_ManyValues,
    short_help="Fit a material pair to measured rebounds.",
    epilog=options.examples(
        "tablegen calibrate grant-tabakoff-1975 --pair grant-tabakoff-1975 --output sand.toml",
        "tablegen calibrate my-rebounds.csv --pair start.toml --output fitted.toml \\",
        "    --free pair.restitution.value pair.resistance.value population.aspect.mean \\",
        "    --hold-out 45 --json fit.json --picture fit.png",
    ),
)
@click.argument("measured", type=shared.MEASURED, metavar="F.csv|NAME")
@click.option(
    "--pair",
    required=True,
    type=CONFIG,
    metavar="START.toml",
    help="Pair to start from: a name, or the path of a .toml file.",
)
@options.output("FITTED.toml", "Pair file to write.")
@click.option(
    "--free",
    multiple=True,
    metavar="NAME ...",
    help="Fields that are fitted; by default the coefficients of both laws and the mean aspect "
    "ratio. A wrong name lists the right ones.",
)
@click.option(
    "--hold-out",
    type=shared.ANGLE,
    multiple=True,
    metavar="DEG ...",
    help="Angles whose rows are predicted and not used.",
)
@click.option(
    "--spreads",
    type=click.Choice(["fit", "upper-bound", "ignore"]),
    default="upper-bound",
    show_default=True,
    help="What measured spreads are for: simulated ones that are smaller may be as good.",
)
@shared.count(CALIBRATE_COUNT, "Particles of each shape at each row.")
@options.seed("Seed of the particles and of the random starts.")
@shared.speed("Impact speed of rows that state none.")
@shared.wall_tilt(
    "Roughness of the wall, standard deviation of the tilt of its facets; or the start of the "
    "search for it."
)
@click.option("--resume", is_flag=True, help="Use the simulations of an interrupted run.")
@click.option("--discard", is_flag=True, help="Remove the simulations of an interrupted run.")
@options.json_file("Write everything.")
@shared.picture("Draw fit and residuals.")
@options.threads
@options.progress
def calibrate(
    measured: str,
    pair: str,
    output: Path,
    free: tuple[str, ...],
    json_file: Path | None,
    picture: Path | None,
    **settings: Any,
) -> int:
    """Fit free parameters of a material pair to measured rebounds (a name, or a .csv file).

    Least squares over means and, if measured, spreads, each weighted by its accuracy: measured
    spread and count of particles, or the same for all rows without a count. The search begins at
    the pair and at random places around it. The comments of the new file say how it was made:
    every row with its residual, standard errors and correlations of the fitted numbers, and
    warnings of what the data leave open. Finished simulations are kept in FITTED.toml.parts until
    then; if an interrupted run left some, say --resume or --discard.
    """
    from tablegen.config.config import load_config
    from tablegen.measured.calibrate import calibrate as fit
    from tablegen.measured.pair_file import fit_lines
    from tablegen.measured.pictures import fit_picture

    start = load_config(pair)
    with resumable(output):
        made = fit(measured, start, output, free=free or None, **settings)
    if json_file is not None:
        write_text(json_file, json_text(made.to_dict()))
    if picture is not None:
        write_bytes(picture, fit_picture(made, picture.name).data)
    for line in fit_lines(made):
        click.echo(line)
    click.echo(f"{output}: the fitted pair {made.config.name}; {process_time():.0f} s of CPU time")
    click.echo(f"next: tablegen generate {output} --output {output.with_suffix('.h5')}")
    return MISSED if made.missed else DONE
