"""``tablegen export``: its options and its help."""

from typing import Any

import click

from sampler.compilation.late import work
from tablegen.commands import options


@click.command(
    short_help="Write a table as an image for C, C++ and Fortran.",
    epilog=options.examples("tablegen export corundum-steel --output corundum-steel.rbt"),
)
@click.argument("table", type=options.TABLE, metavar="T.h5|NAME")
@click.option(
    "--output", required=True, type=options.OUTPUT, metavar="T.rbt", help="File to write."
)
def export(**given: Any) -> int:
    """Write a table as an image (.rbt) that C, C++ and Fortran map into memory.

    The header that reads it lies in the folder that `python -m sampler --include-dir` prints.
    """
    return work("sampler.commands.export_command", **given)
