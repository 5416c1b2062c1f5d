"""Compile kernels: the one place with options of numba, and the cache of machine code on disk.

``fastmath`` is off: results do not depend on the size of a batch, and NaN can be tested for.

Machine code lies in a folder named by the digest of all kernel sources and of the versions of
Python, numpy, numba and llvmlite. Numba's own cache does not notice an edit in a function that a
kernel calls from another file, and two processes that compile at once can mix up its files.
"""

import hashlib
import logging
import os
import pickle
import platform
import re
import shutil
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
from numba.core import config
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from numba.extending import intrinsic, register_jitable
from numba.misc.appdirs import AppDirs

_LOG = logging.getLogger("tablegen")

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: ``nogil`` lets threads run kernels side by side; ``error_model="numpy"`` removes the branches for
#: division by zero, which the kernels exclude themselves.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}

#: Dissolve the function in its caller, by the optimiser and not by rewriting its source.
_INLINE: dict[str, Any] = {"forceinline": True, "no_cfunc_wrapper": True}

#: Count no references. Numba counts references to every array argument with atomic operations,
#: which is slow and makes threads wait for each other. Only for functions that neither make nor
#: return arrays: then the references of the caller suffice.
_NO_REFCOUNT: dict[str, Any] = {"_nrt": False}

#: Files and folders that can change the result of a kernel, besides its own file.
_ROOT = Path(__file__).parents[2]
_SOURCES = (
    "tablegen/model",
    "tablegen/fitting/expert_kernels.py",
    "sampler/formats",
    "sampler/errors.py",
)

#: Number of folders of other sources that a new folder leaves beside it.
_KEPT = 7

_COMPILING = (
    "compiling the direct model for this processor, "
    "which takes up to half a minute and happens once"
)


@cache
def _file_digest(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


def _digest() -> str:
    """Digest of the sources of kernels and of the versions of their compiler."""
    versions = [version(name) for name in ("numpy", "numba", "llvmlite")]
    digest = hashlib.sha256(repr((platform.python_version(), *versions)).encode())
    for source in (_ROOT / name for name in _SOURCES):
        for path in sorted(source.iterdir()) if source.is_dir() else [source]:
            if path.suffix in (".py", ".npy"):
                digest.update(_file_digest(path))
    return digest.hexdigest()[:16]


#: Taken once: sources may change while this process runs.
_SOURCE_DIGEST = _digest()


def cache_folder() -> Path:
    """Folder for the machine code of these sources and versions."""
    named = config.CACHE_DIR  # type: ignore[attr-defined]
    place = Path(named or AppDirs("rebound-tables", appauthor=False).user_cache_dir)
    return place / f"tablegen-{_SOURCE_DIGEST}"


def _make_folder() -> None:
    """Make the folder of the cache, and remove the oldest folders of other sources."""
    folder = cache_folder()
    if folder.is_dir():
        return
    folder.mkdir(parents=True, exist_ok=True)
    others = [path for path in folder.parent.glob("tablegen-*") if path != folder]
    for old in sorted(others, key=os.path.getmtime, reverse=True)[_KEPT:]:
        shutil.rmtree(old, ignore_errors=True)


@cache
def _log_once(line: str) -> None:
    _LOG.warning(line)


class _KernelCache(NullCache):
    """Machine code of one kernel on disk, a file for each signature and type of processor."""

    def __init__(self, function: FunctionType) -> None:
        self._function = function
        self._file = Path(function.__code__.co_filename)
        self._source = _file_digest(self._file)

    def _path(self, signature: Any, codegen: Any) -> Path:
        cells = [cell.cell_contents for cell in self._function.__closure__ or ()]
        name = re.sub(r"[^\w.]", "", f"{self._file.stem}.{self._function.__qualname__}")
        line = self._function.__code__.co_firstlineno
        digest = hashlib.sha256(self._source + dumps(cells))
        digest.update(repr((line, signature, codegen.magic_tuple())).encode())
        return cache_folder() / f"{name}-{digest.hexdigest()[:16]}.kernel"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Compiled kernel of a signature, or None if it must be compiled."""
        target_context.refresh()
        try:
            content = self._path(sig, target_context.codegen()).read_bytes()
            return CompileResult._rebuild(target_context, *pickle.loads(content))
        except (OSError, EOFError):
            if str(self._function.__module__).startswith("tablegen."):
                _log_once(_COMPILING)
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel, unless its code refers to addresses in this process."""
        if data.lifted or data.library.has_dynamic_globals:
            return
        try:
            _make_folder()
            path = self._path(sig, data.codegen)
            temporary = path.with_suffix(f".{os.getpid()}-{id(data)}")
            temporary.write_bytes(dumps(data._reduce()))
            temporary.replace(path)
        except OSError as error:
            _log_once(f"compiled kernels cannot be kept, set NUMBA_CACHE_DIR to a folder: {error}")


def _compiled(function: _Function, **options: Any) -> _Function:
    compiled = numba.njit(**_OPTIONS, **options)(function)
    interpreted = compiled is function  # with NUMBA_DISABLE_JIT
    if not interpreted and Path(function.__code__.co_filename).is_file():
        compiled._cache = _KernelCache(compiled.py_func)
    # To a type checker the function stays the same.
    return cast(_Function, compiled)


def _inlined(function: _Function, **options: Any) -> _Function:
    # Neither cached nor wrapped for Python: its machine code is in the kernels that call it.
    return register_jitable(**_OPTIONS, **_INLINE, **options)(function)


def kernel(function: _Function) -> _Function:
    """Compile a kernel."""
    return _compiled(function)


def inline_kernel(function: _Function) -> _Function:
    """Let kernels call a small function, which dissolves in them; Python calls it interpreted."""
    return _inlined(function)


def no_refcount_kernel(function: _Function) -> _Function:
    """Compile a kernel that only reads and writes arrays of its caller, and makes none."""
    return _compiled(function, **_NO_REFCOUNT)


def no_refcount_inline_kernel(function: _Function) -> _Function:
    """Let kernels call a small `no_refcount_kernel`, which dissolves in them."""
    return _inlined(function, **_NO_REFCOUNT)


def operation(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of kernels from one that types a call and writes its code."""
    return cast(Callable[..., Any], intrinsic(function))
