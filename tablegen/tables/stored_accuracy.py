"""A measured accuracy written into the table that was measured."""

from dataclasses import replace
from pathlib import Path

from sampler.errors import InputError
from sampler.files.atomic import check_output
from sampler.files.locate import find_table
from sampler.formats.hdf5 import read_table, write_table
from tablegen.accuracy.measure import spin_accuracy_datasets
from tablegen.accuracy.validate import Validation
from tablegen.tables.assembly import accuracy_datasets


def check_store(table: str | Path, chosen: bool) -> None:
    """Refuse, before anything is measured, what could not be stored.

    Parameters
    ----------
    table : str or Path
    chosen : bool
        Whether the user chose the conditions: those that are stored are spread evenly.

    Raises
    ------
    InputError
        If conditions were chosen, or the table is not named by its path or may not be written.
    """
    if chosen:
        raise InputError("--store: got it with --alpha and --speed, allowed: without them")
    if find_table(table) != Path(table):
        raise InputError(f"--store: got the name '{table}', allowed: the path of a .h5 file")
    check_output(table)


def store_accuracy(path: str | Path, validation: Validation) -> str:
    """Replace the accuracy stored in a table file; everything else stays.

    Parameters
    ----------
    path : str or Path
        The .h5 file that was validated.
    validation : Validation
        Its comparisons between nodes are stored, and those of the spin law if it was looked at:
        distances with the noise of the samples.

    Returns
    -------
    str
        New checksum of the contents.

    Raises
    ------
    InputError
        If the file is another than when it was measured, or cannot be written.
    """
    contents = read_table(path)
    if contents.content_sha256 != validation.content_sha256:
        raise InputError(f"{path}: changed since it was measured, allowed: the file as it was")
    measured = accuracy_datasets(validation.law.measured.comparisons, len(contents.variables))
    if validation.spin is not None:
        measured |= spin_accuracy_datasets(validation.spin.measured)
    contents = replace(contents, datasets={**contents.datasets, **measured})
    write_table(path, contents)
    return contents.content_sha256
