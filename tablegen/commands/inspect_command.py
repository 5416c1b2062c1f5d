"""``tablegen inspect``: what a table is, from the command line."""

import json

import click

from sampler.files.locate import find_table
from sampler.formats.hdf5 import read_table
from tablegen.accuracy.verdict import DONE
from tablegen.commands.table_identity import identity, identity_text


def run(table: str, as_json: bool, config: bool) -> int:
    """Run ``tablegen inspect``; parameters are the options of `tablegen.commands.inspect`."""
    if as_json and config:
        raise click.UsageError("--json: got it with --config, allowed: one of them")
    contents = read_table(find_table(table))
    if as_json:
        click.echo(json.dumps(identity(contents), indent=1, allow_nan=False))
    else:
        click.echo(contents.config if config else identity_text(contents))
    return DONE
