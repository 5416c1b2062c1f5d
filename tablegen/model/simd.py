"""Several particles in one vector register, and the operations on one particle or several.

Nobody needs this file to change the physics; the head of `tablegen.model` says how a kernel is
written.

`Lanes` is a numba type of WIDTH floats, `Mask` one of WIDTH truth values. Lanes add, multiply and
compare as floats do, so each kernel of the model is written once: with floats it follows one
particle, with lanes WIDTH of them in lockstep. In place of a branch it uses the functions below,
which accept floats and lanes.

Each operation is that of IEEE 754 in every lane, and a product and a sum are fused only by `fma`.
So a particle has the same bits alone, in any lane and on any processor. The last digits may differ
between processors only where numbers come from the C library (the arc sine of the polynomial and
tabulated laws and the power of the power law, in `tablegen.model.contact_laws`) or from linear
algebra (the principal axes of a mesh).

The lanes are the last dimension of an array: the motion of one particle has the shape (13,), and
that of WIDTH particles (13, WIDTH). `load` and `store` read and write an entry of either.
"""

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.errors import TypingError
from numba.core.typeconv import Conversion
from numba.extending import lower_builtin, lower_cast, models, register_model, type_callable

from tablegen.model.jit import inline_kernel, operation

#: Particles followed together: a vector register of 64 bytes, or two of 32.
WIDTH = 8

_NUMBER = ir.DoubleType()
_VECTOR = ir.VectorType(_NUMBER, WIDTH)
_INDEX = ir.IntType(32)


class _VectorType(types.Type):
    """Numba type of WIDTH values; a single value converts to equal lanes."""

    scalars: tuple[type, ...]

    def __init__(self) -> None:
        super().__init__(name=f"{type(self).__name__.lower()}{WIDTH}")

    def can_convert_from(self, typingctx, other):
        """Allow one value where lanes are expected."""
        return Conversion.safe if isinstance(other, self.scalars) else None

    def unify(self, typingctx, other):
        """Allow a variable to begin as one value and become lanes."""
        return self if isinstance(other, self.scalars) else None


class Lanes(_VectorType):
    """Numba type of WIDTH floats; a number converts to equal lanes."""

    scalars = (types.Float, types.Integer)


class Mask(_VectorType):
    """Numba type of WIDTH truth values; a truth value converts to equal lanes."""

    scalars = (types.Boolean,)


lanes, mask = Lanes(), Mask()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _VECTOR)


@register_model(Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.VectorType(ir.IntType(1), WIDTH))


def _splat(builder, value):
    """Make a vector with ``value`` in every lane."""
    vector = ir.Constant(ir.VectorType(value.type, WIDTH), ir.Undefined)
    first = builder.insert_element(vector, value, _INDEX(0))
    return builder.shuffle_vector(first, vector, ir.VectorType(_INDEX, WIDTH)([0] * WIDTH))


@lower_cast(types.Float, Lanes)
@lower_cast(types.Integer, Lanes)
def _lanes_of_number(context, builder, fromty, toty, value):
    return _splat(builder, context.cast(builder, value, fromty, types.float64))


@lower_cast(types.Boolean, Mask)
def _mask_of_truth(context, builder, fromty, toty, value):
    return _splat(builder, value)


def _operator(symbols, result, operand, count, emit):
    """Implement operators of numba for lanes or masks."""
    arguments = (operand,) * count

    # numba needs a function with as many arguments as the operator has
    def type_of_one(a):
        return result(*arguments) if a == operand else None

    def type_of_two(a, b):
        return result(*arguments) if operand in (a, b) else None

    type_of: Any = type_of_one if count == 1 else type_of_two
    for symbol in symbols:
        type_callable(symbol)(lambda context: type_of)

        @lower_builtin(symbol, *arguments)
        def implement(context, builder, sig, args):
            return emit(builder, *args)


def _ordered(predicate):
    """Make a comparison that is false where an operand is NaN."""
    return lambda builder, a, b: builder.fcmp_ordered(predicate, a, b)


def _call(builder, name, *arguments):
    """Call an LLVM intrinsic over doubles or vectors of them."""
    kind = arguments[0].type
    suffix = f"v{WIDTH}f64" if isinstance(kind, ir.VectorType) else "f64"
    declared = ir.FunctionType(kind, [kind] * len(arguments))
    function = builder.module.declare_intrinsic(f"llvm.{name}.{suffix}", fnty=declared)
    return builder.call(function, arguments)


