"""``tablegen prune``: its options and its help."""

from typing import Any

import click

from sampler.late import work
from tablegen import options


@click.command(
    short_help="Cut a table to what a scene needs.",
    epilog=options.examples(
        "tablegen prune corundum-steel --scene plane-flow --output plane.h5",
        "tablegen prune my-table.h5 --scene my-scene.toml --output small.h5",
    ),
)
@click.argument("table", type=options.TABLE, metavar="T.h5|NAME")
@click.option(
    "--scene",
    required=True,
    type=options.CONFIG,
    metavar="SCENE.toml",
    help="What to keep: a name, or a path.",
)
@click.option("--output", required=True, type=options.OUTPUT, metavar="S.h5", help="File to write.")
def prune(**given: Any) -> int:
    """Cut a table to the components, angles and speeds that a scene needs.

    What stays gives the same draws as the full table for the same keys.
    """
    return work("tablegen.prune_command", **given)
