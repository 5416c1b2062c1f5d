"""Files that come with the package, by name; input files; outputs written whole or not at all."""

import json
import math
import os
import re
import secrets
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

from sampler.errors import InputError, OutputError

_PACKAGE = Path(__file__).resolve().parent

#: Folders within that of the data, by the suffix of the files that lie there.
_FOLDERS = {".csv": "measurements"}

_FIELD = re.compile(r"#\s*([a-z][a-z_]*):\s+(\S.*)")

#: A decimal number. Python's `float` also takes 1_20 for 120, and the digits of other scripts.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)

#: Outputs that no file had the name of when they were checked, until they are written. Whoever
#: checks an output before long work and whoever writes it at the end share nothing but its path.
_absent: set[str] = set()


def data_directory() -> Path:
    """Return the folder of the pairs, scenes, tables and measurements that come with the package.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the package was installed without these files.

    Examples
    --------
    >>> import sampler
    >>> (sampler.data_directory() / "corundum-steel.toml").exists()
    True
    """
    for folder in (_PACKAGE / "_tables", _PACKAGE.parent / "tables"):
        if folder.is_dir():
            return folder
    problem = f"there is no folder of tables in {_PACKAGE}"
    raise InputError("installation", problem=problem, remedy="install rebound-tables again")


def include_directory() -> Path:
    """Give the folder of the C header and the Fortran module, which come inside this package."""
    return _PACKAGE / "c"


def available(suffix: str) -> list[str]:
    """List the names of the files that come with the package, sorted.

    Parameters
    ----------
    suffix : str
        ``".h5"`` for tables, ``".toml"`` for pairs and scenes, ``".csv"`` for measurements.
    """
    return sorted(path.stem for path in _folder_of(suffix).glob(f"*{suffix}"))


def _folder_of(suffix: str) -> Path:
    return data_directory() / _FOLDERS.get(suffix, "")


