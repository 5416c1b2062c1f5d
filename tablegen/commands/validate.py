"""``tablegen validate``: compare a table with new direct simulation."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sampler import options
from sampler.errors import InputError
from sampler.files import json_text, write_text
from sampler.options import DONE, MISSED
from tablegen.commands import shared

if TYPE_CHECKING:
    from sampler.formats.hdf5 import TableContents
    from tablegen.accuracy.validate import Validation


@click.command(
    cls=options.Command,
    short_help="Compare a table with new direct simulation.",
    epilog=options.examples(
        "tablegen validate corundum-steel",
        "tablegen validate my-pair.h5 --accuracy standard --conditions 20 --json accuracy.json",
        "tablegen validate my-pair.h5 --alpha 30 --speed 120 --alpha 45 --speed 260",
    ),
)
@options.table
@shared.conditions("Number of conditions between nodes, evenly spread over angle and speed.")
@click.option(
    "--alpha",
    type=options.ANGLE,
    multiple=True,
    metavar="DEG",
    help="Compare only at this angle from the wall, degrees; may be given several times.",
)
@click.option(
    "--speed",
    type=options.POSITIVE,
    multiple=True,
    metavar="M_S",
    help="Impact speed that goes with --alpha, m/s: one for all angles, or one for each.",
)
@click.option(
    "--accuracy",
    metavar="A",
    help="Accuracy to judge the table by: compact, standard, fine, or limits such as "
    "ks=0.01,auc=0.56,spin_chain_ks=0.03. By default it is the accuracy that the table declares.",
)
@click.option(
    "--seed",
    type=options.SEED,
    metavar="S",
    help="Seed of the conditions and of all random numbers; by default random, and printed.",
)
@click.option(
    "--samples",
    type=options.SAMPLES,
    help="Number of states from the table, and of simulated ones, at each condition; by default as "
    "many as the accuracy needs, at least 100000.",
)
@click.option("--store", is_flag=True, help="Store the measured distances in the table.")
@options.json_file("Write all numbers to this JSON file.")
@options.html_file
@options.overwrite
@click.option(
    "--details", is_flag=True, help="Print distances, means and modes at every condition."
)
@options.progress
def validate(
    table: str,
    alpha: Sequence[float],
    speed: Sequence[float],
    store: bool,
    json_file: Path | None,
    html_file: Path | None,
    details: bool,
    **settings: Any,
) -> int:
    """Compare a table with new direct simulation at conditions between its nodes.

    Four distances are measured: ks is the largest Kolmogorov-Smirnov distance of a variable;
    sliced_wasserstein is the sliced Wasserstein distance of the standardised states;
    correlation_error is the largest error of a correlation; auc says how well a classifier tells
    the table from direct simulation (0.5: it cannot).

    A spin law is compared at impacts without spin, and along chains of sixty hits, in a cylinder
    and between walls of any direction. Chains are compared by ks, the kept energy, the squared
    spin, the median angle, and the shares of slow and of flat departures.

    A number holds if number - 3 error is within its limit. If the accuracy is missed, the exit
    status is 1, and a line says what to change. A table of spheres must agree with direct
    simulation within rounding errors.
    """
    import tablegen
    from sampler.files import find_table
    from sampler.formats.hdf5 import read_table
    from tablegen.accuracy.validation_page import validation_page
    from tablegen.tables.assembly import check_store, store_accuracy

    at = _conditions(alpha, speed)
    contents = read_table(find_table(table))
    if contents.of_spheres:
        if settings.get("accuracy") is not None or at or store or json_file or html_file or details:
            problem, remedy = "a table of spheres is exact", "of all options, only --seed applies"
            raise InputError("", problem=problem, remedy=remedy, source=table)
        return print_spheres(contents, settings["seed"])
    if store:
        check_store(table, at is not None)
    result = tablegen.validate(table, at=at, **settings)
    if json_file:
        write_text(json_file, json_text(result.to_dict()))
    if html_file:
        write_text(html_file, validation_page(result))
    checksum = store_accuracy(table, result) if store else None
    print_validation(result, details)
    if checksum is not None:
        click.echo(f"{table}: accuracy stored, content SHA-256 {checksum}")
    return MISSED if result.missed else DONE


def _conditions(alpha: Sequence[float], speed: Sequence[float]) -> list[Any] | None:
    """Pair angles with speeds; if there is one angle or one speed, it goes with all others."""
    if not alpha and not speed:
        return None
    count = max(len(alpha), len(speed))
    if {len(alpha), len(speed)} - {1, count} or not alpha or not speed:
        problem = f"there are {len(alpha)} angles and {len(speed)} speeds"
        remedy = "give one speed for each angle, one speed for all angles, or one angle"
        raise InputError("--alpha and --speed", problem=problem, remedy=remedy)
    columns = [list(c) * (count // len(c)) for c in (alpha, speed)]
    return list(zip(*columns, strict=True))


def print_validation(result: "Validation", details: bool = False) -> None:
    """Print whether the accuracy holds, what to change, all numbers, and how they were measured."""
    from tablegen.accuracy.accuracy_text import (
        detail_tables,
        numbers_table,
        validation_notes,
        verdict_lines,
    )

    for line in verdict_lines(result):
        click.echo(line)
    tables = [numbers_table(result.numbers, result.stored)]
    for table in tables + (detail_tables(result) if details else []):
        click.echo(f"\n{table}")
    click.echo()
    for line in validation_notes(result):
        click.echo(line)


def print_spheres(contents: "TableContents", seed: int | None) -> int:
    """Print how far a table of spheres is from direct simulation, and return the exit status."""
    from tablegen.tables.spheres import ROUNDING, largest_difference

    difference = largest_difference(contents, seed)
    holds = difference <= ROUNDING
    click.echo(
        f"{'holds' if holds else 'MISSED'}: draws differ from direct simulation by at most "
        f"{difference:.1e}; {ROUNDING:g} is allowed"
    )
    return DONE if holds else MISSED
