"""``tablegen demo``: the main job in one go."""

from pathlib import Path

import click
from sampler.options import DONE, MISSED

from sampler import options


@click.command(
    cls=options.Command,
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
def demo(output: Path, progress: bool) -> int:
    """Generate a small table, draw from it, validate it: the main job in one go.

    Next to the table goes a picture of the joint density of u and v, from direct simulation and
    from the table, if matplotlib is installed.
    """
    from tablegen.commands.demo_run import run_demo

    return MISSED if run_demo(output, click.echo, progress).missed else DONE
