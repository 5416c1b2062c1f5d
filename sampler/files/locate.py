"""Material pairs, scenes, tables and measurements found by name.

They are installed inside this package; in a source checkout they lie in ``tables`` beside it.
"""

import os
from pathlib import Path

from sampler.errors import InputError
from sampler.files import check_input

_PACKAGE = Path(__file__).resolve().parents[1]

#: Folders within that of the data, by the suffix of the files that lie there.
_FOLDERS = {".csv": "measurements"}


def data_directory() -> Path:
    """Folder of the pairs, scenes, tables and measurements that come with the package.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the package was installed without them.
    """
    for folder in (_PACKAGE / "_tables", _PACKAGE.parent / "tables"):
        if folder.is_dir():
            return folder
    raise InputError(f"data folder: none in {_PACKAGE}, allowed: an installation with its tables")


def include_directory() -> Path:
    """Folder of the C header and the Fortran module, which come inside this package."""
    return _PACKAGE / "c"


def available(suffix: str) -> list[str]:
    """Names of the files that come with the package, sorted.

    Parameters
    ----------
    suffix : str
        ``".h5"`` for tables, ``".toml"`` for pairs and scenes, ``".csv"`` for measurements.
    """
    return sorted(path.stem for path in _folder_of(suffix).glob(f"*{suffix}"))


def _folder_of(suffix: str) -> Path:
    """Folder of the shipped files with a suffix."""
    return data_directory() / _FOLDERS.get(suffix, "")


def find_file(what: str, name_or_path: str | os.PathLike[str], suffix: str) -> Path:
    """File of a name, or of a path.

    A bare word is a name first and a path only if no such name exists, so that what a name means
    does not depend on the working folder. Anything with a folder or the suffix in it is a path.

    Parameters
    ----------
    what : str
        What is looked for, for the error message.
    name_or_path : str or path-like
    suffix : str
        As for `available`.

    Returns
    -------
    Path
        A regular file that can be read.

    Raises
    ------
    InputError
        If there is no such file or name, or it is something else than a regular file.
    """
    path = Path(name_or_path)
    is_word = isinstance(name_or_path, str) and path.name == name_or_path and path.suffix != suffix
    if is_word and name_or_path in available(suffix):
        return _folder_of(suffix) / f"{name_or_path}{suffix}"
    # os.path answers False where Path.exists raises, for names that are too long for example.
    if is_word and not os.path.lexists(path):
        names = ", ".join(available(suffix)) or "none are installed"
        allowed = f"a name ({names}) or the path of a {suffix} file"
        raise InputError(f"{what}: got '{name_or_path}', allowed: {allowed}")
    return check_input(what, path, f"a {suffix} file")


def find_table(name_or_path: str | os.PathLike[str]) -> Path:
    """Table file (.h5) of a name or path; raises `InputError` as `find_file`."""
    return find_file("table", name_or_path, ".h5")


def find_config(name_or_path: str | os.PathLike[str]) -> Path:
    """Material pair or scene (.toml) of a name or path; raises `InputError` as `find_file`."""
    return find_file("configuration", name_or_path, ".toml")


def find_measurements(name_or_path: str | os.PathLike[str]) -> Path:
    """Measured rebounds (.csv) of a name or path; raises `InputError` as `find_file`."""
    return find_file("measurements", name_or_path, ".csv")
