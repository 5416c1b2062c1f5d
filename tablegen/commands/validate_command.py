"""Work of ``tablegen validate``."""

import json
from collections.abc import Sequence
from pathlib import Path

import click

from sampler.errors import InputError
from sampler.files.atomic import write_text
from tablegen.accuracy.verdict import verdict
from tablegen.studies.validation.accuracy_text import accuracy_text, details_text
from tablegen.studies.validation.stored_accuracy import check_store, store_accuracy
from tablegen.studies.validation.validation_page import validation_page
from tablegen.studies.validation.validation_text import certainty_line, coverage_lines, whose
from tablegen.validate import validate


def run(
    table: str,
    conditions: int,
    alpha: Sequence[float],
    speed: Sequence[float],
    accuracy: str | None,
    seed: int | None,
    samples: int | None,
    store: bool,
    json_file: Path | None,
    html_file: Path | None,
    details: bool,
    progress: bool,
) -> int:
    """Run ``tablegen validate``; parameters are the options of `tablegen.commands.validate`."""
    at = _conditions(alpha, speed)
    if store:
        check_store(table, at is not None)
    result = validate(
        table,
        conditions=conditions,
        seed=seed,
        samples=samples,
        accuracy=accuracy,
        at=at,
        progress=progress,
    )
    allowed = result.declared, result.asked, len(result.measured)
    click.echo(accuracy_text(result.comparisons, *allowed))
    if result.nodes:
        click.echo("at the nodes that looked worst")
        click.echo(accuracy_text(result.nodes, *allowed))
    worst = max(result.comparisons, key=lambda c: c.estimates["auc"].value)
    for comparison in result.comparisons if details else [worst]:
        click.echo(details_text(comparison))
    for line in (*coverage_lines(result), certainty_line()):
        click.echo(line)
    if json_file:
        write_text(json_file, json.dumps(result.to_dict(), indent=1) + "\n")
    if html_file:
        write_text(html_file, validation_page(result))
    if store:
        click.echo(f"{table}: accuracy stored, content SHA-256 {store_accuracy(table, result)}")
    return verdict(result.missed, result.undecided, whose(result))


def _conditions(alpha: Sequence[float], speed: Sequence[float]) -> list[tuple[float, float]] | None:
    """Pair the angles with the speeds; one of either goes with all of the other."""
    if not alpha and not speed:
        return None
    count = max(len(alpha), len(speed))
    if {len(alpha), len(speed)} - {1, count} or not alpha or not speed:
        raise InputError(
            f"--alpha and --speed: got {len(alpha)} and {len(speed)}, allowed: as many of both, "
            "or one of either"
        )
    alphas, speeds = (list(given) * (count // len(given)) for given in (alpha, speed))
    return list(zip(alphas, speeds, strict=True))