def find_file(what: str, name_or_path: str | os.PathLike[str], suffix: str) -> Path:
    """Find the file of a name or of a path.

    A bare word is a name first and a path only if no such name exists, so that the meaning of a
    name does not depend on the working folder. A word with a folder or the suffix is a path.

    Parameters
    ----------
    what : str
        Opens the error message: "table", "configuration".
    name_or_path : str or path-like
    suffix : str
        As for `available`.

    Raises
    ------
    InputError
        If there is no such file or name, or it is a folder.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        allowed = f"a name, or the path of a {suffix} file"
        raise InputError(what, type(name_or_path).__name__, allowed)
    path = Path(name_or_path)
    is_word = isinstance(name_or_path, str) and path.name == name_or_path and path.suffix != suffix
    if is_word and name_or_path in available(suffix):
        return _folder_of(suffix) / f"{name_or_path}{suffix}"
    # os.path answers False where Path.exists raises, for names that are too long for example
    if is_word and not os.path.exists(path):
        names = ", ".join(available(suffix)) or "none"
        problem = f"there is no {suffix} file '{name_or_path}'"
        raise InputError(what, problem=problem, remedy=f"the installed names are {names}")
    return check_input(what, path)


def find_table(name_or_path: str | os.PathLike[str]) -> Path:
    """Find the table file (.h5) of a name or path; raises `InputError` as `find_file`."""
    return find_file("table", name_or_path, ".h5")


def find_config(name_or_path: str | os.PathLike[str]) -> Path:
    """Find the pair or scene (.toml) of a name or path; raises `InputError` as `find_file`."""
    return find_file("configuration", name_or_path, ".toml")


def find_measurements(name_or_path: str | os.PathLike[str]) -> Path:
    """Find the measurements (.csv) of a name or path; raises `InputError` as `find_file`."""
    return find_file("measurements", name_or_path, ".csv")


def check_input(what: str, path: str | os.PathLike[str]) -> Path:
    """Refuse an input that is no file; raises `InputError`."""
    if not os.path.exists(path):
        raise InputError(what, problem=f"there is no file {path}")
    if not os.path.isfile(path):
        raise InputError(what, problem=f"{path} is a folder or device, not a file")
    return Path(path)


def read_file(what: str, path: str | os.PathLike[str]) -> bytes:
    """Read the bytes of a file; raises `InputError` if that cannot be done."""
    try:
        return check_input(what, path).read_bytes()
    except OSError as error:
        raise InputError(what, problem=f"cannot read {path}: {error.strerror}") from error


def check_output(path: str | Path) -> Path:
    """Refuse an output that cannot be written, before any work is done; raises `OutputError`.

    If no file has this name now, the write at the end does not replace one that appears until then.
    """
    given, target = _check_place(path)
    if is_stream(given):
        return given
    try:  # a permission says little: a folder of the system or a full disk takes no file either
        descriptor, probe = tempfile.mkstemp(prefix=f".{target.name[:40]}.", dir=target.parent)
    except OSError as error:
        raise _unwritable(given, error) from error
    os.close(descriptor)
    os.unlink(probe)
    if not target.exists():
        _absent.add(str(target))
    elif str(target) in _absent:
        _refuse_new_file(given, target)
    return given


def is_stream(path: str | Path) -> bool:
    """Tell whether an output is written into and not replaced.

    So are a pipe, a device such as /dev/null, and the file of standard output or standard error,
    whose further lines would go to a file without a name.
    """
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return False
    return (
        stat.S_ISFIFO(status.st_mode)
        or stat.S_ISCHR(status.st_mode)
        or _standard_stream(status) is not None
    )


def _standard_stream(status: os.stat_result) -> int | None:
    """Find the descriptor of standard output or standard error that is open on this file."""
    for descriptor in (1, 2):
        with suppress(OSError):
            if os.path.samestat(status, os.fstat(descriptor)):
                return descriptor
    return None


def _open_stream(path: Path) -> BinaryIO:
    """Open an output that is written into."""
    descriptor = _standard_stream(os.stat(path))
    if descriptor is None:
        return open(path, "wb")
    for stream in filter(None, (sys.stdout, sys.stderr)):
        stream.flush()
    return os.fdopen(os.dup(descriptor), "wb")


def _check_place(path: str | Path) -> tuple[Path, Path]:
    """Refuse an output that no file can be, and return its path as given and the file itself."""
    given = Path(path)
    if os.path.basename(path) in ("", "."):
        raise OutputError(path=given, problem=f"{path} is a folder", remedy="give a file name")
    try:
        mode = given.stat().st_mode
    except FileNotFoundError:
        mode = stat.S_IFREG
    except (OSError, ValueError) as error:  # a name that is too long, for example
        raise _unwritable(given, error) from error
    if stat.S_ISDIR(mode):
        raise OutputError(path=given, problem=f"{given} is a folder", remedy="give a file name")
    if stat.S_ISBLK(mode) or stat.S_ISSOCK(mode):
        raise OutputError(
            path=given, problem=f"{given} is a disk or a socket", remedy="give a file name"
        )
    try:
        target = Path(os.path.realpath(given))
    except OSError as error:
        raise OutputError(
            path=given, problem=f"cannot write {given}: the working folder is gone"
        ) from error
    if not is_stream(given) and not target.parent.is_dir():
        raise OutputError(
            path=given, problem=f"cannot write {given}: there is no folder {target.parent}"
        )
    return given, target


def _unwritable(path: Path, error: Exception) -> OutputError:
    reason = getattr(error, "strerror", None) or error
    return OutputError(path=path, problem=f"cannot write {path}: {reason}")


def _refuse_new_file(given: Path, target: Path) -> NoReturn:
    """Refuse to replace a file that has appeared since the output was checked."""
    _absent.discard(str(target))
    problem = f"{given} has appeared since this output was checked, and is kept"
    raise OutputError(
        path=given, problem=problem, remedy="move it away, and run this command again"
    )


@contextmanager
def atomic_output(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path`, moved to `path` when the block ends well.

    Otherwise nothing is left behind, and a file that was there before stays as it was. What is no
    regular file is not replaced: the bytes are written into it when the block has ended.

    Raises
    ------
    OutputError
        If the path cannot be written, or another program wrote it since `check_output`.
    """
    given, target = _check_place(path)
    if is_stream(given):
        with tempfile.TemporaryDirectory() as folder:
            temporary = Path(folder) / given.name
            yield temporary
            try:
                with open(temporary, "rb") as whole, _open_stream(given) as stream:
                    shutil.copyfileobj(whole, stream)
            except BrokenPipeError:
                raise  # no fault of the output: the reader has had enough
            except OSError as error:
                raise _unwritable(given, error) from error
        return
    temporary = target.with_name(f".{target.name[:40]}.{secrets.token_hex(8)}.tmp")
    try:
        yield temporary
        if str(target) in _absent:
            _move_to_new(temporary, target, given)
        else:
            if target.exists():
                temporary.chmod(target.stat().st_mode & 0o777)
            os.replace(temporary, target)
    except OSError as error:
        raise _unwritable(given, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _move_to_new(temporary: Path, target: Path, given: Path) -> None:
    """Move a file to a name that no file may have."""
    try:
        os.link(temporary, target)  # unlike a rename, it never replaces a file
    except FileExistsError:
        _refuse_new_file(given, target)
    except OSError:  # a file system without hard links
        if target.exists():
            _refuse_new_file(given, target)
        os.replace(temporary, target)
    _absent.discard(str(target))


def write_text(path: str | Path, text: str) -> None:
    """Write a text file in UTF-8, whole or not at all; raises `OutputError` as `atomic_output`."""
    write_bytes(path, text.encode())


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write a file, whole or not at all; raises `OutputError` as `atomic_output`."""
    with atomic_output(path) as temporary:
        temporary.write_bytes(data)


def write_arrays(path: str | Path, **arrays: Any) -> None:
    """Write arrays by name as .npz, whole or not at all; raises `OutputError` as `atomic_output`.

    Raises
    ------
    ValueError
        If a number is not finite, which would be a defect of what computed it.
    """
    import numpy as np  # not before it is needed: commands check their outputs without it

    for name, values in arrays.items():
        if np.asarray(values).dtype.kind == "f" and not np.isfinite(values).all():
            raise ValueError(f"{name}: holds a number that is not finite")
    with atomic_output(path) as temporary, open(temporary, "wb") as file:
        np.savez(file, **arrays)  # to an open file: numpy adds a suffix to a name


def json_text(data: Mapping[str, object] | Sequence[object], indent: int | None = 1) -> str:
    """Write data as JSON, with a line end.

    Raises
    ------
    ValueError
        If a number is not finite, which JSON does not have.
    """
    return json.dumps(data, indent=indent, allow_nan=False) + "\n"


def parse_number(text: str) -> float:
    """Read a decimal number; returns NaN for any other text."""
    return float(text) if _NUMBER.fullmatch(text) else math.nan


def commented_fields(text: str) -> dict[str, str]:
    """Read the lines ``# key: value`` at the top of a data file; of a key the first."""
    fields: dict[str, str] = {}
    for line in text.split("\n"):
        stripped = line.strip().rstrip(",")
        if stripped.startswith('"#'):  # Excel quotes a comment that holds a comma
            stripped = stripped.strip('"')
        if stripped and not stripped.startswith("#"):
            break
        field = _FIELD.fullmatch(stripped)
        if field and field[2].isprintable():
            fields.setdefault(field[1], field[2].strip())
    return fields
