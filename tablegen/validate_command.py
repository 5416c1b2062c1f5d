"""Work of ``tablegen validate``."""

import json
from pathlib import Path

import click

from sampler.atomic import write_text
from tablegen.page import validation_page
from tablegen.summary import accuracy_text, details_text
from tablegen.validate import validate
from tablegen.verdict import verdict


def run(
    table: str,
    conditions: int,
    seed: int,
    samples: int | None,
    json_file: Path | None,
    html_file: Path | None,
    details: bool,
    progress: bool,
) -> int:
    """Run ``tablegen validate``; parameters are the options of `tablegen.commands.validate`."""
    result = validate(table, conditions=conditions, seed=seed, samples=samples, progress=progress)
    click.echo(accuracy_text(result.comparisons, result.declared))
    worst = max(result.comparisons, key=lambda c: c.auc)
    for comparison in result.comparisons if details else [worst]:
        click.echo(details_text(comparison))
    if json_file:
        write_text(json_file, json.dumps(result.to_dict(), indent=1) + "\n")
    if html_file:
        write_text(html_file, validation_page(result))
    return verdict(result.missed)
