"""Kernels of the fit of experts: shares of the experts in each rebound, and weighted sums.

Arrays with numbers of n rebounds have single precision, and sums have double. Rebounds come last,
(k, n), so that loops over them have no sum or maximum and run in vector registers. Experts are
numbered group by group: k experts in g groups.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numpy.typing import NDArray

from tablegen.model.jit import inline_kernel, kernel, operation

Single = NDArray[np.float32]

_F = np.float32
_HALF, _ONE, _ZERO = _F(0.5), _F(1.0), _F(0.0)

#: Below 2**-60 a weight counts for nothing. Products of two weights are then normal numbers:
#: processors take a hundred cycles for each that is not.
_LEAST_POWER = _F(-60.0)
#: The same for a gate, so that the densest expert counts whatever its gate.
_LEAST_GATE = _F(-30.0)
#: Smaller shares are 0; and the least sum of densities times priors.
_LEAST, _LEAST_TOTAL = _F(2.0**-60), _F(1e-30)
_LOG2_E = _F(1.4426950408889634)
#: 2**x on [-1/2, 1/2]: Taylor coefficients of exp(x ln 2), relative error below 3e-7.
_C1, _C2, _C3 = _F(0.6931471805599453), _F(0.2402265069591007), _F(0.05550410866482158)
_C4, _C5, _C6 = _F(0.009618129107628477), _F(0.0013333558146428443), _F(0.00015403530393381608)
_EXPONENT_BIAS, _EXPONENT_SHIFT = np.int32(127), np.uint32(23)


@inline_kernel
def exponential(x: np.float32, least: np.float32) -> np.float32:
    """Return the exponential of a float32 that is not positive, or 2**least if it is smaller."""
    y = max(x * _LOG2_E, least)
    n = np.int32(y - _HALF)
    r = y - _F(n)
    p = _ONE + r * (_C1 + r * (_C2 + r * (_C3 + r * (_C4 + r * (_C5 + r * _C6)))))
    bits = np.uint32(n + _EXPONENT_BIAS) << _EXPONENT_SHIFT
    return p * np.uint32(bits).view(np.float32)


#: Products are summed in tiles of a x b: as many sums as fit into vector registers.
_TILE_A, _TILE_B = 6, 16


@kernel
def softmax(logits: NDArray[np.float32]) -> None:
    """Turn logits (g, k, n) of k choices into probabilities, in place."""
    count = logits.shape[2]
    top, total = np.empty(count, np.float32), np.empty(count, np.float32)
    for g in range(logits.shape[0]):
        top[:] = logits[g, 0]
        for k in range(1, logits.shape[1]):
            row = logits[g, k]
            for i in range(count):
                top[i] = max(top[i], row[i])
        total[:] = _ZERO
        for k in range(logits.shape[1]):
            row = logits[g, k]
            for i in range(count):
                row[i] = exponential(row[i] - top[i], _LEAST_GATE)
                total[i] += row[i]
        for i in range(count):
            total[i] = _ONE / total[i]
        for k in range(logits.shape[1]):
            row = logits[g, k]
            for i in range(count):
                row[i] *= total[i]


@kernel
def add_densities(white: Single, constant: Single, log_density: Single) -> None:
    """Compute logarithms of densities (k, n) from whitened outcomes (d * k, n).

    Whitened outcomes, (x - mean) / factor, begin with the first components of all experts.
    """
    count = constant.size
    for k in range(count):
        out = log_density[k]
        out[:] = constant[k]
        for j in range(k, white.shape[0], count):
            part = white[j]
            for i in range(out.size):
                out[i] -= _HALF * part[i] * part[i]


@kernel
def find_shares(
    log_density: Single, group: Single, expert: Single, by_group: Single, by_expert: Single
) -> float:
    """Find the shares of the experts in each rebound, and the gradients of the gates.

    Parameters
    ----------
    log_density : (k, n) float32
        Overwritten with the shares: 0, or a normal number.
    group, expert : (g, n) and (k, n) float32
        Probabilities of the groups, and of the experts given their group.
    by_group, by_expert : (g, n) and (k, n) float32
        Output: gradients of the log-likelihood, which is returned, with respect to the logits.
    """
    groups, (count, size) = group.shape[0], log_density.shape
    each, likelihood = count // groups, 0.0
    top, total = np.empty(size, np.float32), np.zeros(size, np.float32)
    top[:] = log_density[0]
    for k in range(1, count):
        share = log_density[k]
        for i in range(size):
            top[i] = max(top[i], share[i])
    for g in range(groups):
        part, of_group = by_group[g], group[g]
        part[:] = _ZERO
        for k in range(g * each, (g + 1) * each):
            share, prior = log_density[k], expert[k]
            for i in range(size):
                value = exponential(share[i] - top[i], _LEAST_POWER) * prior[i]
                share[i] = value if value > _LEAST else _ZERO
                part[i] += share[i]
        for i in range(size):
            part[i] *= of_group[i]
            total[i] += part[i]
    for i in range(size):
        total[i] = max(total[i], _LEAST_TOTAL)
        likelihood += top[i] + np.log(total[i])
        total[i] = _ONE / total[i]
    for g in range(groups):
        part, of_group = by_group[g], group[g]
        for i in range(size):
            value = part[i] * total[i]
            part[i] = value if value > _LEAST else _ZERO
            top[i] = of_group[i] * total[i]
        for k in range(g * each, (g + 1) * each):
            share, prior, out = log_density[k], expert[k], by_expert[k]
            for i in range(size):
                value = share[i] * top[i]
                share[i] = value if value > _LEAST else _ZERO
                out[i] = value - part[i] * prior[i]
        for i in range(size):
            part[i] -= of_group[i]
    return likelihood


@kernel
def find_curvatures(
    share: Single, group: Single, expert: Single, by_group: Single, by_expert: Single
) -> None:
    """Find diagonal second derivatives of minus the log-likelihood with respect to the logits.

    The parameters are those of `find_shares` after its call; ``by_group`` and ``by_expert`` are
    overwritten.
    """
    groups, (count, size) = group.shape[0], share.shape
    each = count // groups
    for g in range(groups):
        for i in range(size):
            by_group[g, i] += group[g, i]
        part = by_group[g]
        for k in range(g * each, (g + 1) * each):
            for i in range(size):
                by_expert[k, i] = part[i] * expert[k, i] * (_ONE - expert[k, i])
        for i in range(size):
            part[i] = group[g, i] * (_ONE - group[g, i])


@operation
def _add_tile(typingctx: Any, one: Any, other: Any, count: Any, a: Any, b: Any, sums: Any) -> Any:
    """Write sums over rows of one[:, a : a + _TILE_A] times other[:, b : b + _TILE_B].

    The arrays (count, .) are C-contiguous. Sums (., .) are written from [a, b] on.
    """
    signature = types.void(one, other, types.intp, types.intp, types.intp, sums)
    vector = ir.VectorType(ir.FloatType(), _TILE_B)
    lane = ir.IntType(32)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        views = [context.make_array(sig.args[k])(context, builder, args[k]) for k in (0, 1, 5)]
        strides = [builder.extract_value(view.shape, 1) for view in views]
        fma = builder.module.declare_intrinsic(
            f"llvm.fma.v{_TILE_B}f32", fnty=ir.FunctionType(vector, [vector] * 3)
        )
        before = builder.basic_block
        loop, after = (builder.append_basic_block(name) for name in ("rows", "after"))
        empty = ir.Constant(vector, [0.0] * _TILE_B)
        some = builder.icmp_signed(">", args[2], args[2].type(0))
        builder.cbranch(some, loop, after)
        builder.position_at_end(loop)
        row = builder.phi(args[2].type)
        totals = [builder.phi(vector) for _ in range(_TILE_A)]
        first = builder.gep(views[0].data, [builder.add(builder.mul(row, strides[0]), args[3])])
        second = builder.gep(views[1].data, [builder.add(builder.mul(row, strides[1]), args[4])])
        right = builder.load(builder.bitcast(second, vector.as_pointer()), align=4)
        ends = []
        for k, total in enumerate(totals):
            left = builder.load(builder.gep(first, [lane(k)]), align=4)
            start = builder.insert_element(ir.Constant(vector, ir.Undefined), left, lane(0))
            splat = builder.shuffle_vector(
                start, start, ir.VectorType(lane, _TILE_B)([0] * _TILE_B)
            )
            ends.append(builder.call(fma, [splat, right, total]))
        following = builder.add(row, row.type(1))
        builder.cbranch(builder.icmp_signed("<", following, args[2]), loop, after)
        row.add_incoming(row.type(0), before)
        row.add_incoming(following, loop)
        for total, end in zip(totals, ends, strict=True):
            total.add_incoming(empty, before)
            total.add_incoming(end, loop)
        builder.position_at_end(after)
        for k, end in enumerate(ends):
            whole = builder.phi(vector)
            whole.add_incoming(empty, before)
            whole.add_incoming(end, loop)
            ends[k] = whole
        for k, whole in enumerate(ends):
            place = builder.add(
                builder.mul(builder.add(args[3], args[3].type(k)), strides[2]), args[4]
            )
            target = builder.bitcast(builder.gep(views[2].data, [place]), vector.as_pointer())
            builder.store(whole, target, align=4)
        return context.get_dummy_value()

    return signature, generate


@kernel
def add_products(
    weight: Single, vectors: Single, least: np.float32, products: NDArray[np.float64]
) -> None:
    """Add sums of v_i v_j, i <= j, with each row of weights to products (k, d, d).

    Weights (k, n) below the least are left out; vectors are (n, d).
    """
    count, width = vectors.shape
    # whole tiles, and vectors with zeros at their end
    wide = -(-width // _TILE_B) * _TILE_B
    padded = -(-width // _TILE_A) * _TILE_A
    one = np.zeros((count, padded), dtype=np.float32)
    other = np.zeros((count, wide), dtype=np.float32)
    sums = np.empty((padded, wide), dtype=np.float32)
    rows = np.empty(count, dtype=np.int32)
    for k in range(weight.shape[0]):
        of_expert = weight[k]
        some = 0
        for i in range(count):
            rows[some] = i
            some += of_expert[i] >= least
        if some == 0:
            continue
        for j in range(some):
            i = rows[j]
            w, vector = of_expert[i], vectors[i]
            to_one, to_other = one[j], other[j]
            for a in range(width):
                to_one[a] = w * vector[a]
                to_other[a] = vector[a]
        for a in range(0, width, _TILE_A):
            for b in range(a // _TILE_B * _TILE_B, width, _TILE_B):
                _add_tile(one, other, some, a, b, sums)
        out = products[k]
        for a in range(width):
            for b in range(a, width):
                out[a, b] += sums[a, b]
