"""Rows of a call of the direct model: particles with their grains, and rows that fail."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import Call, place
from sampler.errors import InputError
from sampler.messages import row_message
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import OUT_OF_BOUNDS, TURNS_TOO_OFTEN
from tablegen.model.model_bounds import ALPHA_DEG, MOST_TURNED, SPEED, SPIN
from tablegen.model.orientation import ORIENTATION_NOT_USABLE
from tablegen.model.random_particles import OWN_GRAIN, ParticleKeys, draw_grains
from tablegen.simulation.batches import unfinished

#: Hit whose random numbers make the grains that particles keep.
OWN = np.full(1, OWN_GRAIN)


class DirectArrays(NamedTuple):
    """Laws, particles and numerical parameters of a model, as kernels take them.

    ``law``: `LawArguments`. ``population``: `PopulationArguments`. ``numerics``: resolution of
    contacts, tolerance of flights, and 0 where angular velocities are means over free tumbling, 1
    where they are those of an instant.
    """

    law: Any
    population: Any
    numerics: tuple[float, float, float]


class Failure(NamedTuple):
    """A row that cannot be simulated, and its code: 0 if the particle never leaves the wall."""

    row: int
    code: int


class Particles(NamedTuple):
    """Arguments of a call, with the hits whose random numbers make the grains, or given grains."""

    call: Call
    made_at: NDArray[np.uint32]
    given: FloatArray | None

    def array(self, name: str) -> NDArray[Any]:
        """Give the rows of an argument, writable: kernels are compiled for no other arrays."""
        array = self.call.rows.arrays[name]
        return array if array.flags.writeable else array.copy()

    @property
    def seed(self) -> np.uint64:
        """Seed of the call."""
        return np.uint64(self.call.rows.seed)

    @property
    def lab_keys(self) -> tuple[np.uint64, NDArray[np.uint64], NDArray[np.uint32]]:
        """Keys of all rows."""
        return self.seed, self.array("index"), self.array("hit")

    def keys(self, part: slice) -> ParticleKeys:
        """Return the keys of some rows."""
        made_at = rows_of(self.made_at, part) if self.given is None else self.made_at[:0]
        index, hit = rows_of(self.array("index"), part), rows_of(self.array("hit"), part)
        return ParticleKeys(self.seed, index, hit, made_at, "orientation" in self.call.rows.arrays)

    def kind(self, part: slice) -> FloatArray:
        """Return the given grains of some rows, or an array that a kernel fills with drawn ones."""
        kind = np.empty((part.stop - part.start, 3))
        if self.given is not None:
            kind[:] = rows_of(self.given, part)
        return kind

    def grains(self, arrays: DirectArrays, part: slice) -> FloatArray:
        """Return the grains of some rows, given or drawn, (m, 3)."""
        kind = self.kind(part)
        if self.given is None:
            index, made_at = rows_of(self.array("index"), part), rows_of(self.made_at, part)
            draw_grains(arrays.population, self.seed, index, made_at, kind)
        return kind


def rows_of(array: NDArray[Any], part: slice) -> NDArray[Any]:
    """Select rows of an array that has one for each particle, or one for all."""
    return array[part] if len(array) > 1 else array


def failure_of(call: Call, failure: Failure) -> Exception:
    """Make the error for a row."""
    row, code = failure
    at = place(row, call.shape)
    arrays = call.rows.arrays
    if code == 0:
        return unfinished(f"the particle at {at}")
    if code == OUT_OF_BOUNDS:
        unnamed = ("normal", "half_size", "index", "hit", "grain", "orientation")
        names = [name for name in arrays if name not in unnamed]
        got = "; ".join(f"{name} {_numbers(np.atleast_1d(call.at(name, row)))}" for name in names)
        return InputError(
            f"{names[0]}: got {got} at {at}, allowed: an impact at {ALPHA_DEG.words} and "
            f"{SPEED.words}, with a spin of {SPIN.words}"
        )
    if code == TURNS_TOO_OFTEN and "time" in arrays:
        return InputError(
            f"time: got {call.at('time', row):.9g} with omega {_numbers(call.at('omega', row))} at "
            f"{at}, allowed: 0 or more, and |omega| time at most {MOST_TURNED:g} rad"
        )
    if code == TURNS_TOO_OFTEN:
        name = "omega" if "omega" in arrays else "spin"
        return InputError(
            f"{name}: got {_numbers(call.at(name, row))} at {at}, allowed: at most "
            f"{MOST_TURNED:g} rad, 2 |spin| / sin(alpha1), before the first contact"
        )
    if code == ORIENTATION_NOT_USABLE:
        return InputError(
            f"orientation: got {_numbers(call.at('orientation', row))} at {at}, allowed: a "
            "quaternion of four finite numbers, not all 0"
        )
    return InputError(row_message(call, row, code))


def _numbers(values: FloatArray) -> str:
    return ", ".join(f"{x:.9g}" for x in values)
