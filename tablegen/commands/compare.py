"""Command ``tablegen compare``: put simulated rebounds beside measured ones."""

import math
from pathlib import Path
from typing import Any

import click

from sampler import options
from sampler.files import json_text, write_bytes, write_text
from sampler.formats.shape_codes import SHAPE_NAMES
from sampler.options import DONE, note
from tablegen.commands import shared
from tablegen.commands.shared import CONFIG
from tablegen.config.defaults import COMPARE_COUNT, MIXTURE


@click.command(
    cls=options.Command,
    short_help="Put simulated rebounds beside measured ones.",
    epilog=options.examples(
        "tablegen compare grant-tabakoff-1975 --measured grant-tabakoff-1975",
        "tablegen compare corundum-steel --measured my-rig.csv --speed 100 \\",
        "    --json comparison.json --picture comparison.pdf",
        "tablegen compare my-pair.toml --measured kharaz-2001 --shape sphere",
        "tablegen compare fit-a.toml fit-b.toml corundum-steel --measured my-rig.csv",
    ),
)
@click.argument("pairs", type=CONFIG, metavar="PAIR|CONFIG.toml ...", nargs=-1, required=True)
@click.option(
    "--measured",
    required=True,
    type=shared.MEASURED,
    metavar="F.csv|NAME",
    help="Measured rebounds: a name, or a file of comma-separated values. MEASUREMENTS.md, in the "
    "folder that sampler.data_directory() gives, describes its columns.",
)
@shared.count(
    COMPARE_COUNT, "Particles of each shape at each condition.", options.Integer(2, 2**32 - 1)
)
@options.seed("Seed of the simulation.")
@shared.speed("Impact speed of the rows that state none; needed if the restitution depends on it.")
@shared.wall_tilt("Standard deviation of the tilt of the facets of a rough wall.")
@click.option(
    "--shape",
    type=click.Choice([*SHAPE_NAMES, MIXTURE]),
    help="Simulate only this shape. mixture: all shapes of the pair but spheres.",
)
@options.threads
@options.json_file("Write all numbers to this JSON file.")
@shared.picture("Draw means and bands of one standard deviation against the impact angle.")
@options.overwrite
@options.progress
def compare(
    pairs: tuple[str, ...],
    measured: str,
    json_file: Path | None,
    picture: Path | None,
    **settings: Any,
) -> int:
    """Simulate measured impacts, and print the rebounds beside the measured ones.

    The command prints means and standard deviations of the quantities that were measured: normal
    and tangential restitution, rebound angle, angle out of the impact plane, and spin. Beside each
    stand the chance error of the simulation and the difference. If a row has a count, the
    difference is also given in standard errors. If you give several pairs, the command ranks them,
    the nearest first, and a picture shows the nearest.
    """
    from tablegen.config.config import load_config
    from tablegen.measured import compare as comparison
    from tablegen.measured.pictures import comparison_picture

    results = []
    for config in map(load_config, pairs):
        results.append(comparison.compare(config, measured, **settings))
        warnings = map(config.pair.extrapolation, sorted(set(results[-1].speed.tolist())))
        for warning in dict.fromkeys(filter(None, warnings)):
            note("tablegen", warning)
    if results[0].measured.doubt:
        note("tablegen", results[0].measured.doubt)
    if not any(math.isnan(one.rms) for one in results):
        results.sort(key=lambda one: one.rms)
    one = len(results) == 1
    if json_file:
        trees = [comparison.comparison_tree(result) for result in results]
        write_text(json_file, json_text(trees[0] if one else {"ranking": trees}))
    if picture:
        write_bytes(picture, comparison_picture(results[0], picture.name))
    click.echo(comparison.comparison_text(*results) if one else comparison.ranking_text(results))
    return DONE
