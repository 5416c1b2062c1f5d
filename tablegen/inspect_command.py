"""``tablegen inspect``: what a table is, from the command line."""

import json

import click

import sampler
from tablegen import options
from tablegen.summary import identity, identity_text
from tablegen.verdict import DONE


@click.command(
    short_help="Say what a table is.",
    epilog=options.examples(
        "tablegen inspect corundum-steel",
        "tablegen inspect my-pair.h5 --json",
        "tablegen inspect my-pair.h5 --config > my-pair.toml",
    ),
)
@click.argument("table", metavar="T.h5|NAME")
@click.option("--json", "as_json", is_flag=True, help="Print it for a program to read.")
@click.option("--config", is_flag=True, help="Print the configuration it was generated from.")
def inspect(table: str, as_json: bool, config: bool) -> int:
    """Say what a table is: provenance, range, nodes, size, measured accuracy."""
    if as_json and config:
        raise click.UsageError("--json: got it with --config, allowed: one of them")
    loaded = sampler.load(table)
    if as_json:
        click.echo(json.dumps(identity(loaded), indent=1, allow_nan=False))
    else:
        click.echo(loaded.config if config else identity_text(loaded))
    return DONE
