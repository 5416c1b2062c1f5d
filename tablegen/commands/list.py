"""``tablegen list``: its options and its help."""

from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options


@click.command(
    "list",
    short_help="List tables, pairs and scenes that have a name.",
    epilog=options.examples("tablegen list", "tablegen list --json"),
)
@click.option("--json", "as_json", is_flag=True, help="Print it for a program to read.")
def list_names(**given: Any) -> int:
    """List the tables, material pairs and scenes that come with the package, by name.

    A name stands for its file wherever a command takes a table, a pair or a scene.
    """
    return work("sampler.commands.list_command", **given)
