"""The one place where JIT options live.

Every kernel of both packages is compiled with these options, so that a question such as
"do we reassociate floating-point sums?" has one answer. We do not: ``fastmath`` is off, which
keeps results independent of batch size and lets NaN be tested for.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

_Function = TypeVar("_Function", bound=Callable[..., Any])


def kernel(function: _Function) -> _Function:
    """Compile a kernel; decorator of every one of them.

    ``nogil`` lets plain threads run kernels side by side; ``error_model="numpy"`` removes the
    zero-division branches, which the kernels exclude themselves. To a type checker the function
    stays what it was.
    """
    compiled = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    return cast(_Function, compiled)


def inline_kernel(function: _Function) -> _Function:
    """Compile a small function that must dissolve in its caller; else as `kernel`."""
    compiled = numba.njit(
        cache=True, nogil=True, error_model="numpy", inline="never", forceinline=True
    )(function)
    return cast(_Function, compiled)
