"""Compile kernels: all options of numba, and the folder of machine code on disk.

Nobody needs this file to change the physics. Use the decorators as the neighbouring functions do:

- `kernel` compiles a function that Python or another kernel calls;
- `inline_kernel` makes a small function a part of the kernels that call it;
- `no_refcount_kernel` and `no_refcount_inline_kernel` do the same for functions that take arrays of
  their caller, and neither make nor return arrays.

Numba's option ``fastmath`` is off. So results do not depend on the size of a batch, and NaN can be
tested for.

Numba's own cache keeps the machine code. It would not notice an edit in a function that a kernel
calls from another file. So the cache is in a folder named by the digest of all kernel sources and
of the versions of Python, numpy, numba and llvmlite.
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

from sampler.errors import InputError

#: Settings of numba, from the environment.
_CONFIG: Any = numba.config

if _CONFIG.DISABLE_JIT:
    _PROBLEM = "is set, and direct simulation runs as compiled code only"
    raise InputError("NUMBA_DISABLE_JIT", problem=_PROBLEM, remedy="unset it")

_LOG = logging.getLogger("tablegen")

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: ``nogil`` lets threads run kernels side by side; ``error_model="numpy"`` removes the branches for
#: division by zero, which the kernels exclude themselves.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}

#: Let the optimiser inline the function in its caller.
_INLINE = _OPTIONS | {"forceinline": True}

#: Count no references. Numba counts references to each array argument with atomic operations, which
#: are slow and make threads wait for each other. A function that neither makes nor returns arrays
#: needs none, because its caller holds the references.
_NO_REFCOUNT = {"_nrt": False}

#: Files and folders that can change the result of a kernel.
_ROOT = Path(__file__).parents[2]
_SOURCES = (
    "tablegen/model",
    "tablegen/fitting/tile_products.py",
    "sampler/formats",
    "sampler/errors.py",
)

#: Number of folders of other sources that are kept when a new folder is made.
_KEPT_FOLDERS = 7


def _digest() -> str:
    """Compute the digest of the sources of kernels and of the versions of their compiler."""
    versions = [version(name) for name in ("numpy", "numba", "llvmlite")]
    digest = hashlib.sha256(repr((platform.python_version(), *versions)).encode())
    for source in (_ROOT / name for name in _SOURCES):
        for path in sorted(source.iterdir()) if source.is_dir() else [source]:
            if path.suffix in (".py", ".npy"):
                digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


#: Computed once, because the sources may change while this process runs.
_SOURCE_DIGEST = _digest()


def cache_folder() -> Path:
    """Name the folder for the machine code of these sources and versions."""
    # for a user without a home the folder is in the root, which cannot be written; then a warning
    # asks for NUMBA_CACHE_DIR
    caches = Path("/", os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    place = Path(_CONFIG.CACHE_DIR or caches / "rebound-tables")
    return place / f"tablegen-{_SOURCE_DIGEST}"


@cache
def _can_be_written(folder: Path) -> bool:
    """Make the folder of the cache, and remove the oldest folders of other sources.

    Returns whether kernels can be kept there.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()
    except OSError as error:
        _warn_not_kept(str(error))
        return False
    others = [path for path in folder.parent.glob("tablegen-*") if path != folder]
    for old in sorted(others, key=os.path.getmtime, reverse=True)[_KEPT_FOLDERS:]:
        shutil.rmtree(old, ignore_errors=True)
    return True


#: Why compiled kernels could not be written to disk.
_WRITE_FAILURES: set[str] = set()


def kernels_are_kept() -> bool:
    """Return whether all kernels that were compiled are on disk, for the next run."""
    return not _WRITE_FAILURES


def _warn_not_kept(reason: str) -> None:
    """Log once for each reason that the next run will compile the kernels again."""
    if reason not in _WRITE_FAILURES:
        _WRITE_FAILURES.add(reason)
        line = "compiled kernels cannot be kept, set NUMBA_CACHE_DIR to a folder with space: %s"
        _LOG.warning(line, reason)


