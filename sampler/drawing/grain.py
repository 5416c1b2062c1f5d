"""The grain of a particle, its shape and the ratios b/a and c/b, from its keys.

A grain is a pure function of (seed, index, hit), and that of hit 0 is the particle's own: whoever
follows a particle from wall to wall has nothing to store. Under the key seed XOR `SIMULATION_KEY`,
words 0 and 1 of block 0 give b/a and c/b and word 1 of block 1 the shape; direct simulation takes
the same words, and so gives a particle the same grain.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sampler.compilation.jit import no_refcount_inline_kernel, no_refcount_kernel
from sampler.drawing.normal import MIDDLE, central_ratio, normal_quantile
from sampler.drawing.philox import philox_block, uniform
from sampler.formats.bounds import LEAST_RATIO
from sampler.formats.grain_law import GrainLaw

#: Keeps the direct simulation, and the grains, of a seed on other random numbers than the draws.
SIMULATION_KEY = np.uint64(0x5349_4D55_4C41_5445)

#: The hit whose random numbers make the grain that a particle keeps.
OWN_GRAIN: Any = np.uint32(0)

Grain = tuple[float, float, float]


@no_refcount_inline_kernel
def pick_row(law: Any, u: float) -> int:
    """Row of the shapes of a law for a uniform number u in (0, 1)."""
    row = 0
    for k in range(law.shape_codes.size - 1):
        row += int(u >= law.cumulative_weights[np.uint64(k)])
    return row


@no_refcount_inline_kernel
def bounded_ratio(ratio: float) -> float:
    """Ratio from `LEAST_RATIO` to 1, of whatever number: a law that nobody simulated may go on."""
    at_least = ratio if ratio > LEAST_RATIO else LEAST_RATIO
    return at_least if at_least < 1.0 else 1.0


@no_refcount_inline_kernel
def middle_aspect_ratio(law: NDArray[np.float64], row: int, u: float) -> tuple[float, float]:
    """Aspect ratio where the normal quantile needs no tail, and how far its probability is out.

    The ratio holds where that is at most `MIDDLE`; a fixed one always does.
    """
    place = np.uint64(row)
    mean, deviation = law[place, np.uint64(0)], law[place, np.uint64(1)]
    low, high = law[place, np.uint64(2)], law[place, np.uint64(3)]
    q = low + u * (high - low) - 0.5
    ratio = mean + deviation * (q * central_ratio(0.180625 - q * q))
    ratio = bounded_ratio(ratio if deviation > 0.0 else mean)
    return ratio, (abs(q) if deviation > 0.0 else 0.0)


@no_refcount_inline_kernel
def aspect_ratio(law: NDArray[np.float64], row: int, u: float) -> float:
    """Truncated-normal aspect ratio for u in (0, 1), from a row of `GrainLaw.aspect`."""
    ratio, out = middle_aspect_ratio(law, row, u)
    if out <= MIDDLE:
        return ratio
    low, high = law[row, 2], law[row, 3]
    return bounded_ratio(law[row, 0] + law[row, 1] * normal_quantile(low + u * (high - low)))


@no_refcount_inline_kernel
def grain_numbers(seed: int, index: int, hit: int) -> Grain:
    """Uniform numbers of a grain: two aspect ratios, the shape."""
    key, particle = np.uint64(seed) ^ SIMULATION_KEY, np.uint64(index)
    w0, w1, _, _ = philox_block(key, particle, np.uint32(hit), np.uint32(0))
    _, v1, _, _ = philox_block(key, particle, np.uint32(hit), np.uint32(1))
    return uniform(w0), uniform(w1), uniform(v1)


@no_refcount_inline_kernel
def grain_of_numbers(law: GrainLaw, first: float, second: float, which: float) -> Grain:
    """Grain of three uniform numbers in (0, 1): for b/a, c/b and the shape."""
    row = pick_row(law, which)
    if law.fixed_ratios[row, 0] > 0.0:
        ratios = law.fixed_ratios[row, 0], law.fixed_ratios[row, 1]
    else:
        ratios = aspect_ratio(law.aspect, 0, first), aspect_ratio(law.aspect, 1, second)
    return float(law.shape_codes[row]), ratios[0], ratios[1]


@no_refcount_inline_kernel
def draw_grain(law: GrainLaw, seed: int, index: int, hit: int) -> Grain:
    """Draw a grain: shape code, b/a and c/b, as floats.

    Parameters
    ----------
    law : GrainLaw
        With at least one shape.
    seed, index, hit : int
        A particle that keeps its grain has that of hit `OWN_GRAIN`.
    """
    return grain_of_numbers(law, *grain_numbers(seed, index, hit))


@no_refcount_kernel
def draw_grains(
    law: GrainLaw, seed: int, index: NDArray[np.uint64], grains: NDArray[np.float64]
) -> None:
    """Draw the grains that particles keep into ``grains`` (n, 3); ``index`` is (n,) or (1,)."""
    for k in range(grains.shape[0]):
        particle = index[k] if index.size > 1 else index[0]
        grain = draw_grain(law, seed, particle, OWN_GRAIN)
        grains[k, 0], grains[k, 1], grains[k, 2] = grain
