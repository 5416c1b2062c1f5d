"""Sums of products in vector registers, for the fit of experts in `tablegen.fitting.expectation`.

Nobody needs this file to change the physics or the fit. It is written in LLVM because numba does
not keep a tile of sums in registers, and a BLAS product for each expert takes more than twice as
long (tablegen/fitting/EXPERIMENTS.md, "Time of a fit").
"""

from typing import Any

from llvmlite import ir
from numba import types

from tablegen.model.jit import operation
from tablegen.model.simd import untyped

#: Rows and columns of a tile: as many sums as fit into vector registers.
TILE_ROWS, TILE_COLUMNS = 6, 16

_NUMBER = ir.FloatType()
_VECTOR = ir.VectorType(_NUMBER, TILE_COLUMNS)
_LANE = ir.IntType(32)


def _repeated(builder: Any, value: Any) -> Any:
    """Make a vector with ``value`` in every lane."""
    first = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, _LANE(0))
    lanes = ir.VectorType(_LANE, TILE_COLUMNS)
    return builder.shuffle_vector(first, first, lanes([0] * TILE_COLUMNS))


@operation
def write_tile(
    typingctx: Any, left: Any, right: Any, count: Any, row: Any, column: Any, sums: Any
) -> Any:
    """Write one tile of the matrix product left^T right.

    ``left`` (count, .) and ``right`` (count, .) are C-contiguous arrays of float32. The tile has
    the columns of ``left`` from ``row`` on and those of ``right`` from ``column`` on. It is written
    to ``sums`` from [row, column] on; products are fused with their sums.
    """
    signature = types.void(left, right, types.intp, types.intp, types.intp, sums)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        left, right, sums = (
            context.make_array(sig.args[k])(context, builder, args[k]) for k in (0, 1, 5)
        )
        count, row, column = args[2:5]
        left_width, right_width, sums_width = (
            builder.extract_value(array.shape, 1) for array in (left, right, sums)
        )
        fma = builder.module.declare_intrinsic(
            f"llvm.fma.v{TILE_COLUMNS}f32", fnty=ir.FunctionType(_VECTOR, [_VECTOR] * 3)
        )
        before = builder.basic_block
        loop, after = (builder.append_basic_block(name) for name in ("loop", "after"))
        zeros = ir.Constant(_VECTOR, [0.0] * TILE_COLUMNS)
        builder.cbranch(builder.icmp_signed(">", count, count.type(0)), loop, after)

        # the loop over the rows of both arrays adds one product to each sum of the tile
        builder.position_at_end(loop)
        k = builder.phi(count.type)
        totals = [builder.phi(_VECTOR) for _ in range(TILE_ROWS)]
        left_at = builder.add(builder.mul(k, left_width), row)
        right_at = builder.add(builder.mul(k, right_width), column)
        first = builder.gep(left.data, [left_at], source_etype=_NUMBER)
        vector_at = builder.gep(right.data, [right_at], source_etype=_NUMBER)
        vector = builder.load(vector_at, align=4, typ=_VECTOR)
        increased = []
        for i, total in enumerate(totals):
            number_at = builder.gep(first, [_LANE(i)], source_etype=_NUMBER)
            number = builder.load(number_at, align=4, typ=_NUMBER)
            increased.append(builder.call(fma, [_repeated(builder, number), vector, total]))
        following = builder.add(k, k.type(1))
        builder.cbranch(builder.icmp_signed("<", following, count), loop, after)
        k.add_incoming(k.type(0), before)
        k.add_incoming(following, loop)
        for total, sum_ in zip(totals, increased, strict=True):
            total.add_incoming(zeros, before)
            total.add_incoming(sum_, loop)

        builder.position_at_end(after)
        tile = [builder.phi(_VECTOR) for _ in range(TILE_ROWS)]
        for result, sum_ in zip(tile, increased, strict=True):
            result.add_incoming(zeros, before)
            result.add_incoming(sum_, loop)
        for i, result in enumerate(tile):
            tile_row = builder.add(row, row.type(i))
            place = builder.add(builder.mul(tile_row, sums_width), column)
            target = builder.gep(sums.data, [place], source_etype=_NUMBER)
            builder.store(result, untyped(builder, target), align=4)
        return context.get_dummy_value()

    return signature, generate
