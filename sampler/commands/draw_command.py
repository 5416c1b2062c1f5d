"""Work of ``sampler draw``."""

import math
import sys
import warnings
from pathlib import Path

import numpy as np

from sampler.drawing.kernel import is_outside
from sampler.errors import InputError, OutsideTableWarning
from sampler.files.atomic import atomic_output
from sampler.table import Table, load


def _range_text(table: Table) -> str:
    low, high = np.rad2deg(table.alpha_range)
    return f"{low:g} to {high:g} deg, {table.speed_range[0]:g} to {table.speed_range[1]:g} m/s"


def run(
    table: str, alpha: float, speed: float, count: int, seed: int, output: Path, outside: str
) -> int:
    """Run ``sampler draw``; parameters are its options, ``alpha`` in degrees."""
    loaded = load(table, outside="clamp")
    alpha1 = math.radians(alpha)
    outside_alpha = is_outside(alpha1, loaded.arrays.alpha)
    if outside_alpha or is_outside(speed, loaded.arrays.speed):
        if outside == "raise":
            flag, value = ("alpha", alpha) if outside_alpha else ("speed", speed)
            raise InputError(f"argument --{flag}: got {value:g}, allowed: {_range_text(loaded)}")
        sys.stderr.write(
            f"sampler: note: {alpha:g} deg, {speed:g} m/s is outside the table "
            f"({_range_text(loaded)}), its nearest condition is used\n"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OutsideTableWarning)  # the note has said it
            state = loaded.sample(alpha1, speed, seed=seed, index=_indices(count))
    except MemoryError:
        raise InputError(
            f"argument --count: got {count}, allowed: as many states as fit into "
            "memory, 48 bytes each"
        ) from None
    with atomic_output(output) as temporary, open(temporary, "wb") as file:
        # An open file, because numpy would add a suffix to a name.
        np.savez(file, state=state, columns=loaded.columns)
    return 0


def _indices(count: int) -> np.ndarray:
    """Identities 0 to count - 1; numpy has two errors for a count that is too large."""
    try:
        return np.arange(count, dtype=np.uint64)
    except ValueError:
        raise MemoryError from None