_operator((operator.add, operator.iadd), lanes, lanes, 2, ir.IRBuilder.fadd)
_operator((operator.sub, operator.isub), lanes, lanes, 2, ir.IRBuilder.fsub)
_operator((operator.mul, operator.imul), lanes, lanes, 2, ir.IRBuilder.fmul)
_operator((operator.truediv, operator.itruediv), lanes, lanes, 2, ir.IRBuilder.fdiv)
_operator((operator.neg,), lanes, lanes, 1, ir.IRBuilder.fneg)
_operator((abs,), lanes, lanes, 1, lambda builder, x: _call(builder, "fabs", x))
_operator((operator.lt,), mask, lanes, 2, _ordered("<"))
_operator((operator.le,), mask, lanes, 2, _ordered("<="))
_operator((operator.gt,), mask, lanes, 2, _ordered(">"))
_operator((operator.ge,), mask, lanes, 2, _ordered(">="))
_operator((operator.eq,), mask, lanes, 2, _ordered("=="))
_operator((operator.and_, operator.iand), mask, mask, 2, ir.IRBuilder.and_)
_operator((operator.or_, operator.ior), mask, mask, 2, ir.IRBuilder.or_)


def number_type(*arguments):
    """Return the type of lanes if an argument has it, else float64."""
    return lanes if any(isinstance(a, Lanes) for a in arguments) else types.float64


def elementwise(emit, *arguments):
    """Make signature and code of a function of numbers, which are lanes if one of them is."""
    kind = number_type(*arguments)

    def generate(context, builder, sig, args):
        cast = [
            context.cast(builder, value, given, kind)
            for value, given in zip(args, arguments, strict=True)
        ]
        return emit(builder, *cast)

    return kind(*arguments), generate


@operation
def fma(typingctx, a, b, c):
    """Compute a b + c with one rounding."""
    return elementwise(lambda builder, *args: _call(builder, "fma", *args), a, b, c)


@operation
def sqrt(typingctx, x):
    """Compute the square root."""
    return elementwise(lambda builder, value: _call(builder, "sqrt", value), x)


@operation
def minimum(typingctx, a, b):
    """Return the second number where it is smaller, else the first, also if the second is NaN."""
    return elementwise(
        lambda builder, x, y: builder.select(builder.fcmp_ordered("<", y, x), y, x), a, b
    )


@operation
def maximum(typingctx, a, b):
    """Return the second number where it is larger, else the first, also if the second is NaN."""
    return elementwise(
        lambda builder, x, y: builder.select(builder.fcmp_ordered(">", y, x), y, x), a, b
    )


@operation
def select(typingctx, where, a, b):
    """Return a where the mask is true, else b."""
    kind = lanes if isinstance(where, Mask) else number_type(a, b)

    def generate(context, builder, sig, args):
        yes = context.cast(builder, args[1], a, kind)
        no = context.cast(builder, args[2], b, kind)
        return builder.select(args[0], yes, no)

    return kind(where, a, b), generate


@operation
def logical_not(typingctx, where):
    """Return a mask that is true where the given one is false."""

    def generate(context, builder, sig, args):
        return builder.not_(args[0])

    return where(where), generate


@operation
def any_lane(typingctx, where):
    """Tell whether the mask is true in any lane."""

    def generate(context, builder, sig, args):
        if isinstance(where, types.Boolean):
            return args[0]
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", bits, bits.type(0))

    return types.boolean(where), generate


@operation
def extract(typingctx, value, index):
    """Return the number or truth value of one lane; a single value has lane 0 only."""
    kind = {Lanes: types.float64, Mask: types.boolean}.get(type(value), value)

    def generate(context, builder, sig, args):
        if kind is value:
            return args[0]
        if isinstance(value, Lanes):
            return builder.extract_element(args[0], builder.trunc(args[1], _INDEX))
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.trunc(builder.lshr(bits, builder.trunc(args[1], bits.type)), ir.IntType(1))

    return kind(value, types.intp), generate


@operation
def mask_from_bits(typingctx, bits):
    """Make a mask whose lane l is bit l of an integer."""

    def generate(context, builder, sig, args):
        narrow = builder.trunc(args[0], ir.IntType(WIDTH))
        return builder.bitcast(narrow, ir.VectorType(ir.IntType(1), WIDTH))

    return mask(types.int64), generate


