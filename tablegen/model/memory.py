"""Arrays of kernels: on the stack of a kernel, or at an address that the caller gives.

Nobody needs this file to change the physics.

Kernels of a rebound allocate nothing, so that C code may call them on any number of threads, and
that their machine code needs no numba. `stack_array` reserves memory that lasts until the calling
kernel returns: call it in the kernel that uses the array or passes it down, and never in a loop.
"""

from typing import Any

from numba import types
from numba.np.arrayobj import populate_array

from tablegen.model.jit import operation

#: Bytes of a vector register and of a cache line; stack memory begins at a multiple of it.
_ALIGNMENT = 64


def _make_array(context: Any, builder: Any, kind: Any, data: Any, lengths: list[Any]) -> Any:
    """Make an array of numbers that lie at an address, row by row."""
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    strides = [context.get_constant(types.intp, size)]
    for length in reversed(lengths[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    array = context.make_array(kind)(context, builder)
    populate_array(
        array,
        data=builder.bitcast(data, array.data.type),
        shape=lengths,
        strides=strides,
        itemsize=context.get_constant(types.intp, size),
        meminfo=None,
    )
    return array._getvalue()


def _lengths(builder: Any, shape: Any) -> list[Any]:
    return [builder.extract_value(shape, k) for k in range(shape.type.count)]


def _on_stack(dtype: Any, shape: Any) -> tuple[Any, Any]:
    """Give the type of a call that makes an array on the stack, and write its code."""
    kind = types.Array(dtype, len(shape), "C")

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        lengths = _lengths(builder, args[0])
        count = lengths[0]
        for length in lengths[1:]:
            count = builder.mul(count, length)
        data = builder.alloca(context.get_data_type(dtype), size=count)
        data.align = _ALIGNMENT
        return _make_array(context, builder, kind, data, lengths)

    return kind(types.UniTuple(types.intp, len(shape))), generate


@operation
def stack_array(typingctx: Any, shape: Any) -> Any:
    """Make an array of floats on the stack; its numbers are not set."""
    return _on_stack(types.float64, shape)


@operation
def stack_integers(typingctx: Any, shape: Any) -> Any:
    """Make an array of integers of 64 bits on the stack; its numbers are not set."""
    return _on_stack(types.int64, shape)


@operation
def array_at(typingctx: Any, pointer: Any, first: Any, shape: Any) -> Any:
    """Make an array of numbers that lie behind each other from ``pointer[first]`` on."""
    kind = types.Array(pointer.dtype, len(shape), "C")
    shapes = types.UniTuple(types.intp, len(shape))

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        item = context.get_data_type(pointer.dtype)
        address = builder.bitcast(args[0], item.as_pointer())
        data = builder.gep(address, [args[1]])
        return _make_array(context, builder, kind, data, _lengths(builder, args[2]))

    return kind(pointer, types.intp, shapes), generate
