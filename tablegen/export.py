"""``tablegen export``: a table as an image for programs in C and Fortran."""

from pathlib import Path

import click

from sampler.image import write_image
from sampler.locate import find_table
from sampler.schema import read_table
from tablegen import options


@click.command(
    short_help="Write a table as an image for C, C++ and Fortran.",
    epilog=options.examples("tablegen export corundum-steel --output corundum-steel.rbt"),
)
@click.argument("table", metavar="T.h5")
@click.option(
    "--output", required=True, type=options.OUTPUT, metavar="T.rbt", help="File to write."
)
def export(table: str, output: Path) -> int:
    """Write a table as an image (.rbt) that C, C++ and Fortran map into memory.

    The header that reads it lies in the folder that `python -m sampler --include-dir` prints.
    """
    contents = read_table(find_table(table))
    write_image(output, contents)
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB, {contents.pair}")
    return 0
