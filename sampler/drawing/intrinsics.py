"""Operations that numba does not offer: arrays on the stack, prefetching, bits of numbers.

They are as small as can be; everything else is written in plain Python. Of numba and llvmlite they
use what is public, but for the fields of numba's arrays, which the public interface does not reach.
"""

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def operation(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of kernels from one that types a call and writes its code."""
    return cast(Callable[..., Any], intrinsic(function))


def _array(context, builder, kind, value=None):
    """Structure of an array, whose fields can be read and set; a new one without a value."""
    return context.make_array(kind)(context, builder, value)


_BYTE = ir.IntType(8)
_WORD = ir.IntType(32)
_LONG = ir.IntType(64)

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

    @operation
    def make(typingctx):
        def emit(context, builder, sig, args):
            element = context.get_data_type(dtype)
            room = ir.ArrayType(element, length)
            with builder.goto_entry_block():
                place = builder.alloca(room)
                # rows that a table lacks are read as well, and must be finite
                builder.store(room(None), place)
            place.align = _LINE
            count = context.get_constant(types.intp, length)
            size = context.get_constant(types.intp, context.get_abi_sizeof(element))
            one = ir.ArrayType(count.type, 1)
            array = _array(context, builder, array_type)
            array.data = builder.bitcast(place, element.as_pointer())
            array.shape, array.strides = ir.Constant(one, [count]), ir.Constant(one, [size])
            array.nitems, array.itemsize = count, size
            # nobody owns it
            array.meminfo = context.get_value_type(types.MemInfoPointer(types.voidptr))(None)
            array.parent = context.get_value_type(types.pyobject)(None)
            return array._getvalue()

        return array_type(), emit

    return make


@operation
def prefetch(typingctx, array, index):
    """Ask for the cache line of element ``index`` of a one-dimensional contiguous array."""

    def emit(context, builder, sig, args):
        source = _array(context, builder, sig.args[0], args[0])
        place = builder.bitcast(builder.gep(source.data, [args[1]]), _BYTE.as_pointer())
        kind = ir.FunctionType(ir.VoidType(), [_BYTE.as_pointer(), _WORD, _WORD, _WORD])
        function = builder.module.declare_intrinsic("llvm.prefetch.p0i8", fnty=kind)
        # for reading, to stay in all levels of the cache, data
        builder.call(function, [place, _WORD(0), _WORD(3), _WORD(1)])
        return context.get_dummy_value()

    return types.void(array, types.intp), emit


@operation
def mean_of_corners(typingctx, steps, channels, entries, fractions, weights, draw, means):
    """Weighted means over the four corners of a cell, between two knots, for all rows of one draw.

    The mean is the sum over corners c of w_c (low_c + f (high_c - low_c)), summed as
    (0 + 1) + (2 + 3), in single precision. ``steps`` (uint16) has the corners' low values at the
    entry of a row and their high values after them. ``entries``, ``fractions`` and ``means`` have
    eight numbers a draw, of which the first are those of ``channels``; ``weights`` has four.

    Written with vectors of eight, four corners of two rows each: as a loop over rows it is not
    recognised as such, and a batch takes a quarter longer.
    """
    lanes = 8
    shorts = ir.VectorType(ir.IntType(16), lanes)
    longs = ir.VectorType(_WORD, lanes)
    singles = ir.VectorType(ir.FloatType(), lanes)
    # an even number of rows, the last one twice where there is one more
    rows = [min(row, len(channels) - 1) for row in range(len(channels) + len(channels) % 2)]

    def emit(context, builder, sig, args):
        source, _, entries, fractions, weights, _, means = (
            _array(context, builder, kind, value).data if isinstance(kind, types.Array) else value
            for kind, value in zip(sig.args, args, strict=True)
        )

        def place(array, numbers):
            index = builder.mul(args[5], args[5].type(numbers))
            return builder.gep(array, [index])

        def load(array, numbers):
            kind = ir.VectorType(ir.FloatType(), numbers)
            return builder.load(builder.bitcast(place(array, numbers), kind.as_pointer()), align=4)

        def shuffled(a, b, lanes_of):
            return builder.shuffle_vector(a, b, ir.Constant(longs, lanes_of))

        def corners(row):
            entry = builder.load(builder.gep(place(entries, lanes), [_WORD(row)]))
            first = builder.gep(source, [builder.sext(entry, args[5].type)])
            whole = builder.load(builder.bitcast(first, shorts.as_pointer()), align=2)
            return builder.sitofp(builder.zext(whole, longs), singles)

        def halves_summed(a, b):
            even = shuffled(a, b, list(range(0, 2 * lanes, 2)))
            return builder.fadd(even, shuffled(a, b, list(range(1, 2 * lanes, 2))))

        weight, fraction = load(weights, 4), load(fractions, lanes)
        weight = shuffled(weight, weight, [0, 1, 2, 3, 0, 1, 2, 3])
        terms = []
        for k in range(0, len(rows), 2):
            a, b = corners(rows[k]), corners(rows[k + 1])
            low = shuffled(a, b, [0, 1, 2, 3, 8, 9, 10, 11])
            high = shuffled(a, b, [4, 5, 6, 7, 12, 13, 14, 15])
            f = shuffled(fraction, fraction, [rows[k]] * 4 + [rows[k + 1]] * 4)
            rise = builder.fmul(f, builder.fsub(high, low))
            terms.append(builder.fmul(weight, builder.fadd(low, rise)))
        terms += [terms[-1]] * (4 - len(terms))
        total = halves_summed(halves_summed(*terms[:2]), halves_summed(*terms[2:]))
        target = builder.bitcast(place(means, lanes), singles.as_pointer())
        builder.store(total, target, align=4)
        return context.get_dummy_value()

    return types.void(steps, channels, entries, fractions, weights, types.intp, means), emit


def array_viewer(dtype: types.Type, columns: int = 0) -> Callable[..., Any]:
    """Make a kernel function that gives a view of part of an array, as another type.

    Nobody counts references to the view: it must not be returned to Python, nor outlive the array.

    Parameters
    ----------
    dtype : numba type
        Of the view.
    columns : int
        Of a view of two dimensions; 0: it has one.

    Returns
    -------
    callable
        Takes an int64 array, the place of the view in bytes, and its length or number of rows.
    """
    array_type = types.Array(dtype, 2 if columns else 1, "C")

    @operation
    def view(typingctx, buffer, place, length):
        def emit(context, builder, sig, args):
            element = context.get_data_type(dtype)
            start = _array(context, builder, sig.args[0], args[0]).data
            words = [builder.sext(a, _LONG) if a.type != _LONG else a for a in args[1:]]
            begin = builder.gep(builder.bitcast(start, _BYTE.as_pointer()), [words[0]])
            bytes_each = context.get_abi_sizeof(element)
            row = _LONG(bytes_each * max(columns, 1))
            shape = [words[1], _LONG(columns)] if columns else [words[1]]
            strides = [row, _LONG(bytes_each)] if columns else [row]
            array = _array(context, builder, array_type)
            array.data = builder.bitcast(begin, element.as_pointer())
            array.shape, array.strides = (_of_longs(builder, part) for part in (shape, strides))
            array.nitems = builder.mul(words[1], _LONG(max(columns, 1)))
            array.itemsize = _LONG(bytes_each)
            array.meminfo = context.get_value_type(types.MemInfoPointer(types.voidptr))(None)
            array.parent = context.get_value_type(types.pyobject)(None)
            return array._getvalue()

        return array_type(buffer, types.intp, types.intp), emit

    return view


def _of_longs(builder, values):
    """Array of 64-bit integers as a value."""
    whole = ir.Constant(ir.ArrayType(_LONG, len(values)), ir.Undefined)
    for k, value in enumerate(values):
        whole = builder.insert_value(whole, value, k)
    return whole


def row_summer(rows: int, lanes: int, stride: int) -> Callable[..., None]:
    """Make a kernel function that adds up rows of integers, each times a number of its own.

    The sums stay in registers; as a loop over an array they would wait for memory in every row.

    Parameters
    ----------
    rows : int
    lanes : int
        Numbers of a row that are read, and of the result.
    stride : int
        Numbers from one row to the next.

    Returns
    -------
    callable
        Takes an int16 array and where the first row begins, a float32 array and where the factors
        begin, and a float32 array and where the sums go. They are 0 + row 0 * factor 0 + ..., in
        that order, in single precision.
    """
    shorts, longs = (ir.VectorType(ir.IntType(bits), lanes) for bits in (16, 32))
    singles = ir.VectorType(ir.FloatType(), lanes)

    @operation
    def sum_rows(typingctx, numbers, start, factors, first, sums, place):
        def emit(context, builder, sig, args):
            def begin(k):
                return builder.gep(
                    _array(context, builder, sig.args[k], args[k]).data, [args[k + 1]]
                )

            source, factor, target = begin(0), begin(2), begin(4)
            total = singles(None)
            for row in range(rows):
                whole = builder.bitcast(
                    builder.gep(source, [_WORD(row * stride)]), shorts.as_pointer()
                )
                values = builder.sitofp(builder.sext(builder.load(whole, align=2), longs), singles)
                one = builder.load(builder.gep(factor, [_WORD(row)]))
                alone = builder.insert_element(singles(None), one, _WORD(0))
                every = builder.shuffle_vector(alone, singles(None), longs(None))
                total = builder.fadd(total, builder.fmul(every, values))
            builder.store(total, builder.bitcast(target, singles.as_pointer()), align=4)
            return context.get_dummy_value()

        return types.void(numbers, types.intp, factors, types.intp, sums, types.intp), emit

    return cast(Callable[..., None], sum_rows)


@operation
def single_bits(typingctx, value):
    """Get the bits of a float32, as uint32."""

    def emit(context, builder, sig, args):
        return builder.bitcast(args[0], _WORD)

    return types.uint32(types.float32), emit


@operation
def single_of_bits(typingctx, bits):
    """Make the float32 of these bits, a uint32."""

    def emit(context, builder, sig, args):
        return builder.bitcast(args[0], ir.FloatType())

    return types.float32(types.uint32), emit
