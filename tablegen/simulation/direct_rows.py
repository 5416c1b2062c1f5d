"""Rows of a call of the direct model: particles and their grains, work in batches, failures."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import Rows, as_integer, place
from sampler.errors import InputError
from sampler.library import processors
from sampler.messages import row_message
from tablegen.config.population import PopulationArguments
from tablegen.model.impacts import OUT_OF_BOUNDS, TURNS_TOO_OFTEN
from tablegen.model.model_bounds import ALPHA_DEG, MOST_TURNED, SPEED, SPIN
from tablegen.model.random_particles import OWN_GRAIN, ParticleKeys, draw_grains
from tablegen.simulation.batches import BATCH, batches, unfinished
from tablegen.tasks.side_by_side import side_by_side

#: Hits of a call whose particles have grains of their own.
OWN = np.full(1, OWN_GRAIN)


class Failure(NamedTuple):
    """A row that could not be worked out, and its code: 0 if it never left the wall."""

    row: int
    code: int


class Particles(NamedTuple):
    """Rows of a call, the hits whose random numbers make the grains, and those that are given."""

    rows: Rows
    made_at: NDArray[np.uint32]
    given: NDArray[np.float64] | None

    def keys(self, part: slice) -> ParticleKeys:
        """Keys of some rows."""
        seed, index, hit = self.rows.keys
        made_at = of(self.made_at, part) if self.given is None else self.made_at[:0]
        return ParticleKeys(seed, of(index, part), of(hit, part), made_at)

    def kind(self, part: slice) -> NDArray[np.float64]:
        """Array of the grains of some rows, to be written where they are drawn."""
        kind = np.empty((part.stop - part.start, 3))
        if self.given is not None:
            kind[:] = of(self.given, part)
        return kind

    def grains(self, population: PopulationArguments, part: slice) -> NDArray[np.float64]:
        """Grains of some rows, given or drawn, (m, 3)."""
        kind = self.kind(part)
        if self.given is None:
            seed, index, _ = self.rows.keys
            draw_grains(population, seed, of(index, part), of(self.made_at, part), kind)
        return kind


def of(array: NDArray[Any], part: slice) -> NDArray[Any]:
    """Rows of an array that has one for each particle, or one for all."""
    return array[part] if len(array) > 1 else array


def raise_failure(rows: Rows, failure: Failure) -> None:
    """Raise the error of a row."""
    row, code = failure
    at = place(row, rows.shape)
    if code == 0:
        raise unfinished(f"the particle at {at}")
    if code == OUT_OF_BOUNDS:
        raise InputError(_bounds_message(rows, row))
    if code != TURNS_TOO_OFTEN:
        raise InputError(row_message(rows, row, code))
    name = "omega" if "omega" in rows.values else "spin"
    got = ", ".join(f"{x:.9g}" for x in rows.at(name, row))
    raise InputError(
        f"{name}: got {got} at {at}, allowed: at most {MOST_TURNED:g} rad, 2 |spin| / sin(alpha1), "
        "before the first contact"
    )


def _bounds_message(rows: Rows, row: int) -> str:
    """Message on a row whose angle, speed or spin is outside of the bounds of the model."""
    names = [name for name in rows.values if name not in ("normal", "half_size")]
    got = "; ".join(
        f"{name} {', '.join(f'{x:.9g}' for x in np.atleast_1d(rows.at(name, row)))}"
        for name in names
    )
    return (
        f"{names[0]}: got {got} at {place(row, rows.shape)}, allowed: an impact at "
        f"{ALPHA_DEG.words} and {SPEED.words}, with a spin of {SPIN.words}"
    )


def work_all(work: Callable[[slice], Failure | None], rows: Rows, threads: int | None) -> None:
    """Work on the batches of all rows; raise the error of the first that fails."""
    if threads is not None:
        threads = as_integer("threads", threads, 1, 4096, "an integer from 1 to 4096")
    workers = max(min(threads or processors(), -(-rows.n // BATCH)), 1)
    for failure in side_by_side(work, batches(rows.n), workers):
        if failure is not None:
            raise_failure(rows, failure)
