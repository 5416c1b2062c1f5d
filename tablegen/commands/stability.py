"""``tablegen stability``: the model on extreme particles and impacts."""

from pathlib import Path

import click

from sampler import options
from sampler.files import write_text
from sampler.formats.shape_codes import SHAPE_NAMES
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
        "tablegen stability --shape prism --aspect 0.02 0.02 --alpha 0.01 --count 1000",
        "tablegen stability --shape sphere --count 1 --friction 250000 --threads 1",
    ),
)
@click.argument("pair", type=CONFIG, metavar="[PAIR|CONFIG.toml]", default="corundum-steel")
@click.option("--quick", is_flag=True, help="2,368 cases: some 20 seconds on two cores.")
@shared.count(STABILITY_COUNT, "Particles a case.")
@click.option(
    "--friction",
    type=options.Integer(0, 2**40),
    metavar="N",
    help="Particles under each of 44 laws of Coulomb friction.  [default: 20000; with --quick "
    "1000; 0 where values of the study are replaced]",
)
@options.seed("Seed of the particles.")
@click.option("--shape", type=click.Choice(SHAPE_NAMES), multiple=True, help="Only this shape.")
@click.option(
    "--aspect",
    type=shared.RATIO,
    nargs=2,
    multiple=True,
    metavar="BA CB",
    help="Only these b/a and c/b.",
)
@click.option(
    "--alpha", type=shared.ANGLE, multiple=True, metavar="DEG", help="Only this impact angle."
)
@click.option("--speed", type=shared.SPEED, multiple=True, metavar="M_S", help="Only this speed.")
@click.option(
    "--spin", type=shared.SPIN, multiple=True, metavar="WZ", help="Only this spin, times a/V."
)
@options.threads
@options.json_file("Write every case.")
@options.html_file
@options.progress
def stability(
    pair: str,
    quick: bool,
    count: int,
    friction: int | None,
    seed: int,
    shape: tuple[str, ...],
    aspect: tuple[tuple[float, float], ...],
    alpha: tuple[float, ...],
    speed: tuple[float, ...],
    spin: tuple[float, ...],
    threads: int | None,
    json_file: Path | None,
    html_file: Path | None,
    progress: bool,
) -> int:
    """Simulate extreme particles and impacts, and check the model in each.

    The whole study has 28,280 cases: five shapes; b/a and c/b of 1, 0.999, 0.5, 0.05 and 0.02;
    angles from 0.01 to 90 degrees; speeds from 1 to 3,000 m/s; spins before the impact of 0, 1, 5
    and 50 V/a along the wall axis z, the normal of the impact plane, both ways. It takes some ten
    minutes on two cores. Options that name values replace those of the study, and may be repeated.

    Under Coulomb's law random particles of the pair's population hit at random angles, speeds and
    spins, with coefficients of friction from 0.1 to 100 and restitutions from 0 to 1.

    Each case runs three times on the same particles: as usual, with half the contact resolution,
    and with half the tolerance of the flight. Exit status 1 if a particle is not finite, does not
    finish, gains energy or is not separated from the wall.
    """
    from tablegen.config.config import load_config
    from tablegen.evidence.page import render_page, render_text
    from tablegen.evidence.stability import run_study
    from tablegen.evidence.stability_cases import FULL, QUICK, Grid
    from tablegen.evidence.stability_text import study_json, study_section

    axes = Grid(shape, aspect, alpha, speed, spin)
    if friction is None:
        friction = 0 if axes != Grid() else STABILITY_FRICTION // (20 if quick else 1)
    study = run_study(
        load_config(pair),
        list((QUICK if quick else FULL).narrowed(axes).cases()),
        count=count,
        friction=friction,
        seed=seed,
        threads=threads,
        progress=progress,
    )
    section = study_section(study)
    click.echo(render_text([section]))
    if json_file:
        write_text(json_file, study_json(study))
    if html_file:
        write_text(html_file, render_page(section.heading, [section]))
    return DONE if study.holds else MISSED
