"""Work of ``sampler export`` and ``tablegen export``."""

import sys
from pathlib import Path

from sampler.files.locate import find_table
from sampler.formats.binary import write_binary_table
from sampler.formats.hdf5 import read_table


def run(table: str, output: Path) -> int:
    """Write the image of a table, given by name or path; parameters are the options."""
    contents = read_table(find_table(table))
    write_binary_table(output, contents)
    sys.stdout.write(f"{output}: {output.stat().st_size / 1e6:.2f} MB, {contents.pair}\n")
    return 0
