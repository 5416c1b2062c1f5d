"""The law of direct simulation, as the C engine of `sampler` takes it.

The engine (`sampler/c/src/direct.h`) draws grains and facets of rough walls and turns lab frames to
wall axes. For the states in wall axes it calls the law: a record of the population, of the range
that is simulated, and of a function, which is the kernel `simulate_rows`.
"""

import ctypes
import hashlib
from collections.abc import Callable
from ctypes import c_char_p, c_double, c_int32, c_uint64, c_void_p
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from sampler.formats.bounds import ANY_SPEED
from sampler.formats.channels import STATE, VARIABLES
from sampler.formats.shape_codes import FIRST_MESH, SHAPE_CODES
from sampler.library import OpenDirect, Rows, sample
from tablegen.config.config import Config, ModelSettings
from tablegen.config.grain_ranges import inertia_coefficients, ratio_range
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population, PopulationArguments
from tablegen.model.float_array import FloatArray
from tablegen.model.jit import c_function
from tablegen.model.model_bounds import ALPHA_DEG, ASPECT, MOST_TURNED, SPEED, SPIN
from tablegen.model.particle_run import pack_model, simulate_rows
from tablegen.model.shapes import ShapeArguments

#: ``RBT_DIRECT_VERSION`` of `sampler/c/src/public.h`.
VERSION = 1

_REALS, _INTEGERS = types.CPointer(types.float64), types.CPointer(types.int64)

#: Types of the arguments of `simulate_rows`.
SIGNATURE = types.void(
    *(_REALS, _INTEGERS, types.int64, *5 * [_REALS]),
    *(types.CPointer(types.uint64), types.CPointer(types.uint32), types.uint64),
    *(_REALS, types.CPointer(types.int32)),
)


class PopulationRecord(ctypes.Structure):
    """The grains of the particles: ``rbt_population`` of the C header."""

    _fields_ = (
        ("n_shapes", c_int32),
        ("aspect", c_double * 8),
        ("shape_codes", c_void_p),
        ("shape_shares", c_void_p),
        ("shape_ratios", c_void_p),
        ("ratio_range", c_void_p),
        ("shape_geometry", c_void_p),
        ("shape_inertia", c_void_p),
    )


class LawRecord(ctypes.Structure):
    """Direct simulation: ``rbt_direct_law`` of the C header."""

    _fields_ = (
        ("version", c_uint64),
        ("population", PopulationRecord),
        ("alpha1", c_double * 2),
        ("speed", c_double * 2),
        ("most_spin", c_double),
        ("most_turned", c_double),
        ("valid_speed", c_double * 2),
        ("pair", c_char_p),
        ("reals", c_void_p),
        ("integers", c_void_p),
        ("simulate", c_void_p),
    )


@cache
def compiled_simulation() -> Any:
    """Compile `simulate_rows` for this process, once."""
    return c_function(simulate_rows, SIGNATURE)


def _population_arrays(
    population: Population, arguments: PopulationArguments
) -> dict[str, NDArray[Any]]:
    """Make the arrays of a `PopulationRecord`.

    Ratios of a grain that the caller prescribes may be any that the model simulates; spheres and
    meshes have their own.
    """
    codes, geometry = population.shape_codes, population.shape_geometry()
    ranges = np.array([ratio_range(population, code) for code in codes])
    fixed = np.array([code == SHAPE_CODES["sphere"] or code >= FIRST_MESH for code in codes])
    return {
        "shape_codes": np.array(codes, dtype=np.int32),
        "shape_shares": arguments.cumulative_weights,
        "shape_ratios": np.where(fixed[:, None], ranges[..., 0], 0.0),
        "ratio_range": np.where(fixed[:, None, None], ranges, (ASPECT.low, ASPECT.high)),
        "shape_geometry": np.array([geometry[code] for code in codes]),
        "shape_inertia": np.array([inertia_coefficients(population, code) for code in codes]),
    }


