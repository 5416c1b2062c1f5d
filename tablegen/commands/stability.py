"""``tablegen stability``: the model on extreme particles and impacts."""

from pathlib import Path

import click

from sampler import options
from sampler.files import json_text, write_text
from sampler.options import DONE, MISSED
from tablegen.commands import shared
from tablegen.commands.shared import CONFIG
from tablegen.config.defaults import STABILITY_COUNT, STABILITY_FRICTION


@click.command(
    cls=options.Command,
    short_help="Check the model on extreme particles and impacts.",
    epilog=options.examples(
        "tablegen stability --quick",
        "tablegen stability my-pair.toml --json stability.json --html stability.html",
        "tablegen stability --quick --count 1 --friction 250000",
    ),
)
@click.argument("pair", type=CONFIG, metavar="[PAIR|CONFIG.toml]", default="corundum-steel")
@click.option("--quick", is_flag=True, help="2,368 cases: some 20 seconds on two cores.")
@shared.count(STABILITY_COUNT, "Particles a case.")
@click.option(
    "--friction",
    type=options.Integer(0, 2**40),
    metavar="N",
    help="Particles under each of 44 Coulomb laws.  [default: 20000; with --quick 1000]",
)
@options.seed("Seed of the particles.")
@options.threads
@options.json_file("Write every case.")
@options.html_file
@options.overwrite
@options.progress
def stability(
    pair: str,
    quick: bool,
    count: int,
    friction: int | None,
    seed: int,
    threads: int | None,
    json_file: Path | None,
    html_file: Path | None,
    progress: bool,
) -> int:
    """Simulate extreme particles and impacts, and check the model in each.

    The whole study has 28,280 cases: five shapes; b/a and c/b of 1, 0.999, 0.5, 0.05 and 0.02;
    angles from 0.01 to 90 degrees; speeds from 1 to 3,000 m/s; spins before the impact of 0, 1, 5
    and 50 V/a along the wall axis z, the normal of the impact plane, both ways. It takes some ten
    minutes on two cores. ``tablegen simulate`` repeats a case with the seed that is named.

    Under Coulomb's law random particles of the pair's population hit at random angles, speeds and
    spins, with coefficients of friction from 0.1 to 100 and restitutions from 0 to 1.

    Each case runs three times on the same particles: as usual, with half the contact resolution,
    and with half the tolerance of the flight. Exit status 1 if a particle is not finite, does not
    finish, gains energy or is not separated from the wall.
    """
    from tablegen.config.config import load_config
    from tablegen.evidence.page import render_page, render_text
    from tablegen.evidence.stability import run_study
    from tablegen.evidence.stability_cases import all_cases
    from tablegen.evidence.stability_text import study_section

    if friction is None:
        friction = STABILITY_FRICTION // (20 if quick else 1)
    study = run_study(
        load_config(pair),
        all_cases(quick),
        count=count,
        friction=friction,
        seed=seed,
        threads=threads,
        progress=progress,
    )
    section = study_section(study)
    click.echo(render_text([section]))
    if json_file:
        write_text(json_file, json_text(study.to_dict(), indent=None))
    if html_file:
        write_text(html_file, render_page(section.heading, [section]))
    return DONE if study.holds else MISSED
