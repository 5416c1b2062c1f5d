"""The one place where JIT options live.

Every kernel of both packages is compiled with these options, so that a question such as
"do we reassociate floating-point sums?" has one answer. We do not: ``fastmath`` is off, which
keeps results independent of batch size and lets NaN be tested for.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.extending import register_jitable

from sampler.compilation.compiling import log_compilations
from sampler.compilation.kernel_cache import KernelCache

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: ``nogil`` lets plain threads run kernels side by side; ``error_model="numpy"`` removes the
#: zero-division branches, which the kernels exclude themselves.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}

#: Dissolve the function in its caller, by the optimiser and not by rewriting its source.
_INLINE: dict[str, Any] = {"forceinline": True, "no_cfunc_wrapper": True}

#: Count no references. Numba counts those to every array that a function gets, with atomic
#: operations; for eight arrays that costs as much as a draw, and threads wait for each other.
#: Only for functions that neither make nor return arrays: then the caller's references suffice.
_NO_REFCOUNT: dict[str, Any] = {"_nrt": False}


log_compilations()


def _compiled(function: _Function, **options: Any) -> _Function:
    compiled = numba.njit(**_OPTIONS, **options)(function)
    if compiled is not function:  # as it is where NUMBA_DISABLE_JIT is set
        compiled._cache = KernelCache(compiled.py_func)
    # To a type checker the function stays what it was.
    return cast(_Function, compiled)


def _inlined(function: _Function, **options: Any) -> _Function:
    # Neither kept by itself nor wrapped for Python, which a third of the compiler's time was
    # spent on: its machine code is in the kernels that call it.
    return register_jitable(**_OPTIONS, **_INLINE, **options)(function)


def kernel(function: _Function) -> _Function:
    """Compile a kernel."""
    return _compiled(function)


def inline_kernel(function: _Function) -> _Function:
    """Let kernels call a small function, which dissolves in them; Python calls it interpreted."""
    return _inlined(function)


def no_refcount_kernel(function: _Function) -> _Function:
    """Compile a kernel that only reads and writes arrays of its caller: it makes none."""
    return _compiled(function, **_NO_REFCOUNT)


def no_refcount_inline_kernel(function: _Function) -> _Function:
    """Compile a small `no_refcount_kernel` that must dissolve in its caller."""
    return _inlined(function, **_NO_REFCOUNT)
