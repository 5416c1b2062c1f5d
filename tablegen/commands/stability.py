"""``tablegen stability``: its options and its help."""

from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options
from tablegen.configuration.defaults import STABILITY_COUNT
from tablegen.model.shape_codes import SHAPE_NAMES


@click.command(
    short_help="Check the model on extreme particles and impacts.",
    epilog=options.examples(
        "tablegen stability --quick",
        "tablegen stability my-pair.toml --json stability.json --html stability.html",
        "tablegen stability --shape prism --aspect 0.02 0.02 --alpha 0.01 --count 1000",
    ),
)
@click.argument("pair", type=options.CONFIG, metavar="[PAIR|CONFIG.toml]", default="corundum-steel")
@click.option("--quick", is_flag=True, help="2,368 cases: some 20 seconds on two cores.")
@click.option(
    "--count",
    type=options.Whole(1, 10**9),
    default=STABILITY_COUNT,
    show_default=True,
    metavar="N",
    help="Particles a case.",
)
@options.seed("Seed of the particles.")
@click.option("--shape", type=click.Choice(SHAPE_NAMES), multiple=True, help="Only this shape.")
@click.option(
    "--aspect",
    type=options.RATIO,
    nargs=2,
    multiple=True,
    metavar="BA CB",
    help="Only these b/a and c/b.",
)
@click.option(
    "--alpha", type=options.ANGLE, multiple=True, metavar="DEG", help="Only this impact angle."
)
@click.option(
    "--speed", type=options.POSITIVE, multiple=True, metavar="M_S", help="Only this speed."
)
@click.option(
    "--spin", type=options.ANY, multiple=True, metavar="WZ", help="Only this spin, times a/V."
)
@click.option("--threads", type=options.Whole(1, 4096), help="Default: one a processor.")
@options.json_file("Write every case.")
@options.html_file
@options.progress
def stability(**given: Any) -> int:
    """Simulate extreme particles and impacts, and check the model in each.

    The whole study has 28,280 cases: five shapes; b/a and c/b of 1, 0.999, 0.5, 0.05 and 0.02;
    angles from 0.01 to 90 degrees; speeds from 1 to 3,000 m/s; spins before the impact of 0, 1, 5
    and 50 V/a along the wall axis z, the normal of the impact plane, both ways. It takes some ten
    minutes on two cores; --count sets the particles a case and so the time. Options that name
    values may be repeated and take the place of the values of the study.

    Each case runs three times on the same particles: as usual, with half the contact resolution,
    and with half the tolerance of the flight. Exit status 1 if a particle is not finite, does not
    finish, gains energy or is not separated from the wall.
    """
    return work("tablegen.commands.stability_command", **given)
