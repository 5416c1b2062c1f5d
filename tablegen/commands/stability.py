"""``tablegen stability``: check the model on extreme particles and impacts."""

from pathlib import Path

import click

from sampler import options
from sampler.errors import InputError
from sampler.files import json_text, write_bytes, write_text
from sampler.options import DONE, MISSED
from tablegen.commands import shared
from tablegen.commands.shared import CONFIG
from tablegen.config.defaults import STABILITY_COUNT, STABILITY_FRICTION, STABILITY_GRAINS


@click.command(
    cls=options.Command,
    short_help="Check the model on extreme particles and impacts.",
    epilog=options.examples(
        "tablegen stability --quick",
        "tablegen stability my-pair.toml --json stability.json --picture stability.png",
        "tablegen stability --quick --count 1 --friction 250000",
    ),
)
@click.argument("pair", type=CONFIG, metavar="[PAIR|CONFIG.toml]", default="corundum-steel")
@click.option(
    "--quick",
    is_flag=True,
    help="Simulate 2,368 cases instead of 28,280; this takes about 20 seconds on two cores.",
)
@shared.count(STABILITY_COUNT, "Number of particles in each case.")
@click.option(
    "--friction",
    type=options.Integer(0, 2**40),
    metavar="N",
    help="Number of particles under each of 44 Coulomb laws.  [default: 20000; with --quick 1000]",
)
@click.option(
    "--grains",
    type=options.Integer(0, 20_000),
    metavar="N",
    help="Number of grains of each kind in chains of hits.  [default: 1000; with --quick 100]",
)
@options.seed("Seed of the particles.")
@options.threads
@options.json_file("Write the numbers of all cases to this JSON file.")
@shared.picture("Draw the angles at which grains leave the walls from hit to hit.")
@options.overwrite
@options.progress
def stability(
    pair: str,
    quick: bool,
    count: int,
    friction: int | None,
    grains: int | None,
    seed: int,
    threads: int | None,
    json_file: Path | None,
    picture: Path | None,
    progress: bool,
) -> int:
    """Simulate extreme particles and impacts, and check the model in each case.

    The study has 28,280 cases: five shapes; b/a and c/b of 1, 0.999, 0.5, 0.05 and 0.02; angles
    from 0.01 to 90 degrees; speeds from 1 to 3,000 m/s; spins before the impact of 0, 1, 5 and 50
    V/a in both directions along the wall axis z, which is normal to the impact plane. It takes
    about two minutes on two cores. To repeat a case, run tablegen simulate with the seed that the
    study prints.

    Each case is simulated three times with the same particles: as usual, with half the contact
    resolution, and with half the tolerance of the flight.

    Coulomb's law is checked with random particles of the pair's population. They hit the wall at
    random angles, speeds and spins, with coefficients of friction from 0.1 to 100 and restitutions
    from 0 to 1.

    Grains of each shape, and discs, also fly through chains of sixty hits, in a cylinder and
    between walls of any direction. They keep their angular velocity and the inertia about it from
    wall to wall. Discs that roll along a cylinder meet its wall a thousand times.

    The exit status is 1 if a particle has a number that is not finite, does not leave the wall,
    gains energy, or touches the wall at the end.
    """
    from tablegen.config.config import load_config
    from tablegen.evidence.stability import run_study
    from tablegen.evidence.stability_cases import all_cases
    from tablegen.evidence.stability_text import chain_picture, study_text

    if friction is None:
        friction = STABILITY_FRICTION // (20 if quick else 1)
    if grains is None:
        grains = STABILITY_GRAINS // (10 if quick else 1)
    if picture and grains == 0:
        raise InputError("--picture", problem="--grains 0 leaves nothing to draw")
    study = run_study(
        load_config(pair),
        all_cases(quick),
        count=count,
        friction=friction,
        chained=grains,
        seed=seed,
        threads=threads,
        progress=progress,
    )
    if json_file:
        write_text(json_file, json_text(study.to_dict(), indent=None))
    if picture:
        write_bytes(picture, chain_picture(study.chains, picture.name))
    click.echo(study_text(study))
    return DONE if study.holds else MISSED
