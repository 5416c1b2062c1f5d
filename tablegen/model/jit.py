"""Compile kernels: the one place with options of numba, and the folder of machine code on disk.

``fastmath`` is off: results do not depend on the size of a batch, and NaN can be tested for.

Machine code is kept by numba's own cache, in a folder named by the digest of all kernel sources and
of the versions of Python, numpy, numba and llvmlite: numba notices no edit in a function that a
kernel calls from another file. `tablegen.model.parts` makes compiling faster where it can.
"""

import hashlib
import logging
import os
import platform
import shutil
import time
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, TypeVar, cast

import numba
from numba.core import event
from numba.extending import intrinsic, register_jitable

try:
    from tablegen.model import parts
except ImportError:  # another version of numba than those with which parts were tested
    parts = None  # type: ignore[assignment]

#: Settings of numba, from the environment.
_CONFIG: Any = numba.config

_LOG = logging.getLogger("tablegen")

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: ``nogil`` lets threads run kernels side by side; ``error_model="numpy"`` removes the branches for
#: division by zero, which the kernels exclude themselves.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}

#: Dissolve the function in its caller, by the optimiser and not by rewriting its source.
_INLINE = _OPTIONS | {"forceinline": True}

#: Count no references. Numba counts references to every array argument with atomic operations,
#: which is slow and makes threads wait for each other. Only for functions that neither make nor
#: return arrays: then the references of the caller suffice.
_NO_REFCOUNT = {"_nrt": False}

#: Files and folders that can change the result of a kernel, besides its own file.
_ROOT = Path(__file__).parents[2]
_SOURCES = ("tablegen/model", "sampler/formats", "sampler/errors.py")

#: Number of folders of other sources that a new folder leaves beside it.
_KEPT = 7


def _digest() -> str:
    """Digest of the sources of kernels and of the versions of their compiler."""
    versions = [version(name) for name in ("numpy", "numba", "llvmlite")]
    digest = hashlib.sha256(repr((platform.python_version(), *versions)).encode())
    for source in (_ROOT / name for name in _SOURCES):
        for path in sorted(source.iterdir()) if source.is_dir() else [source]:
            if path.suffix in (".py", ".npy"):
                digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


#: Taken once: sources may change while this process runs.
_SOURCE_DIGEST = _digest()


def cache_folder() -> Path:
    """Folder for the machine code of these sources and versions."""
    # a user without a home cannot write to the root, and is told to name a folder
    caches = Path("/", os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    place = Path(_CONFIG.CACHE_DIR or caches / "rebound-tables")
    return place / f"tablegen-{_SOURCE_DIGEST}"


@cache
def _can_be_written(folder: Path) -> bool:
    """Make the folder of the cache, and remove the oldest folders of other sources."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()
    except OSError as error:
        _LOG.warning("compiled kernels cannot be kept, set NUMBA_CACHE_DIR to a folder: %s", error)
        return False
    others = [path for path in folder.parent.glob("tablegen-*") if path != folder]
    for old in sorted(others, key=os.path.getmtime, reverse=True)[_KEPT:]:
        shutil.rmtree(old, ignore_errors=True)
    return True


class _Messages(event.Listener):
    """Say what takes long: that the direct model is being compiled, and each kernel's time."""

    def __init__(self) -> None:
        self._starts: list[float] = []  # of the kernels under way, the callers first
        self._said = False

    def on_start(self, event: event.Event) -> None:
        """Note that numba begins to compile a function."""
        if not self._said and self._is_ours(event):
            self._said = True
            _LOG.warning(
                "compiling the direct model for this processor, "
                "which takes up to half a minute and happens once"
            )
        self._starts.append(time.perf_counter())

    def on_end(self, event: event.Event) -> None:
        """Say how long a kernel took, with all that it calls."""
        seconds = time.perf_counter() - self._starts.pop()
        if not self._starts and self._is_ours(event):
            _LOG.warning("compiled %s in %.1f s", event.data["dispatcher"].__name__, seconds)

    @staticmethod
    def _is_ours(event: event.Event) -> bool:
        return str(event.data["dispatcher"].__module__).startswith("tablegen.")


event.register("numba:compile", _Messages())


def _compiled(function: _Function, options: dict[str, Any]) -> _Function:
    folder, named = cache_folder(), _CONFIG.CACHE_DIR
    kept = Path(function.__code__.co_filename).is_file() and _can_be_written(folder)
    _CONFIG.CACHE_DIR = str(folder)
    try:
        compiled = numba.njit(**options, cache=kept)(function)
    finally:
        _CONFIG.CACHE_DIR = named
    if parts is not None and compiled is not function:  # it is with NUMBA_DISABLE_JIT
        parts.let_kernels_call(compiled, options)
    # To a type checker the function stays the same.
    return cast(_Function, compiled)


def _inlined(function: _Function, options: dict[str, Any]) -> _Function:
    if parts is None or _CONFIG.DISABLE_JIT:
        register_jitable(**options)(function)
    else:
        parts.register_part(function, options)
    return function


def kernel(function: _Function) -> _Function:
    """Compile a kernel."""
    return _compiled(function, _OPTIONS)


def inline_kernel(function: _Function) -> _Function:
    """Let kernels call a small function, which dissolves in them; Python calls it interpreted."""
    return _inlined(function, _INLINE)


def no_refcount_kernel(function: _Function) -> _Function:
    """Compile a kernel that only reads and writes arrays of its caller, and makes none."""
    return _compiled(function, _OPTIONS | _NO_REFCOUNT)


def no_refcount_inline_kernel(function: _Function) -> _Function:
    """Let kernels call a small `no_refcount_kernel`, which dissolves in them."""
    return _inlined(function, _INLINE | _NO_REFCOUNT)


#: Makes a function of kernels from one that types a call and writes its code.
operation: Any = intrinsic
