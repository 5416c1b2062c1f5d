"""``tablegen compare``: simulated rebounds beside measured ones."""

from pathlib import Path

import click

from sampler import options
from sampler.files import write_bytes, write_text
from sampler.options import DONE, note
from tablegen.commands import measured_options
from tablegen.commands.bounded import CONFIG
from tablegen.config.defaults import COMPARE_COUNT, MIXTURE
from tablegen.model.shape_codes import SHAPE_NAMES

_COUNT = options.Integer(2, 2**32 - 1)


@click.command(
    cls=options.Command,
    short_help="Put simulated rebounds beside measured ones.",
    epilog=options.examples(
        "tablegen compare grant-tabakoff-1975 --measured grant-tabakoff-1975",
        "tablegen compare corundum-steel --measured my-rig.csv --speed 100 \\",
        "    --json comparison.json --picture comparison.pdf",
        "tablegen compare my-pair.toml --measured kharaz-2001 --shape sphere",
    ),
)
@click.argument("pair", type=CONFIG, metavar="PAIR|CONFIG.toml")
@click.option(
    "--measured",
    required=True,
    type=measured_options.MEASURED,
    metavar="F.csv|NAME",
    help="Measured rebounds: tables/MEASUREMENTS.md describes the file.",
)
@click.option(
    "--count",
    type=_COUNT,
    default=COMPARE_COUNT,
    show_default=True,
    metavar="N",
    help="Particles of each shape at each condition.",
)
@options.seed("Seed of the simulation.")
@measured_options.speed(
    "Impact speed of the rows that state none; needed if the restitution depends on it."
)
@measured_options.wall_tilt("Standard deviation of the tilt of the facets of a rough wall.")
@click.option(
    "--shape",
    type=click.Choice([*SHAPE_NAMES, MIXTURE]),
    help="Only this shape of the pair's particles; mixture: all but spheres.",
)
@options.threads
@options.json_file("Write every number.")
@measured_options.picture("Draw means, with bands of one standard deviation, against the angle.")
@options.progress
def compare(
    pair: str,
    measured: str,
    count: int,
    seed: int,
    speed: float | None,
    wall_tilt: float,
    shape: str | None,
    threads: int | None,
    json_file: Path | None,
    picture: Path | None,
    progress: bool,
) -> int:
    """Simulate measured rebounds, and print both side by side with their deviations.

    Means and standard deviations of what was measured: normal and tangential restitution, rebound
    angle, angle out of the impact plane, spin. Each stands with the chance error of the
    simulation, and where the file states counts the deviation also in standard errors of both.
    """
    from tablegen.config.config import load_config
    from tablegen.measured.compare import compare as side_by_side
    from tablegen.measured.comparison_picture import comparison_picture
    from tablegen.measured.comparison_text import comparison_json, comparison_text
    from tablegen.measured.reader import read_measurements

    config = load_config(pair)
    found = side_by_side(
        config,
        read_measurements(measured),
        count=count,
        seed=seed,
        speed=speed,
        wall_tilt_deg=wall_tilt,
        shape=shape,
        threads=threads,
        progress=progress,
    )
    warnings = map(config.pair.extrapolation, sorted(set(found.speed.tolist())))
    for warning in dict.fromkeys(filter(None, warnings)):
        note("tablegen", warning)
    click.echo(comparison_text(found))
    if json_file:
        write_text(json_file, comparison_json(found))
    if picture:
        write_bytes(picture, comparison_picture(found, picture.name).data)
    return DONE
