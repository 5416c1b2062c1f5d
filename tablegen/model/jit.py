"""Compile kernels: the one place with options of numba, and the cache of machine code on disk.

``fastmath`` is off: results do not depend on the size of a batch, and NaN can be tested for.

Only kernels that Python calls become machine code. A kernel that they call is compiled as a part
of them: numba would optimise every function with all that it calls once more, make machine code of
each and wrap it for Python, which took a third of the time.

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
import time
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
from numba import types
from numba.core import config
from numba.core.caching import NullCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, CompileResult, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.serialize import dumps
from numba.core.typed_passes import NativeLowering
from numba.core.typing.templates import infer_global
from numba.extending import intrinsic
from numba.misc.appdirs import AppDirs

_LOG = logging.getLogger("tablegen")

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: ``nogil`` lets threads run kernels side by side; ``error_model="numpy"`` removes the branches for
#: division by zero, which the kernels exclude themselves.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}

#: Dissolve the function in its caller, by the optimiser and not by rewriting its source.
_INLINE: dict[str, Any] = {"forceinline": True}

#: Count no references. Numba counts references to every array argument with atomic operations,
#: which is slow and makes threads wait for each other. Only for functions that neither make nor
#: return arrays: then the references of the caller suffice.
_NO_REFCOUNT: dict[str, Any] = {"_nrt": False}

#: Files and folders that can change the result of a kernel, besides its own file.
_ROOT = Path(__file__).parents[2]
_SOURCES = (
    "tablegen/model",
    "sampler/formats",
    "sampler/errors.py",
)

#: Number of folders of other sources that a new folder leaves beside it.
_KEPT = 7

#: Passes of numba that kernels do not need: they have no closures and no arithmetic on arrays.
_UNNEEDED = {"inline_closure_likes", "inline_overloads", "nopython_rewrites", "dead_branch_prune"}

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
    # a user without a home cannot write to the root, and is told to name a folder
    place = Path(named or Path("/", AppDirs("rebound-tables", appauthor=False).user_cache_dir))
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
        self._is_ours = str(function.__module__).startswith("tablegen.")
        self._began: dict[Any, float] = {}

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
            if self._is_ours:
                _log_once(_COMPILING)
            self._began[sig] = time.perf_counter()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Tell of a compiled kernel, and keep it unless it refers to addresses in this process."""
        if self._is_ours:
            seconds = time.perf_counter() - self._began[sig]
            _LOG.warning("compiled %s in %.1f s", self._function.__name__, seconds)
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


class _PartLibrary(JITCodeLibrary):
    """Code of a part, with that of its own parts; it is optimised with the whole kernel."""

    def finalize(self) -> None:
        """Link in the parts that this one calls."""
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(NativeLowering):
    """Write the code of a part, and tell its callers where it is."""

    _name = "part_lowering"

    def run_pass(self, state: Any) -> bool:
        """Run the pass."""
        state.library = _PartLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        super().run_pass(state)
        entry = object().__reduce__  # never called: numba wants a builtin function, one for each
        state.targetctx.insert_user_function(entry, state.cr.fndesc, [state.library])
        state.cr = state.cr._replace(cfunc=entry)
        return True


class _PartCompiler(CompilerBase):
    """Compiler of parts."""

    def define_pipelines(self) -> list[Any]:
        """Give numba's passes, with another last one and without those that kernels do not need."""
        self.state.flags.no_compile = True
        given = DefaultPassBuilder.define_nopython_pipeline(self.state)
        given.passes = [
            (_PartLowering if made is NativeLowering else made, text)
            for made, text in given.passes
            if made.name() not in _UNNEEDED
        ]
        given.finalize()
        return [given]


#: Options of parts.
_PART: dict[str, Any] = {
    "pipeline_class": _PartCompiler,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}

#: Numba refers to them, and does not keep them.
_PARTS: list[Any] = []


def _compiled(function: _Function, **options: Any) -> _Function:
    compiled = numba.njit(**_OPTIONS, **options)(function)
    interpreted = compiled is function  # with NUMBA_DISABLE_JIT
    if not interpreted and Path(function.__code__.co_filename).is_file():
        compiled._cache = _KernelCache(compiled.py_func)
    if not interpreted:
        part = numba.njit(**_OPTIONS, **_PART, **options)(function)
        # what numba asks for when a kernel calls another
        compiled.get_call_template, compiled.get_overload = (
            part.get_call_template,
            part.get_overload,
        )
    # To a type checker the function stays the same.
    return cast(_Function, compiled)


def _inlined(function: _Function, **options: Any) -> _Function:
    # Neither cached nor wrapped for Python: its machine code is in the kernels that call it.
    part = numba.njit(**_OPTIONS, **_PART, **_INLINE, **options)(function)
    if part is not function:
        infer_global(function, types.Dispatcher(part))
        _PARTS.append(part)
    return function


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
