"""A measured accuracy written into the table that was measured."""

from dataclasses import replace
from pathlib import Path

from sampler.errors import InputError
from sampler.files import check_output, find_table
from sampler.formats.hdf5 import read_table, write_table
from tablegen.accuracy.measure import spin_accuracy_datasets
from tablegen.accuracy.validate import Validation
from tablegen.tables.assembly import accuracy_datasets


def check_store(table: str | Path, chosen: bool) -> None:
    """Refuse a table whose accuracy could not be stored, before anything is measured.

    It must be named by its path and be writable. ``chosen`` says whether the user chose the
    conditions; stored ones are evenly spread.
    """
    if chosen:
        raise InputError("--store: got it with --alpha and --speed, allowed: without them")
    if find_table(table) != Path(table):
        raise InputError(f"--store: got the name '{table}', allowed: the path of a .h5 file")
    check_output(table)


def store_accuracy(path: str | Path, validation: Validation) -> str:
    """Replace the accuracy stored in a table file; returns the new checksum of its contents.

    The distances between nodes are stored, noise included, and those of the spin law if it was
    compared. `InputError` says if the file changed since it was measured, or cannot be written.
    """
    contents = read_table(path)
    if contents.content_sha256 != validation.content_sha256:
        raise InputError(f"{path}: changed since it was measured, allowed: the file as it was")
    measured = accuracy_datasets(validation.comparisons, len(contents.variables))
    if validation.spin is not None:
        measured |= spin_accuracy_datasets(validation.spin.measured)
    contents = replace(contents, datasets={**contents.datasets, **measured})
    write_table(path, contents)
    return contents.content_sha256
