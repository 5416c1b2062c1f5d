"""Output files that appear whole or not at all."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sampler.errors import InputError


def check_output(path: str | Path) -> Path:
    """Refuse an output path that cannot work, before any time is spent on its contents.

    Parameters
    ----------
    path : str or Path
        Where a file shall be written.

    Returns
    -------
    Path
        The same path.

    Raises
    ------
    InputError
        If the path is a folder, or its folder does not exist or cannot be written to.
    """
    target = Path(path)
    # os.path answers False where Path.is_dir raises, for names that are too long for example.
    if os.path.isdir(target):
        raise InputError(f"output: got {target}, a folder, allowed: a file name")
    if not os.path.isdir(target.parent):
        raise InputError(f"output: got {target}, allowed: a file in a folder that exists")
    if not os.access(target.parent, os.W_OK):
        raise InputError(f"output: got {target}, allowed: a file in a folder that can be written")
    return target


@contextmanager
def atomic_output(path: str | Path) -> Iterator[Path]:
    """Temporary path in the folder of `path`, moved to `path` when the block ends well.

    Nothing is left behind otherwise, and a file that was there before stays as it was. Keep
    anything but the writing out of the block: an `OSError` in it is reported as a failed write.

    Parameters
    ----------
    path : str or Path
        Where the finished file shall be.

    Yields
    ------
    Path
        Where to write.

    Raises
    ------
    InputError
        If the path cannot be written.
    """
    target = check_output(path)
    # Not the whole name, which with an addition could become too long.
    temporary = target.with_name(f".{target.name[:40]}.{secrets.token_hex(8)}.tmp")
    try:
        yield temporary
        os.replace(temporary, target)
    except OSError as error:
        reason = error.strerror or str(error).splitlines()[0]
        raise InputError(f"output: cannot write {target}: {reason}") from error
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file in UTF-8, whole or not at all; errors as `atomic_output`."""
    with atomic_output(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


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
