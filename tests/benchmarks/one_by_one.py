"""Rebounds one by one, as a flow code asks for them: what a scalar call costs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import sampler
import tablegen
from sampler.compilation.jit import kernel
from tablegen.model.float_array import FloatArray

_draw, _simulate, _grain = sampler.draw, tablegen.draw, tablegen.grain


@kernel
def draw_first_hits(
    arrays: Any,
    alpha1: FloatArray,
    speed: FloatArray,
    seed: np.uint64,
    index: NDArray[Any],
    hit: NDArray[Any],
    state: FloatArray,
) -> None:
    """Draw from a table as if no particle spun; each state replaces the one before."""
    for k in range(len(alpha1)):
        _draw(arrays, alpha1[k], speed[k], seed, index[k], hit[k], state)


@kernel
def draw_spinning(
    arrays: Any,
    alpha1: FloatArray,
    speed: FloatArray,
    spin: FloatArray,
    seed: np.uint64,
    index: NDArray[Any],
    hit: NDArray[Any],
    state: FloatArray,
) -> None:
    """Draw from a table's spin law, with the particles' own grains."""
    for k in range(len(alpha1)):
        three = spin[k, 0], spin[k, 1], spin[k, 2]
        _draw(arrays, alpha1[k], speed[k], seed, index[k], hit[k], state, three)


@kernel
def simulate_spinning(
    arrays: Any,
    alpha1: FloatArray,
    speed: FloatArray,
    spin: FloatArray,
    seed: np.uint64,
    index: NDArray[Any],
    hit: NDArray[Any],
    work: FloatArray,
    state: FloatArray,
) -> None:
    """Simulate rebounds directly, with the particles' own grains."""
    for k in range(len(alpha1)):
        three = spin[k, 0], spin[k, 1], spin[k, 2]
        own = _grain(arrays, seed, index[k], 0)
        _simulate(arrays, alpha1[k], speed[k], three, own, seed, index[k], hit[k], work, state)
