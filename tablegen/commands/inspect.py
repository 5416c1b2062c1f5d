"""``tablegen inspect``: its options and its help."""

from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options


@click.command(
    short_help="Say what a table is.",
    epilog=options.examples(
        "tablegen inspect corundum-steel",
        "tablegen inspect my-pair.h5 --json",
        "tablegen inspect my-pair.h5 --config > my-pair.toml",
    ),
)
@click.argument("table", type=options.TABLE, metavar="T.h5|NAME")
@click.option("--json", "as_json", is_flag=True, help="Print it for a program to read.")
@click.option("--config", is_flag=True, help="Print the configuration it was generated from.")
def inspect(**given: Any) -> int:
    """Say what a table is: provenance, range, nodes, size, measured accuracy."""
    return work("tablegen.commands.inspect_command", **given)
