"""``tablegen validate``: a table compared with fresh direct simulation."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sampler.commands import options
from sampler.commands.program import DONE, MISSED
from sampler.errors import InputError
from sampler.files.atomic import write_text
from sampler.files.json_text import json_text
from tablegen.accuracy.verdict import verdict_words
from tablegen.commands import bounded
from tablegen.config.defaults import VALIDATE_CONDITIONS, VALIDATE_SPIN_CONDITIONS

if TYPE_CHECKING:
    from tablegen.accuracy.comparison import Comparison
    from tablegen.accuracy.validate import Place, Validation

#: Spinning conditions.
_COUNT = options.Integer(0, 10_000)


@click.command(
    cls=options.Command,
    short_help="Compare a table with fresh direct simulation.",
    epilog=options.examples(
        "tablegen validate corundum-steel",
        "tablegen validate my-pair.h5 --accuracy standard --conditions 20 --json accuracy.json",
        "tablegen validate my-pair.h5 --alpha 30 --speed 120 --alpha 45 --speed 260",
        "tablegen validate my-pair.h5 --alpha 30 --speed 120 --spin 0.2 0 -0.8",
    ),
)
@options.table
@click.option(
    "--conditions",
    type=options.CONDITIONS,
    default=VALIDATE_CONDITIONS,
    show_default=True,
    help="Conditions between nodes to compare at, spread evenly over angle and speed.",
)
@click.option(
    "--alpha",
    type=options.ANGLE,
    multiple=True,
    metavar="DEG",
    help="Impact angle to compare at, and nowhere else; repeatable, with --speed.",
)
@click.option(
    "--speed",
    type=options.POSITIVE,
    multiple=True,
    metavar="M_S",
    help="Impact speed to compare at; the first goes with the first --alpha.",
)
@click.option(
    "--spin",
    type=bounded.SPIN,
    nargs=3,
    multiple=True,
    metavar="WX WY WZ",
    help="Spin before the impact, times a/V, to compare at; repeatable, with --alpha and --speed.",
)
@click.option(
    "--spin-conditions",
    type=_COUNT,
    default=VALIDATE_SPIN_CONDITIONS,
    show_default=True,
    help="Spinning conditions to compare a spin law at; 0 leaves it out.",
)
@click.option(
    "--accuracy",
    metavar="A",
    help="What to hold the table against: compact, standard or fine, or limits such as "
    "ks=0.01,auc=0.56, of a spin law spin_ks=0.03. By default what the table declares.",
)
@click.option(
    "--seed",
    type=options.SEED,
    metavar="S",
    help="Seed of the conditions and of both samples; by default another one each time, printed.",
)
@click.option(
    "--samples",
    type=options.SAMPLES,
    help="States a side at first; by default as many as the accuracy needs, at least 100000. "
    "Where noise leaves the verdict open, up to nine times as many.",
)
@click.option(
    "--store",
    is_flag=True,
    help="Write what was measured between nodes into the table, in place of what it stores.",
)
@options.json_file("Write every number.")
@options.html_file
@click.option("--details", is_flag=True, help="Means and modes at every condition.")
@options.progress
def validate(
    table: str,
    conditions: int,
    alpha: Sequence[float],
    speed: Sequence[float],
    spin: Sequence[tuple[float, float, float]],
    spin_conditions: int,
    accuracy: str | None,
    seed: int | None,
    samples: int | None,
    store: bool,
    json_file: Path | None,
    html_file: Path | None,
    details: bool,
    progress: bool,
) -> int:
    """Compare a table with fresh direct simulation: all nodes coarsely, some conditions closely.

    KS: largest Kolmogorov-Smirnov distance of a variable. Sliced W: sliced Wasserstein distance
    of the standardised states. Corr.: largest error of a correlation. AUC: how well a classifier
    tells table from direct; 0.5 = it cannot. Each stands next to the noise that finite samples add.
    A spin law is compared at conditions of its own, and over the impacts that occur in chains.
    Exit status 1 if the accuracy is missed by more than noise.
    """
    from tablegen.accuracy.validate import validate as compare
    from tablegen.accuracy.validation_text import whose
    from tablegen.evidence.page import validation_page
    from tablegen.tables.stored_accuracy import check_store, store_accuracy

    at = _conditions(alpha, speed, spin)
    if store:
        check_store(table, at is not None)
    result = compare(
        table,
        conditions=conditions,
        spin_conditions=spin_conditions,
        seed=seed,
        samples=samples,
        accuracy=accuracy,
        at=at,
        progress=progress,
    )
    _print_comparisons(result, details)
    if json_file:
        write_text(json_file, json_text(result.to_dict()))
    if html_file:
        write_text(html_file, validation_page(result))
    if store:
        click.echo(f"{table}: accuracy stored, content SHA-256 {store_accuracy(table, result)}")
    return print_verdict(result.missed, result.undecided, whose(result))


def _conditions(
    alpha: Sequence[float], speed: Sequence[float], spin: Sequence[tuple[float, float, float]]
) -> "list[Place] | None":
    """Put angles, speeds and spins together; one of any goes with all of the others."""
    if not alpha and not speed and not spin:
        return None
    count = max(len(alpha), len(speed), len(spin))
    if {len(alpha), len(speed)} - {1, count} or not alpha or not speed:
        raise InputError(
            f"--alpha and --speed: got {len(alpha)} and {len(speed)}, allowed: as many of both, "
            "or one of either"
        )
    if len(spin) not in (0, 1, count):
        raise InputError(f"--spin: got {len(spin)}, allowed: one, or {count} as of the others")
    alphas, speeds = (list(given) * (count // len(given)) for given in (alpha, speed))
    if not spin:
        return list(zip(alphas, speeds, strict=True))
    return list(zip(alphas, speeds, list(spin) * (count // len(spin)), strict=True))


def _print_comparisons(result: "Validation", details: bool) -> None:
    """Print every comparison, details of the worst or of all, and what was looked at."""
    from tablegen.accuracy.accuracy_text import accuracy_text, details_text
    from tablegen.accuracy.spin_text import spin_report
    from tablegen.accuracy.validation_text import certainty_line, coverage_lines

    allowed = result.declared, result.asked, result.together
    if result.comparisons:
        click.echo(accuracy_text(result.comparisons, *allowed))
    if result.nodes:
        click.echo("at the nodes that looked worst")
        click.echo(accuracy_text(result.nodes, *allowed))
    for some in (result.comparisons, result.spin.measured.comparisons if result.spin else []):
        for comparison in some if details else _worst(some):
            click.echo(details_text(comparison))
    if result.spin:
        spin = result.spin
        for line in spin_report(spin.measured, spin.declared, spin.asked, result.together):
            click.echo(line)
    for line in (*coverage_lines(result), certainty_line()):
        click.echo(line)


def _worst(comparisons: "Sequence[Comparison]") -> "Sequence[Comparison]":
    """Pick the condition where a classifier tells most, if there is one."""
    return sorted(comparisons, key=lambda c: -c.estimates["auc"].value)[:1]


def print_verdict(
    missed: Sequence[str], undecided: Sequence[str] = (), accuracy: str = "declared accuracy"
) -> int:
    """Print what was missed and what could not be decided; returns the exit status.

    Parameters
    ----------
    missed, undecided, accuracy
        As for `tablegen.accuracy.verdict.verdict_words`.
    """
    for line in missed:
        click.echo(f"missed: {line}")
    for line in undecided:
        click.echo(f"undecided: {line}")
    if missed:
        return MISSED
    click.echo(verdict_words(missed, undecided, accuracy).rstrip(":") + "." * bool(undecided))
    return DONE
