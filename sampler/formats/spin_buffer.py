"""A spin law as one array, so that a draw gets one more argument and not some thirty.

Compiled functions are handed every field of a tuple, again at each call; with all fields of a spin
law a draw took up to ten times as long, also for particles that do not spin. The array begins with
the numbers of the law and with the place and length of each of its arrays, which follow, each on a
cache line. `sampler.drawing.spin_view` reads it in kernels.

Experts and quantiles, most of the bytes, are arrays of their own. How long compiled code takes to
hand over a table depends on how its fields lie on the stack, and so does a draw alone: with these
two it takes as long as before there was a spin law, with one array fewer or more up to twice that
(`tests/benchmarks/bench_spin.py`, AMD EPYC with AVX-512).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.formats.bounds import SpinArrays, TableArrays
from sampler.formats.grain_law import GrainLaw
from sampler.formats.packing_memory import aligned

#: Numbers of the law in its first words, and floats in those behind them.
INTEGERS = ("n_shapes", "n_knots", "serves_all")
REALS = (
    *("alpha_first", "alpha_last", "alpha_low", "alpha_high"),
    *("speed_first", "speed_last", "speed_low", "speed_high", "speed_scale", "speed_exponent"),
)

#: Arrays of the grains and of the law: name, type, and shape of an entry.
GRAIN_ARRAYS = (
    ("shape_codes", np.int64, ()),
    ("cumulative_weights", np.float64, ()),
    ("aspect", np.float64, (4,)),
    ("fixed_ratios", np.float64, (2,)),
)
LAW_ARRAYS = (
    ("shape_codes", np.int64, ()),
    ("ratio_range", np.float64, (2, 2)),
    ("roots", np.int32, ()),
    ("node_axis", np.int8, ()),
    ("node_cut", np.float64, ()),
    ("node_child", np.int32, ()),
    ("inputs", np.float32, ()),
    ("group_gates", np.int16, ()),
    ("gates", np.int16, ()),
    ("spans", np.float32, ()),
)

#: Words of the numbers, and of the whole head: then come place and length of each array.
NUMBERS = len(INTEGERS) + len(REALS)
_ENTRIES = (*GRAIN_ARRAYS, *LAW_ARRAYS)
_HEAD = -(-(NUMBERS + 2 * len(_ENTRIES)) // 8) * 8
_LINE = 64


def packed(law: SpinArrays) -> NDArray[np.int64]:
    """Write a spin law into one array that begins on a cache line."""
    named = [getattr(law.grains, name) for name, *_ in GRAIN_ARRAYS]
    named += [getattr(law, name) for name, *_ in LAW_ARRAYS]
    places, end = [], 8 * _HEAD
    for values in named:
        places.append(end)
        end += -(-values.nbytes // _LINE) * _LINE
    buffer = aligned((end // 8,), np.int64)
    integers, reals = (tuple(getattr(law, name) for name in part) for part in (INTEGERS, REALS))
    buffer[: len(integers)] = integers
    buffer[len(integers) : NUMBERS] = np.array(reals, dtype=np.float64).view(np.int64)
    data = buffer.view(np.uint8)
    for k, (values, place) in enumerate(zip(named, places, strict=True)):
        buffer[NUMBERS + 2 * k : NUMBERS + 2 * k + 2] = place, len(values)
        data[place : place + values.nbytes] = np.ascontiguousarray(values).view(np.uint8).ravel()
    return buffer


def law_in(arrays: TableArrays) -> SpinArrays:
    """Give the spin law of a table; its arrays are views."""
    buffer = arrays.spin
    data = buffer.view(np.uint8)
    found: list[NDArray[Any]] = []
    for k, (_, dtype, entry) in enumerate(_ENTRIES):
        place, length = (int(word) for word in buffer[NUMBERS + 2 * k : NUMBERS + 2 * k + 2])
        shape = (length, *entry)
        size = int(np.prod(shape)) * np.dtype(dtype).itemsize
        found.append(data[place : place + size].view(dtype).reshape(shape))
    integers: list[Any] = [int(word) for word in buffer[: len(INTEGERS)]]
    reals: list[Any] = [float(x) for x in buffer[len(INTEGERS) : NUMBERS].view(np.float64)]
    grains = GrainLaw(*found[: len(GRAIN_ARRAYS)])
    own = dict(zip((name for name, *_ in LAW_ARRAYS), found[len(GRAIN_ARRAYS) :], strict=True))
    numbers: list[Any] = [*integers, *reals, grains]
    fields: dict[str, Any] = {**own, "experts": arrays.experts, "quantiles": arrays.spin_quantiles}
    return SpinArrays(*numbers, **fields)
