"""Compiled kernels kept on disk, by all that their machine code comes from.

Numba keys its own cache by the file that a kernel stands in, and goes on using the machine code of
an old release when a new one changes what the kernel calls in another file. It also fails where
nothing can be written, or where a file of the cache is damaged. Here

- machine code lies in a folder named after a digest of all kernel sources and of the versions of
  Python, numpy, numba and llvmlite, so that no two releases share a file;
- a file counts only if its own checksum is right, and a kernel is compiled again otherwise;
- where nothing can be written, that is logged once, and every process compiles for itself.

The folders lie in NUMBA_CACHE_DIR where it is set, else in ``sampler/__pycache__`` where that can
be written, else in the user's cache (``~/.cache/rebound-tables``). Machine code is read from any of
them that has it, read-only or not. A new folder leaves `KEPT` older ones beside it, for releases
that are used in turn, and removes those that are older still.
"""

import hashlib
import logging
import os
import pickle
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs

from sampler.errors import InputError
from sampler.files import atomic_output

_LOG = logging.getLogger("sampler")

_PACKAGE = Path(__file__).parents[1]

#: Files and folders with all that can change what a kernel computes.
KERNEL_SOURCES = (
    "sampler/errors.py",
    "sampler/compilation",
    "sampler/drawing",
    "sampler/files",
    "sampler/formats",
    "tablegen/accuracy/streaming_statistics.py",
    "tablegen/model",
    "tablegen/fitting/expectation.py",
    "tablegen/fitting/spin_scores.py",
    "tablegen/evidence/one_by_one.py",
)

#: Older folders that a new one leaves beside it.
KEPT = 7

_NAME = "rebound-tables-"
_FOLDER = re.compile(rf"{_NAME}[0-9a-f]{{16}}")
_CHECKSUM = hashlib.sha256().digest_size


def kernel_sources() -> list[Path]:
    """Files with all that can change what a kernel computes.

    Returns
    -------
    list of Path
        Modules, and arrays that are built into kernels; of both packages where tablegen lies beside
        this one, as it does where it is installed.
    """
    files: list[Path] = []
    for place in (_PACKAGE.parent / name for name in KERNEL_SOURCES):
        inside = sorted(place.iterdir()) if place.is_dir() else [place]
        files += [path for path in inside if path.suffix in (".py", ".npy") and path.is_file()]
    return files


