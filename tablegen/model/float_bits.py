"""Powers of two in the bits of floats and lanes, which exponential and logarithm start from."""

from llvmlite import ir
from numba import types

from tablegen.model.jit import operation
from tablegen.model.simd import WIDTH, elementwise, number_type

_WORDS = ir.VectorType(ir.IntType(64), WIDTH)

#: Bits of the float 2^52.
_TWO_52 = 0x4330_0000_0000_0000


def _word_type(number):
    """Integers of the size and number of the given floats."""
    return _WORDS if isinstance(number.type, ir.VectorType) else ir.IntType(64)


def _constant(kind, value):
    """Constant of a type, in every lane."""
    return kind([value] * WIDTH) if isinstance(kind, ir.VectorType) else kind(value)


@operation
def split_exponent(typingctx, x):
    """Return m in [1/2, 1) and e, both numbers, with x = m 2^e, for x positive and normal."""
    kind = number_type(x)

    def generate(context, builder, sig, args):
        number = context.cast(builder, args[0], x, kind)
        word = _word_type(number)
        bits = builder.bitcast(number, word)
        # the exponent's bits under the implicit one of 2^52 are a float without conversion
        exponent = builder.or_(builder.lshr(bits, _constant(word, 52)), _constant(word, _TWO_52))
        exponent = builder.bitcast(exponent, number.type)
        exponent = builder.fsub(exponent, _constant(number.type, 2.0**52 + 1022.0))
        fraction = builder.and_(bits, _constant(word, (1 << 52) - 1))
        fraction = builder.or_(fraction, _constant(word, 1022 << 52))
        return context.make_tuple(
            builder, sig.return_type, (builder.bitcast(fraction, number.type), exponent)
        )

    return types.UniTuple(kind, 2)(x), generate


@operation
def power_of_two(typingctx, k):
    """2^k for an integer k from -1022 to 1023."""

    def emit(builder, number):
        word = _word_type(number)
        shifted = builder.fadd(number, _constant(number.type, 2.0**52 + 1023.0))
        bits = builder.shl(builder.bitcast(shifted, word), _constant(word, 52))
        return builder.bitcast(bits, number.type)

    return elementwise(emit, k)