class DirectParts(NamedTuple):
    """What the record of a law consists of: its numbers, and its arrays by the name of the field.

    The fields of the population are named ``population.`` and their name.
    """

    pair: str
    numbers: dict[str, Any]
    arrays: dict[str, NDArray[Any]]

    @classmethod
    def from_parts(
        cls,
        pair: MaterialPair,
        population: Population,
        numerics: ModelSettings,
        name: str = "",
        instant: bool = False,
    ) -> "DirectParts":
        """Convert laws, particles and numerical parameters.

        ``name`` is that of the pair. ``instant`` tells whether angular velocities after the impact
        are those of the departure.
        """
        arguments = population.kernel_arguments()
        shapes = ShapeArguments(arguments.shape_codes, arguments.truncation, arguments.meshes)
        law = pair.kernel_arguments(population.only_spheres)
        parameters = numerics.contact_resolution, numerics.tolerance, float(instant)
        reals, integers = pack_model(law, shapes, parameters)
        grains = _population_arrays(population, arguments)
        numbers = {
            "version": VERSION,
            "population.n_shapes": len(arguments.shape_codes),
            "population.aspect": arguments.aspect.ravel().tolist(),
            "alpha1": np.radians([ALPHA_DEG.low, ALPHA_DEG.high]).tolist(),
            "speed": [SPEED.low, SPEED.high],
            "most_spin": SPIN.high,
            "most_turned": MOST_TURNED,
            "valid_speed": list(pair.restitution.valid_speed or (0.0, ANY_SPEED[1])),
        }
        arrays = {f"population.{name}": array for name, array in grains.items()}
        return cls(name, numbers, arrays | {"reals": reals, "integers": integers})

    @classmethod
    def from_config(cls, config: Config, population: Population | None = None) -> "DirectParts":
        """Convert a configuration, with its own particles or others."""
        particles = population or config.population
        return cls.from_parts(config.pair, particles, config.model, config.pair_name)

    def digest(self) -> str:
        """Compute a checksum of all numbers, hexadecimal."""
        digest = hashlib.sha256(repr((self.pair, self.numbers)).encode())
        for name, array in self.arrays.items():
            digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()


def _fill_record(record: ctypes.Structure, values: dict[str, Any]) -> None:
    """Set fields of a record, and of the record in it, by their names."""
    for name, value in values.items():
        outer, _, inner = name.rpartition(".")
        owner = getattr(record, outer) if outer else record
        if isinstance(value, list):
            getattr(owner, inner)[:] = value
        else:
            setattr(owner, inner, value)


class DirectLaw(OpenDirect):
    """The law of direct simulation, opened as a table of the C engine.

    Parameters
    ----------
    parts : DirectParts
    columns : tuple of str
        Variables of the states.
    """

    def __init__(self, parts: DirectParts, columns: tuple[str, ...] = STATE) -> None:
        self.parts, self.columns = parts, columns
        self._arrays = {name: np.ascontiguousarray(array) for name, array in parts.arrays.items()}
        self._record = LawRecord(pair=parts.pair.encode())
        _fill_record(self._record, parts.numbers)
        _fill_record(self._record, {name: a.ctypes.data for name, a in self._arrays.items()})
        self._record.simulate = compiled_simulation().address
        places = [VARIABLES.index(name) for name in columns]
        super().__init__(ctypes.addressof(self._record), places)

    @classmethod
    def from_config(cls, config: Config) -> "DirectLaw":
        """Open the law of a configuration."""
        return cls(DirectParts.from_config(config))

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return DirectLaw, (self.parts, self.columns)

    @property
    def nbytes(self) -> int:
        """Memory of laws, particles and parameters [bytes]."""
        return sum(array.nbytes for array in self._arrays.values())


class Simulated(NamedTuple):
    """Results of n impacts, in the axes of the wall."""

    #: (n, 10): the variables of `sampler.formats.channels.VARIABLES`; the energy of rotation is
    #: over the kinetic energy before, works are over m V^2 / 2.
    variables: FloatArray
    #: (n,): inertia about the spin over m a^2; 0 without spin.
    inertia: FloatArray
    #: (n,): kinetic energy before the impact over m V^2 / 2.
    energy_before: FloatArray
    #: (n,): codes of the rows; a rebound that did not end has a negative one, and NaN.
    codes: NDArray[np.intc]


def simulate_impacts(law: DirectLaw, rows: Rows, threads: int | None = None) -> Simulated:
    """Simulate impacts in the axes of the wall.

    ``rows.arrays`` are ``alpha1``, ``speed``, ``index`` and ``hit``, and ``spin``, ``inertia`` and
    ``grain`` if they are given. Without ``spin`` and ``grain`` the grains are fresh.
    """
    values = np.empty((rows.n, len(VARIABLES) + 2))
    report = sample(law, rows, values, threads, all_values=True)
    codes = np.zeros(rows.n, np.intc) if report.codes is None else report.codes
    return Simulated(values[:, :-2], values[:, -2], values[:, -1], codes)
