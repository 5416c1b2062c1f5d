"""Records of the direct model: laws and particles, impacts, results, and rows that fail."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sampler.arguments import Call, row_index
from sampler.errors import NOT_FINITE
from sampler.row_codes import row_refusal
from tablegen.config.config import ModelSettings
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.model.float_array import FloatArray
from tablegen.model.impacts import (
    CONDITION_SIZE,
    OUT_OF_BOUNDS,
    TURNS_TOO_OFTEN,
    lab_conditions,
    wall_conditions,
)
from tablegen.model.model_bounds import ALPHA_DEG, MOST_TURNED, SPEED, SPIN
from tablegen.model.random_particles import OWN_GRAIN, draw_grains
from tablegen.simulation.failures import unfinished_error

#: An array of float64, or None where it is not given.
OptionalArray = Any

#: Hit whose random numbers make the grains that particles keep.
OWN = np.full(1, OWN_GRAIN)


class DirectArrays(NamedTuple):
    """Laws, particles and numerical parameters of a model, as kernels take them.

    ``law`` are `LawArguments`, ``population`` are `PopulationArguments`. ``numerics`` are the
    resolution of contacts, the tolerance of flights, and 0 because angular velocities are means
    over free tumbling.
    """

    law: Any
    population: Any
    numerics: tuple[float, float, float]

    @classmethod
    def from_parts(
        cls,
        pair: MaterialPair,
        population: Population,
        numerics: ModelSettings,
    ) -> "DirectArrays":
        """Convert the parts of a configuration."""
        return cls(
            pair.kernel_arguments(population.only_spheres),
            population.kernel_arguments(),
            (numerics.contact_resolution, numerics.tolerance, 0.0),
        )


#: Velocity, normal, half-size and wall velocity of an impact whose wall axes are those of the lab.
_WALL = (
    np.array([[1.0, -1.0, 0.0]]),
    np.array([[0.0, 1.0, 0.0]]),
    np.ones(1),
    np.zeros((1, 3)),
)


#: Status code: an inertia that the grain cannot turn with.
INERTIA_NOT_ITS_OWN = -105


class Failure(Exception):  # noqa: N818  # becomes an error when its row has a name
    """A row that cannot be simulated, and its code: 0 if the particle never leaves the wall."""

    def __init__(self, row: int, code: int) -> None:
        super().__init__(row, code)
        self.row, self.code = row, code


def _writable_arrays(call: Call) -> dict[str, NDArray[Any]]:
    """Return the arguments of a call as writable arrays, for which the kernels are compiled."""
    return {
        name: array if array.flags.writeable else array.copy()
        for name, array in call.rows.arrays.items()
    }


class DirectImpacts(NamedTuple):
    """Impacts of n particles, as kernels take them; arrays have n rows, or one for all.

    They are given in the frame of the wall or in the lab frame. A field that is None is not given.
    """

    seed: np.uint64
    index: NDArray[np.uint64]  # type: ignore[assignment]  # hides tuple.index
    hit: NDArray[np.uint32]
    #: Hits whose random numbers draw the grains; empty if the grains are given.
    grain_hits: NDArray[np.uint32]
    #: (n, 3): shape code, b/a and c/b.
    grain: OptionalArray = None
    #: (n,): inertia about the spin over m a^2; 0 if it is not known.
    inertia: OptionalArray = None
    #: Frame of the wall: angle [rad], speed [m/s], and spin times a/V.
    alpha1: OptionalArray = None
    speed: OptionalArray = None
    spin: OptionalArray = None
    #: Lab frame, SI; the normal points into the gas and has any length but zero.
    velocity: OptionalArray = None
    normal: OptionalArray = None
    half_size: OptionalArray = None
    wall_velocity: OptionalArray = None
    omega: OptionalArray = None
    #: Standard deviations of the tilt of facets [rad], in the plane of incidence and across it.
    roughness: OptionalArray = None
    across: OptionalArray = None

    @classmethod
    def from_call(cls, call: Call) -> "DirectImpacts":
        """Take the arguments of a call."""
        arrays = _writable_arrays(call)
        grain_hits = OWN[:0] if "grain" in arrays else arrays["hit"] if call.rows.fresh else OWN
        return cls(np.uint64(call.rows.seed), grain_hits=grain_hits, **arrays)

    def select(self, rows: slice | NDArray[np.intp]) -> "DirectImpacts":
        """Select some of the particles."""
        arrays: dict[str, Any] = {
            name: array[rows]
            for name, array in self._asdict().items()
            if isinstance(array, np.ndarray) and len(array) > 1
        }
        return self._replace(**arrays)

    @property
    def frame(self) -> tuple[Any, ...]:
        """Velocity, normal, half-size and wall velocity, which define the wall axes."""
        if self.velocity is None:
            return _WALL
        return self.velocity, self.normal, self.half_size, self.wall_velocity

    @property
    def keys(self) -> tuple[np.uint64, NDArray[np.uint64], NDArray[np.uint32]]:
        """Keys of the random numbers."""
        return self.seed, self.index, self.hit

    def conditions(self, count: int, numerics: tuple[float, float, float]) -> FloatArray:
        """Compute the conditions of the impacts, (n, 10); raises `Failure` for a bad row."""
        values = np.empty((count, CONDITION_SIZE))
        if self.velocity is None:
            impacts = self.alpha1, self.speed, self.spin, self.inertia
            row, code = wall_conditions(*impacts, numerics, values)
        else:
            turning = self.omega, self.inertia
            row, code = lab_conditions(self.frame, *turning, self.keys, numerics, values)
        if row >= 0:
            raise Failure(row, code)
        return values

    def kind(self, count: int) -> FloatArray:
        """Return the given grains, (n, 3), or an array that a kernel fills with drawn ones."""
        kind = np.empty((count, 3))
        if self.grain is not None:
            kind[:] = self.grain
        return kind

    def grains(self, count: int, population: Any) -> FloatArray:
        """Return the grains, given or drawn, (n, 3)."""
        kind = self.kind(count)
        if self.grain is None:
            draw_grains(population, self.seed, self.index, self.grain_hits, kind)
        return kind


class DirectResults(NamedTuple):
    """Arrays to which the simulation writes the results of n impacts."""

    #: (n, 6): velocities over V and angular velocities times a/V for impacts in the frame of the
    #: wall; velocities [m/s] and angular velocities [rad/s] for impacts in the lab frame.
    states: FloatArray
    #: (n,): inertia about the spin over m a^2; 0 without spin.
    inertia: FloatArray
    #: (n, 2): energies that the normal and the tangential impulses took [J/kg], or None if they are
    #: not wanted.
    works: FloatArray | None = None

    @classmethod
    def empty(cls, count: int, works: FloatArray | None = None) -> "DirectResults":
        """Make arrays for some impacts."""
        return cls(np.empty((count, 6)), np.empty(count), works)

    def select(self, part: slice) -> "DirectResults":
        """Select some of the particles."""
        works = None if self.works is None else self.works[part]
        return DirectResults(self.states[part], self.inertia[part], works)


def error_of_failure(call: Call, row: int, code: int) -> Exception:
    """Make the error for a row and the code of a `Failure`."""
    arrays = call.rows.arrays
    if code == 0:
        return unfinished_error(f"the particle at index {row_index(row, call.shape)}")
    if code == OUT_OF_BOUNDS:
        unnamed = ("normal", "half_size", "index", "hit", "grain", "inertia")
        names = [name for name in arrays if name not in unnamed]
        given = "; ".join(
            f"{name} {_numbers_text(np.atleast_1d(call.at(name, row)))}" for name in names
        )
        allowed = f"an impact at {ALPHA_DEG.words} and {SPEED.words}, with a spin of {SPIN.words}"
        return call.refusal(row, names[0], given, allowed)
    if code == TURNS_TOO_OFTEN:
        name = "omega" if "omega" in arrays else "spin"
        allowed = f"at most {MOST_TURNED:g} rad, 2 |spin| / sin(alpha1), before the first contact"
        return call.refusal(row, name, _numbers_text(call.at(name, row)), allowed)
    if code == NOT_FINITE and not 0.0 <= call.at("inertia", row) < math.inf:
        given = f"{call.at('inertia', row):.9g}"
        return call.refusal(row, "inertia", given, "a finite number, 0 or more")
    if code == INERTIA_NOT_ITS_OWN:
        allowed = (
            "from the smallest to the largest moment of inertia of the grain, over m a^2, or 0 if "
            "it is not known"
        )
        return call.refusal(row, "inertia", f"{call.at('inertia', row):.9g}", allowed)
    return row_refusal(call, row, code)


def _numbers_text(values: FloatArray) -> str:
    """Write numbers one after another."""
    return ", ".join(f"{x:.9g}" for x in values)
