"""Types of what users' compiled code passes, checked while it compiles; the draw gets no slower.

Numba would compile nearly anything: a state of two dimensions is written far beyond its end, one of
integers gets zeros, and an index that is no integer is cut to one.
"""

from collections.abc import Callable
from typing import Any, cast

from numba import types
from numba.core.errors import TypingError
from numba.core.imputils import impl_ret_borrowed
from numba.extending import intrinsic


def _checked(name: str, fits: Callable[[types.Type], bool], allowed: str) -> Callable[[Any], None]:
    """Make a function of kernels that does nothing, and compiles only for types that fit."""

    @intrinsic
    def check(typingctx: Any, value: types.Type) -> Any:
        if not fits(value):
            raise TypingError(f"{name}: got {value}, allowed: {allowed}")

        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return context.get_dummy_value()

        return types.void(value), emit

    return cast(Callable[[Any], None], check)


def _is_vector(kind: Any) -> bool:
    plain = isinstance(kind, types.Array) and kind.ndim == 1 and kind.mutable
    return plain and kind.dtype == types.float64


def output_of(name: str) -> Callable[[Any], None]:
    """Make the check of an array to write to."""
    return _checked(name, _is_vector, "a writable float64 array of one dimension")


def work_space_of(name: str) -> Callable[[Any], Any]:
    """Make a function of kernels that returns its array, and compiles only for one to work in.

    What is compiled for the array takes it for a run of memory, so it must get the result and not
    the argument: then it is not compiled for a wrong one at all.
    """

    @intrinsic
    def checked(typingctx: Any, value: Any) -> Any:
        if not (_is_vector(value) and value.layout == "C"):
            allowed = "a writable contiguous float64 array of one dimension"
            raise TypingError(f"{name}: got {value}, allowed: {allowed}")

        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return impl_ret_borrowed(context, builder, sig.return_type, args[0])

        return value(value), emit

    return cast(Callable[[Any], Any], checked)


def _is_three_reals(kind: Any) -> bool:
    real = types.Float | types.Integer
    three = isinstance(kind, types.BaseTuple) and len(kind) == 3
    return three and all(isinstance(part, real) for part in kind)


def vector_of(name: str) -> Callable[[Any], None]:
    """Make the check of three numbers."""
    return _checked(name, _is_three_reals, "a tuple of three floats")


def key_of(name: str) -> Callable[[Any], None]:
    """Make the check of a key of random numbers."""
    return _checked(name, lambda kind: isinstance(kind, types.Integer), "an integer")


check_spin, check_omega, check_grain = vector_of("spin"), vector_of("omega"), vector_of("grain")
check_seed, check_index, check_hit = key_of("seed"), key_of("index"), key_of("hit")