def _digest() -> str:
    """Digest of what machine code comes from, besides the kernel, its arguments and the processor.

    Empty where the sources cannot be read as files, in a zip archive for example, or while an
    upgrade replaces them.
    """
    try:
        contents = {path: path.read_bytes() for path in kernel_sources()}
    except OSError:
        return ""
    if Path(__file__) not in contents:
        return ""
    versions = (sys.implementation.cache_tag, np.__version__, numba.__version__)
    digest = hashlib.sha256(repr((*versions, llvmlite.__version__)).encode())
    for path, content in contents.items():
        digest.update(f"{path.relative_to(_PACKAGE.parent)} {len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()[:16]


#: As the modules were when they were imported: an upgrade may replace them under this process.
_IMPORTED = _digest()


def _places() -> list[Path]:
    """Folders of the caches, the first that can be written to be used."""
    named = config.CACHE_DIR  # type: ignore[attr-defined]
    if named:
        return [Path(named)]
    user = AppDirs("rebound-tables", appauthor=False).user_cache_dir
    # where there is no home, "~" stays: that would be a folder of this name in the working folder
    own = [Path(user)] if os.path.isabs(user) else []
    return [_PACKAGE / "__pycache__", *own]


def _folders() -> list[Path]:
    return [place / f"{_NAME}{_IMPORTED}" for place in _places()]


def _older(folder: Path) -> Iterator[Path]:
    """Folders of other digests beside one, without the newest `KEPT`."""
    others = [p for p in folder.parent.iterdir() if _FOLDER.fullmatch(p.name) and p != folder]
    yield from sorted(others, key=lambda path: path.stat().st_mtime, reverse=True)[KEPT:]


def _make(folder: Path) -> None:
    if folder.is_dir():
        return
    folder.mkdir(parents=True, exist_ok=True)
    with suppress(OSError):  # another process may do the same
        for old in _older(folder):
            shutil.rmtree(old, ignore_errors=True)


def _write(path: Path, content: bytes) -> None:
    with atomic_output(path) as temporary:
        temporary.write_bytes(hashlib.sha256(content).digest() + content)


def _read(path: Path) -> Any:
    content = path.read_bytes()
    checksum, content = content[:_CHECKSUM], content[_CHECKSUM:]
    if hashlib.sha256(content).digest() != checksum:
        raise ValueError(f"{path} is damaged")
    return pickle.loads(content)


@cache
def _content(path: str, modified: int, size: int) -> bytes:
    return hashlib.sha256(Path(path).read_bytes()).digest()


def _file_digest(path: str) -> bytes:
    """Digest of a file as it is now; empty where there is none, for what was made by exec."""
    try:
        state = os.stat(path)
        return _content(path, state.st_mtime_ns, state.st_size)
    except OSError:
        return b""


class KernelCache(_Cache):
    """Machine code of one kernel on disk, in the form that a dispatcher of numba asks for."""

    #: Whether it has been logged, in this process, that nothing can be kept.
    _told = False

    def __init__(self, function: FunctionType) -> None:
        self._function = function
        # Without a file nothing is kept: the bytes of a code object do not have its constants.
        self._source = _file_digest(function.__code__.co_filename)
        self._enabled = True

    @property
    def cache_path(self) -> str:
        """Folder in which machine code is looked for first."""
        return str(_folders()[0])

    def enable(self) -> None:
        """Use the files from now on."""
        self._enabled = True

    def disable(self) -> None:
        """Use no files from now on."""
        self._enabled = False

    def flush(self) -> None:
        """Remove the files of this kernel, as far as they can be removed."""
        for folder in _folders():
            with suppress(OSError):
                for path in folder.glob(f"{self._prefix()}*"):
                    path.unlink()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Compiled kernel for a signature, or None if it has to be compiled."""
        if not (self._enabled and self._source and _IMPORTED):
            return None
        target_context.refresh()
        name, key = self._name_and_key(sig, target_context.codegen())
        for folder in _folders():
            # Whatever a file leads to that is damaged, or cannot be read: the kernel is compiled.
            with suppress(Exception):
                stored, parts = _read(folder / name)
                if stored == key:
                    return CompileResult._rebuild(target_context, *parts)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel in the first folder that can be written."""
        built_for_this_process = data.lifted or data.library.has_dynamic_globals
        if not (self._enabled and self._source) or built_for_this_process:
            return
        if not _IMPORTED:
            self._tell(f"no sources can be read in {_PACKAGE}")
        elif _digest() == _IMPORTED:
            name, key = self._name_and_key(sig, data.codegen)
            self._write_somewhere(name, dumps((key, data._reduce())))

    def _write_somewhere(self, name: str, content: bytes) -> None:
        reasons = []
        for folder in _folders():
            try:
                _make(folder)
                _write(folder / name, content)
                return
            except (OSError, InputError) as error:
                reasons.append(str(error).removeprefix("output: "))
        self._tell("; ".join(reasons))

    @staticmethod
    def _tell(reason: str) -> None:
        if not KernelCache._told:
            KernelCache._told = True
            _LOG.warning(
                "compiled kernels cannot be kept, and every process compiles them again, unless "
                "NUMBA_CACHE_DIR names a folder for them: %s",
                reason,
            )

    def _prefix(self) -> str:
        code = self._function.__code__
        name = f"{Path(code.co_filename).stem}.{self._function.__qualname__}"
        return re.sub(r"[^\w.-]", "", name) + f"-{code.co_firstlineno}-"

    def _name_and_key(self, sig: Any, codegen: Any) -> tuple[str, Any]:
        """Name of the file for a signature on this processor, and what must stand in it."""
        cells = tuple(cell.cell_contents for cell in self._function.__closure__ or ())
        key = (sig, codegen.magic_tuple())
        parts = (self._source, self._function.__code__.co_code, dumps(cells), repr(key).encode())
        # lengths keep parts apart
        digest = hashlib.sha256(b"".join(b"%d " % len(part) + part for part in parts))
        return f"{self._prefix()}{digest.hexdigest()[:16]}.kernel", key
