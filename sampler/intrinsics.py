"""Operations that numba does not offer: arrays on the stack, prefetching, bits of numbers.

They are as small as can be; everything else is written in plain Python.
"""

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np import arrayobj


def _operation(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of kernels from one that types a call and writes its code."""
    return cast(Callable[..., Any], intrinsic(function))


_BYTE = ir.IntType(8)
_WORD = ir.IntType(32)

#: Alignment of arrays on the stack: a cache line, and the widest vector register.
_LINE = 64


def local_array(dtype: types.Type, length: int) -> Callable[[], Any]:
    """Make a kernel function that returns an uninitialised array on the caller's stack.

    Such an array costs nothing to make and ends with the function that made it: it must not be
    returned. Functions that make one must be inlined into, or be, the function that uses it.

    Parameters
    ----------
    dtype : numba type
    length : int

    Returns
    -------
    callable
        Without arguments; gives an array of shape (length,).
    """
    array_type = types.Array(dtype, 1, "C")

    @_operation
    def make(typingctx):
        def emit(context, builder, sig, args):
            element = context.get_data_type(dtype)
            place = cgutils.alloca_once(builder, ir.ArrayType(element, length))
            place.align = _LINE
            size = context.get_constant(types.intp, context.get_abi_sizeof(element))
            array = arrayobj.make_array(array_type)(context, builder)
            arrayobj.populate_array(
                array,
                data=builder.bitcast(place, element.as_pointer()),
                shape=cgutils.pack_array(builder, [context.get_constant(types.intp, length)]),
                strides=cgutils.pack_array(builder, [size]),
                itemsize=size,
                meminfo=None,
            )
            return array._getvalue()

        return array_type(), emit

    return make


@_operation
def prefetch(typingctx, array, index):
    """Ask for the cache line of element ``index`` of a one-dimensional contiguous array."""

    def emit(context, builder, sig, args):
        source = arrayobj.make_array(sig.args[0])(context, builder, args[0])
        place = builder.bitcast(builder.gep(source.data, [args[1]]), _BYTE.as_pointer())
        kind = ir.FunctionType(ir.VoidType(), [_BYTE.as_pointer(), _WORD, _WORD, _WORD])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
        # for reading, to stay in all levels of the cache, data
        builder.call(function, [place, _WORD(0), _WORD(3), _WORD(1)])
        return context.get_dummy_value()

    return types.void(array, types.intp), emit


@_operation
def mean_of_corners(typingctx, steps, entry, fraction, weights):
    """Weighted mean over four corners of values between two knots.

    ``steps`` (uint16) holds the four corners' values at one knot from ``entry`` on, then those at
    the next knot: (sum over c of w_c (low_c + f (high_c - low_c))), summed as (0 + 1) + (2 + 3), in
    single precision.
    Written with vectors of four, one for each corner: a draw does this for every channel.
    """
    corners = ir.VectorType(ir.FloatType(), 4)

    def emit(context, builder, sig, args):
        source = arrayobj.make_array(sig.args[0])(context, builder, args[0])

        def load(offset):
            first = builder.gep(source.data, [builder.add(args[1], args[1].type(offset))])
            place = builder.bitcast(first, ir.VectorType(ir.IntType(16), 4).as_pointer())
            whole = builder.zext(builder.load(place, align=2), ir.VectorType(ir.IntType(32), 4))
            return builder.sitofp(whole, corners)

        def vector(numbers):
            value = ir.Constant(corners, ir.Undefined)
            for k, number in enumerate(numbers):
                value = builder.insert_element(value, number, _WORD(k))
            return value

        low, high = load(0), load(4)
        rise = builder.fmul(vector([args[2]] * 4), builder.fsub(high, low))
        weighted = builder.fmul(
            vector([builder.extract_value(args[3], k) for k in range(4)]), builder.fadd(low, rise)
        )
        w = [builder.extract_element(weighted, _WORD(k)) for k in range(4)]
        return builder.fadd(builder.fadd(w[0], w[1]), builder.fadd(w[2], w[3]))

    number = types.float32
    return number(steps, types.intp, number, types.UniTuple(number, 4)), emit


@_operation
def mix_rows(
    typingctx, components, record, channels, normals, at, step, units, turn, variates, to
):
    """Mean + L n of one component, in its unit, all eight rows side by side, column by column.

    ``components`` (int16) holds at ``record`` + 1 the means, then the columns of L from the
    diagonal down, one for each of ``channels``. The normal of column k is number at + k step of
    ``normals``, and eight rows are written to ``variates`` from number ``to`` on (both float32).
    Rows above the diagonal get zeros added, and rows that the table lacks something finite: both
    read on into neighbouring numbers.
    """
    n, lanes = len(channels), 8
    shorts = ir.VectorType(ir.IntType(16), lanes)
    singles = ir.VectorType(ir.FloatType(), lanes)

    def emit(context, builder, sig, args):
        source, _, _, numbers, _, _, units, _, target, _ = (
            arrayobj.make_array(kind)(context, builder, value).data
            if isinstance(kind, types.Array)
            else value
            for kind, value in zip(sig.args, args, strict=True)
        )

        def load(offset):
            place = builder.gep(source, [builder.add(args[1], args[1].type(offset))])
            place = builder.bitcast(place, shorts.as_pointer())
            return builder.sitofp(builder.load(place, align=2), singles)

        z, first = load(1), 1 + n
        for column in range(n):
            index = builder.add(args[4], builder.mul(args[5], args[5].type(column)))
            number = builder.load(builder.gep(numbers, [index]))
            factor = builder.insert_element(ir.Constant(singles, None), number, _WORD(0))
            below = [0 if lane >= column else lanes for lane in range(lanes)]
            below = ir.Constant(ir.VectorType(_WORD, lanes), below)
            spread = builder.shuffle_vector(factor, ir.Constant(singles, None), below)
            z = builder.fadd(z, builder.fmul(load(first), spread))
            first += n - column - 1
        unit = builder.bitcast(builder.gep(units, [args[7]]), singles.as_pointer())
        place = builder.bitcast(builder.gep(target, [args[9]]), singles.as_pointer())
        builder.store(builder.fmul(z, builder.load(unit, align=4)), place, align=4)
        return context.get_dummy_value()

    number = types.intp
    kinds = (components, number, channels, normals, number, number, units, number, variates, number)
    return types.void(*kinds), emit


@_operation
def single_bits(typingctx, value):
    """Get the bits of a float32, as uint32."""

    def emit(context, builder, sig, args):
        return builder.bitcast(args[0], _WORD)

    return types.uint32(types.float32), emit


@_operation
def single_of_bits(typingctx, bits):
    """Make the float32 of these bits, a uint32."""

    def emit(context, builder, sig, args):
        return builder.bitcast(args[0], ir.FloatType())

    return types.float32(types.uint32), emit


@_operation
def read_pair(typingctx, array, index):
    """Read two neighbours of 16 bits as one int32; element ``index`` is its lower half."""

    def emit(context, builder, sig, args):
        source = arrayobj.make_array(sig.args[0])(context, builder, args[0])
        place = builder.gep(source.data, [args[1]])
        return builder.load(builder.bitcast(place, _WORD.as_pointer()), align=2)

    return types.int32(array, types.intp), emit
