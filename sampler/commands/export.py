"""``sampler export`` and ``tablegen export``: a table for C, C++, Fortran and OpenFOAM."""

from pathlib import Path

import click

from sampler import options
from sampler.options import DONE


@click.command(
    cls=options.Command,
    short_help="Write a table as a binary table for C, C++, Fortran and OpenFOAM.",
    epilog=options.examples(
        "PROGRAM export corundum-steel --output corundum-steel.rbt",
        "PROGRAM export my-table.h5 --output my-table.rbt",
    ),
)
@options.table
@options.output("T.rbt")
def export(table: str, output: Path) -> int:
    """Write a table as a binary table (.rbt) that C, C++ and Fortran map into memory.

    The header that reads it lies in the folder that `python -m sampler --include-dir` prints.
    """
    from sampler.files import find_table
    from sampler.formats.hdf5 import read_table
    from sampler.formats.image import write_binary_table

    contents = read_table(find_table(table))
    write_binary_table(output, contents)
    click.echo(f"{output}: {output.stat().st_size / 1e6:.2f} MB, {contents.pair}")
    return DONE
