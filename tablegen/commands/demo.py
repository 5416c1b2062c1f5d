"""``tablegen demo``: its options and its help."""

from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options


@click.command(
    short_help="Generate a small table, draw from it, validate it.",
    epilog=options.examples("tablegen demo", "tablegen demo --output small.h5"),
)
@click.option(
    "--output",
    type=options.OUTPUT,
    default="demo.h5",
    show_default=True,
    metavar="T.h5",
    help="Table to write.",
)
@options.progress
def demo(**given: Any) -> int:
    """Generate a small table, draw from it, validate it: the main job in one go.

    Beside the table goes a picture of the joint density of u and v, direct simulation beside the
    table, if matplotlib is installed.
    """
    return work("tablegen.commands.demo_command", **given)