@operation
def insert(typingctx, value, index, number):
    """Replace the number of one lane; a single float becomes that number."""
    kind = types.float64

    def generate(context, builder, sig, args):
        if kind == value:
            return args[2]
        return builder.insert_element(args[0], args[2], builder.trunc(args[1], _INDEX))

    return value(value, types.intp, kind), generate


@operation
def width(typingctx, value):
    """Return the number of lanes of a value: WIDTH, or 1 for a single value."""
    count = WIDTH if isinstance(value, Lanes | Mask) else 1

    def generate(context, builder, sig, args):
        return context.get_constant(types.intp, count)

    return types.intp(value), generate


def _items(builder, values):
    """Read the items of a tuple of numbers of one type, or of a shape."""
    return [builder.extract_value(values, k) for k in range(values.type.count)]


def untyped(builder, pointer):
    """Return a pointer without the element type that numba gives pointers to arrays."""
    box = ir.Constant(ir.LiteralStructType([ir.PointerType()]), ir.Undefined)
    return builder.extract_value(builder.insert_value(box, pointer, 0), 0)


def _entry(context, builder, array, value, index_type, index):
    """Compute the pointer to an entry of a C-contiguous array; return its type, too."""
    indices = [index] if isinstance(index_type, types.Integer) else []
    if not indices:
        indices = _items(builder, index)
    view = context.make_array(array)(context, builder, value)
    shape = _items(builder, view.shape)
    offset = indices[0]
    for axis in range(1, len(indices)):
        offset = builder.add(builder.mul(offset, shape[axis]), indices[axis])
    kind = _NUMBER if array.ndim == len(indices) else _VECTOR
    place = offset if kind is _NUMBER else builder.mul(offset, offset.type(WIDTH))
    return builder.gep(view.data, [place], source_etype=_NUMBER), kind


def _index_type(index):
    """Return the type of indices as signed machine words."""
    if isinstance(index, types.Integer):
        return types.intp
    return types.UniTuple(types.intp, len(index))


def _entry_type(array, index):
    """Return the type of an entry, lanes if the index leaves one dimension over, else float."""
    if array.dtype != types.float64 or array.layout != "C":
        raise TypingError(f"got {array}, allowed: a C-contiguous float64 array")
    given = 1 if isinstance(index, types.Integer) else len(index)
    return types.float64 if array.ndim == given else lanes


@operation
def load(typingctx, array, index):
    """Read an entry of a C-contiguous array: a float, or the lanes of its last dimension."""
    kind, where = _entry_type(array, index), _index_type(index)

    def generate(context, builder, sig, args):
        pointer, kind = _entry(context, builder, array, args[0], where, args[1])
        return builder.load(pointer, align=8, typ=kind)

    return kind(array, where), generate


@operation
def store(typingctx, array, index, value):
    """Write an entry of a C-contiguous array: a float, or the lanes of its last dimension."""
    kind, where = _entry_type(array, index), _index_type(index)

    def generate(context, builder, sig, args):
        pointer, _ = _entry(context, builder, array, args[0], where, args[1])
        builder.store(args[2], untyped(builder, pointer), align=8)
        return context.get_dummy_value()

    return types.void(array, where, kind), generate


@operation
def store_lane(typingctx, array, index, number_of_lane, value):
    """Write one lane of an entry; an entry that is a float has lane 0 only."""
    where = _index_type(index)

    def generate(context, builder, sig, args):
        pointer, kind = _entry(context, builder, array, args[0], where, args[1])
        if kind is _VECTOR:
            pointer = builder.gep(pointer, [args[2]], source_etype=_NUMBER)
        builder.store(args[3], pointer)
        return context.get_dummy_value()

    return types.void(array, where, types.intp, types.float64), generate


@inline_kernel
def load_three(array, first, *rest):
    """Read the entries (first, *rest), (first + 1, *rest) and (first + 2, *rest) of an array."""
    a, b = load(array, (first, *rest)), load(array, (first + 1, *rest))
    return a, b, load(array, (first + 2, *rest))


@inline_kernel
def store_three(array, first, vector):
    """Write three entries of an array, from ``first`` on."""
    for i in range(3):
        store(array, first + i, vector[i])


@inline_kernel
def select_three(where, a, b):
    """Return the vector a where the mask is true, else b."""
    return select(where, a[0], b[0]), select(where, a[1], b[1]), select(where, a[2], b[2])
