"""Write all that a code in C, C++ or Fortran needs to one folder: ``sampler vendor``."""

import os
import secrets
import shutil
from collections.abc import Mapping
from pathlib import Path

from sampler.errors import InputError, OutputError
from sampler.files import check_output, find_table

_PACKAGE = Path(__file__).resolve().parent

#: What is copied, by its name in the folder; the licence is that of the checkout or of the wheel.
_FILES = {
    "README.md": _PACKAGE / "c" / "vendored.md",
    "LICENSE": next(p for p in (_PACKAGE / "LICENSE", _PACKAGE.parent / "LICENSE") if p.exists()),
    "tracker.f90": _PACKAGE / "fortran" / "tracker.f90",
} | {
    name: _PACKAGE / "c" / name
    for name in (
        "rebound_sampler.h",
        "rebound_device.h",
        "rebound_sampler.c",
        "rebound_sampler.f90",
        "tracker.c",
        "tracker.cu",
        "CMakeLists.txt",
        "rebound_sampler-config.cmake",
        "rebound_sampler-config-version.cmake",
        "rebound_sampler.pc",
    )
}


def table_files(tables: tuple[str, ...]) -> dict[str, Path]:
    """Find the tables by the names that they get in the folder; raises `InputError`."""
    files: dict[str, Path] = {}
    for name_or_path in tables:
        path = find_table(name_or_path)
        name = f"{path.stem}.rbt"
        if files.setdefault(name, path) != path:
            problem = f"{files[name]} and {path} would both become {name}"
            raise InputError("table", problem=problem, remedy="rename one of them")
    return files


def check_folder(folder: Path) -> None:
    """Refuse a folder that exists or cannot be made; raises `OutputError`."""
    if os.path.lexists(folder):
        what = "is a file" if folder.is_file() else "exists"
        raise OutputError(path=folder, problem=f"{folder} {what}", remedy="give a new folder")
    check_output(folder)


def write_folder(folder: Path, tables: Mapping[str, Path]) -> None:
    """Write a folder that does not exist yet, whole or not at all.

    Parameters
    ----------
    folder : Path
    tables : mapping of str to Path
        Tables (.h5) by the names of their binary tables (.rbt), as `table_files` gives them.

    Raises
    ------
    InputError
        If a table cannot be used, or the folder cannot be written.
    """
    from sampler.formats.hdf5 import read_table
    from sampler.formats.image import write_binary_table

    check_folder(folder)
    temporary = folder.with_name(f".{folder.name[:40]}.{secrets.token_hex(8)}.tmp")
    try:
        temporary.mkdir()
        for name, source in _FILES.items():
            shutil.copyfile(source, temporary / name)
        for name, source in tables.items():
            write_binary_table(temporary / name, read_table(source))
        temporary.rename(folder)
    except OSError as error:
        raise OutputError(
            path=folder, problem=f"cannot write {folder}: {error.strerror}"
        ) from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