def _go_on_without_space(compiled: Any) -> None:
    """Let a kernel run whose machine code cannot be written, for example to a full disk."""
    save = compiled._cache.save_overload

    def save_or_warn(*arguments: Any) -> None:
        try:
            save(*arguments)
        except OSError as error:
            _warn_not_kept(str(error))

    compiled._cache.save_overload = save_or_warn


class _Messages(event.Listener):
    """Log that the direct model is being compiled, and the time of each kernel."""

    def __init__(self) -> None:
        self._starts: list[float] = []  # of the kernels being compiled, callers first
        self._is_announced = False

    def on_start(self, event: event.Event) -> None:
        """Note that numba begins to compile a function."""
        if not self._is_announced and self._is_ours(event):
            self._is_announced = True
            _LOG.warning(
                "compiling the direct model for this processor, "
                "which takes up to half a minute and happens once"
            )
        self._starts.append(time.perf_counter())

    def on_end(self, event: event.Event) -> None:
        """Log how long a kernel took, together with the functions that it calls."""
        seconds = time.perf_counter() - self._starts.pop()
        if not self._starts and self._is_ours(event):
            _LOG.warning("compiled %s in %.1f s", event.data["dispatcher"].__name__, seconds)

    @staticmethod
    def _is_ours(event: event.Event) -> bool:
        return str(event.data["dispatcher"].__module__).startswith("tablegen.")


event.register("numba:compile", _Messages())


def _kept_on_disk(compile_function: Callable[[bool], Any], function: Callable[..., Any]) -> Any:
    """Compile a function, and keep its machine code in the folder of the cache if possible."""
    folder, named = cache_folder(), _CONFIG.CACHE_DIR
    kept = Path(function.__code__.co_filename).is_file() and _can_be_written(folder)
    _CONFIG.CACHE_DIR = str(folder)
    try:
        compiled = compile_function(kept)
    finally:
        _CONFIG.CACHE_DIR = named
    if kept:
        _go_on_without_space(compiled)
    return compiled


def _compiled(function: _Function, options: dict[str, Any]) -> _Function:
    compiled = _kept_on_disk(lambda kept: numba.njit(**options, cache=kept)(function), function)
    # for a type checker the function stays the same
    return cast(_Function, compiled)


def _inlined(function: _Function, options: dict[str, Any]) -> _Function:
    register_jitable(**options, no_cpython_wrapper=True)(function)
    return function


def kernel(function: _Function) -> _Function:
    """Compile a kernel."""
    return _compiled(function, _OPTIONS)


def inline_kernel(function: _Function) -> _Function:
    """Make a small function a part of the kernels that call it; Python calls it interpreted."""
    return _inlined(function, _INLINE)


def no_refcount_kernel(function: _Function) -> _Function:
    """Compile a kernel that only reads and writes arrays of its caller."""
    return _compiled(function, _OPTIONS | _NO_REFCOUNT)


def no_refcount_inline_kernel(function: _Function) -> _Function:
    """Make a small function that only uses arrays of its caller a part of its kernels."""
    return _inlined(function, _INLINE | _NO_REFCOUNT)


def c_function(function: Callable[..., Any], signature: Any) -> Any:
    """Compile a kernel as a function that C calls; ``.address`` of the result is its address.

    The kernel takes addresses and numbers, and neither makes nor returns arrays.
    """
    compiler: Any = numba.cfunc
    return _kept_on_disk(
        lambda kept: compiler(signature, **_OPTIONS, **_NO_REFCOUNT, cache=kept)(function),
        function,
    )


def c_function_text(function: Callable[..., Any], signature: Any) -> str:
    """Compile a kernel as `c_function` does, and return its code in LLVM, without any wrapper."""
    options = _OPTIONS | _NO_REFCOUNT | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    compiled = numba.njit(signature, **options)(function)
    return str(compiled.inspect_llvm(compiled.signatures[0]))


#: Decorator for a function that gives the type of a call and writes its code in LLVM.
operation: Any = intrinsic
