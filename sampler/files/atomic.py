"""Output files: regular files that appear whole or not at all."""

import os
import secrets
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from sampler.errors import InputError
from sampler.files.regular import is_one_of, other_kind, reason


def check_output(path: str | Path, read: Iterable[str | Path] = ()) -> Path:
    """Refuse an output path that cannot work, before any time is spent on its contents.

    Outputs are files: a regular one is replaced, and what else stands there is refused. A link is
    followed: the file that it leads to is replaced or made.

    Parameters
    ----------
    path : str or Path
        Where a file shall be written.
    read : iterable of str or Path
        Files that the contents come from, none of which may be replaced.

    Returns
    -------
    Path
        The same path.

    Raises
    ------
    InputError
        If there is something else than a regular file, or one that may not be written or is read;
        or if the folder does not exist or cannot be written to.
    """
    given = Path(path)
    if given == Path("-"):
        raise InputError("output: got -, allowed: a file name; nothing is written to the terminal")
    found = _status(given)
    if found is not None and (other := other_kind(found.st_mode)):
        raise InputError(f"output: got {given}, {other}, allowed: a regular file or a new one")
    folder = _end_of_links(given).parent
    # os.path answers False where Path.is_dir raises, for names that are too long for example.
    if not os.path.isdir(folder):
        raise InputError(f"output: got {given}, allowed: a file in a folder that exists")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"output: got {given}, allowed: a file in a folder that can be written")
    if found is not None and not os.access(given, os.W_OK):
        raise InputError(f"output: got {given}, allowed: a file that can be written")
    if is_one_of(given, read):
        raise InputError(f"output: got {given}, which is also read, allowed: another file")
    return given


def _status(path: Path) -> os.stat_result | None:
    """Status of a file, None if there is none; links are followed."""
    try:
        return os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        raise _unwritten(path, error) from error


def _end_of_links(path: Path) -> Path:
    """Where a file is replaced or made: beside it goes the temporary one."""
    return Path(os.path.realpath(path))


def _unwritten(path: Path, error: Exception) -> InputError:
    return InputError(f"output: cannot write {path}: {reason(error)}")


@contextmanager
def atomic_output(path: str | Path) -> Iterator[Path]:
    """Temporary path in the folder of `path`, moved to `path` when the block ends well.

    Nothing is left behind otherwise, and a file that was there before stays as it was. One that is
    replaced hands its mode on, and its owner where the system allows that. Keep anything but the
    writing out of the block: an `OSError` in it is reported as a failed write.

    Parameters
    ----------
    path : str or Path
        Where the finished file shall be; as for `check_output`.

    Yields
    ------
    Path
        Where to write, an empty file.

    Raises
    ------
    InputError
        If the path cannot be written.
    """
    given = check_output(path)
    target = _end_of_links(given)
    # Not the whole name, which with an addition could become too long.
    temporary = target.with_name(f".{target.name[:40]}.{secrets.token_hex(8)}.tmp")
    try:
        replaced = _status(target)
        # nobody else reads meanwhile what a file may replace that nobody else may read
        kept_to_us = 0o600 if replaced else 0o666
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, kept_to_us))
        yield temporary
        if replaced:
            _hand_on(replaced, temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise _unwritten(given, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _hand_on(replaced: os.stat_result, temporary: Path) -> None:
    """Give a file the owner, as far as that is allowed, and the mode of the one it replaces."""
    if hasattr(os, "chown"):  # Windows has none
        with suppress(OSError):
            os.chown(temporary, replaced.st_uid, replaced.st_gid)
    os.chmod(temporary, replaced.st_mode & 0o777)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file in UTF-8, whole or not at all; errors as `atomic_output`."""
    with atomic_output(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write a file, whole or not at all; errors as `atomic_output`."""
    with atomic_output(path) as temporary:
        temporary.write_bytes(data)


def write_arrays(path: str | Path, **arrays: Any) -> None:
    """Write arrays by name as .npz, whole or not at all; errors as `atomic_output`.

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
        # an open file, because numpy would add a suffix to a name
        np.savez(file, **arrays)
