"""Draws and rebounds of single particles inside code that ``@numba.njit`` compiles.

The functions of this module call the compiled library. They work in functions with ``cache=True``,
``parallel=True`` and ``nogil=True``. The types of their arguments are checked when the calling
function is compiled.

>>> import numba
>>> import numpy as np
>>> import sampler.numba
>>> table = sampler.load("corundum-steel-compact")
>>> @numba.njit
... def thrown_back(handle, out):
...     v, up = (90.0, -90.0, 0.0), (0.0, 1.0, 0.0)
...     return sampler.numba.rebound(handle, v, up, 1e-5, index=1, hit=0, seed=7, out=out)
>>> thrown_back(table.handle, np.empty(7))
0
"""

import ctypes
from collections.abc import Callable
from inspect import Parameter, Signature
from typing import Any, NamedTuple, cast

import llvmlite.binding
import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic
from numpy.typing import NDArray

from sampler.errors import MISSING, InputError
from sampler.formats.records import NUMBER, RECORDS, REQUIRED, RESULT
from sampler.library import library

if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
    _PROBLEM = "is set, and sampler.numba works in compiled code only"
    raise InputError("NUMBA_DISABLE_JIT", problem=_PROBLEM, remedy="unset it, or use sampler.load")

Vector = tuple[float, float, float]
Maybe = Vector | None

_LONG, _REAL = ir.IntType(64), ir.DoubleType()
_POINTER = ir.PointerType()
_NULL = ir.Constant(_POINTER, None)

#: Default of arguments that must be given: their names come behind others in the order of C.
_REQUIRED: Any = None


class _Argument(NamedTuple):
    """What an argument may be: the types that fit, the same in words, and what C takes."""

    fits: Callable[[Any], bool]
    allowed: str
    number: Any
    by_address: bool = False

    def or_none(self) -> "_Argument":
        """Allow None, which is NULL in C."""
        fits = lambda kind: _is_one_of(types.NoneType)(kind) or self.fits(kind)  # noqa: E731
        return self._replace(fits=fits, allowed=f"{self.allowed}, or None")


def _is_one_of(*kinds: Any) -> Callable[[Any], bool]:
    return lambda kind: isinstance(kind, kinds)


def _is_vector(kind: Any) -> bool:
    return _is_one_of(types.BaseTuple)(kind) and len(kind) == 3 and all(map(_NUMBER.fits, kind))


def _is_output(kind: Any) -> bool:
    plain = isinstance(kind, types.Array) and kind.ndim == 1
    return plain and kind.mutable and kind.dtype == types.float64


_SEED = _Argument(_is_one_of(types.Integer), "an integer", types.uint64)
_HANDLE = _SEED._replace(allowed="table.handle")
_INDEX = _SEED._replace(by_address=True)
_HIT = _INDEX._replace(number=types.uint32)
_NUMBER = _Argument(_is_one_of(types.Integer, types.Float), "a number", types.float64)
_NUMBER_AT = _NUMBER._replace(by_address=True)
_FLAG = _Argument(_is_one_of(types.Boolean), "True or False", types.int32)
_VECTOR = _Argument(_is_vector, "a tuple of three numbers", types.float64, by_address=True)
_OPTIONAL = _VECTOR.or_none()
_OUTPUT = _Argument(_is_output, "a writable float64 array of one dimension", None)


def _c_argument(context: Any, builder: Any, value: Any, kind: Any, argument: _Argument) -> Any:
    """Turn an argument of numba code into one of C, an array into its number of items."""
    if isinstance(kind, types.NoneType):
        return _NULL
    if isinstance(kind, types.Array):
        return context.make_array(kind)(context, builder, value).nitems
    parts = [(value, kind)]
    if _is_one_of(types.BaseTuple)(kind):
        parts = [(builder.extract_value(value, k), part) for k, part in enumerate(kind)]
    numbers = [context.cast(builder, *part, argument.number) for part in parts]
    return _store_record(builder, numbers) if argument.by_address else numbers[0]


def _store_record(builder: Any, fields: list[Any]) -> Any:
    """Store a record on the stack, and return its address."""
    record = cgutils.pack_struct(builder, fields)
    return builder.bitcast(cgutils.alloca_once_value(builder, record), _POINTER)


def _record(builder: Any, name: str, values: dict[str, Any]) -> Any:
    """Store a record of the interface; what is not among the values is NULL or 0."""
    fields = []
    for field in RECORDS[name]:
        size = _LONG if field.kind == "size_t" else ir.IntType(32)
        kind = ir.ArrayType(size, field.width) if field.role == NUMBER else _POINTER
        fields.append(values.get(field.name, ir.Constant(kind, None)))
    return _store_record(builder, fields)


def _sample_arguments(builder: Any, given: dict[str, Any], results: list[Any]) -> list[Any]:
    """Make the arguments of ``rbt_sample`` with one row."""
    conditions = _record(builder, "conditions", given | {"inertia_after": results[10]})
    return [given["handle"], _LONG(1), conditions, given["seed"], results[0], _NULL]


def _rebound_arguments(builder: Any, given: dict[str, Any], results: list[Any]) -> list[Any]:
    """Make the arguments of ``rbt_rebound`` with one row, with works if `out` has nine numbers."""
    after = {"velocity": results[0], "omega": results[3], "inertia": results[6]}
    wants_works = builder.icmp_unsigned("==", given["out"], _LONG(9))
    after["works"] = builder.select(wants_works, results[7], _NULL)
    records = _record(builder, "impacts", given), _record(builder, "rebounds", after)
    return [given["handle"], _LONG(1), records[0], given["seed"], records[1]]


def _add_result(_: Any, given: dict[str, Any], results: list[Any]) -> list[Any]:
    """Put the address of the numbers that are written behind the given arguments."""
    return [*given.values(), *results[:1]]


def _library_function(
    symbol: str,
    arguments: dict[str, _Argument],
    count: int,
    returns: Any = types.int32,
    make_c_arguments: Callable[..., list[Any]] = _add_result,
) -> Callable[..., Any]:
    """Make a function for numba code that calls a function of the library.

    Parameters
    ----------
    symbol : str
        Name of the function of the library.
    arguments : dict of _Argument
        Arguments of the function for numba code, by name.
    count : int
        How many numbers the library writes.
    returns : numba type
        What the function of the library returns.
    make_c_arguments : callable
        Makes the arguments of the function of the library from a builder, the arguments that were
        given, and the addresses of the numbers that are written.

    Returns
    -------
    callable
        Returns a tuple: the result, unless that is void, and the `count` numbers, NaN where the
        library wrote none.
    """
    address = ctypes.cast(getattr(library(), symbol), ctypes.c_void_p).value
    llvmlite.binding.add_symbol(symbol, address)
    output = types.Tuple(((returns,) if returns != types.void else ()) + (types.float64,) * count)

    def check_types(typingctx: Any, *given: Any) -> Any:
        for (name, argument), kind in zip(arguments.items(), given, strict=True):
            if not argument.fits(kind):
                raise TypingError(str(InputError(name, kind, argument.allowed)))

        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            parts = zip(arguments.items(), args, sig.args, strict=True)
            given = {
                name: _c_argument(context, builder, value, kind, argument)
                for (name, argument), value, kind in parts
            }
            first = _store_record(builder, [_REAL(np.nan)] * count)
            written = [builder.gep(first, [_LONG(k)], source_etype=_REAL) for k in range(count)]
            values = make_c_arguments(builder, given, written)
            result = ir.VoidType() if returns == types.void else context.get_value_type(returns)
            kind = ir.FunctionType(result, [value.type for value in values])
            function = cgutils.get_or_insert_function(builder.module, kind, symbol)
            results = [builder.call(function, values)][: len(output) - count]
            return context.make_tuple(
                builder, output, results + [builder.load(number, typ=_REAL) for number in written]
            )

        return output(*given), emit

    # numba takes the number and the names of the arguments from the signature
    kind = Parameter.POSITIONAL_OR_KEYWORD
    parameters = [Parameter(name, kind) for name in ("typingctx", *arguments)]
    check_types.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    return cast(Any, intrinsic)(check_types)


def _row_arguments(record: str) -> dict[str, _Argument]:
    """Make the arguments of one row, in the order of a record; the results are `out`."""
    kinds = {"uint64_t": _INDEX, "uint32_t": _HIT, "int": _FLAG}
    arguments = {}
    for name, role, kind, width, _ in RECORDS[record]:
        number = _NUMBER_AT if width == 1 else _VECTOR if role == REQUIRED else _VECTOR.or_none()
        if role != RESULT:
            arguments[name] = kinds.get(kind, number)
    return {"handle": _HANDLE, **arguments, "seed": _SEED, "out": _OUTPUT}


_sample = _library_function(
    "rbt_sample", _row_arguments("conditions"), count=11, make_c_arguments=_sample_arguments
)
_rebound = _library_function(
    "rbt_rebound", _row_arguments("impacts"), count=9, make_c_arguments=_rebound_arguments
)
_columns = _library_function("rbt_variables", {"handle": _HANDLE, "columns": _OPTIONAL}, count=0)
_grains = _library_function(
    "rbt_grains",
    {"handle": _HANDLE, "n": _SEED, "seed": _SEED, "index": _INDEX, "hit": _HIT.or_none()},
    count=3,
)
_GAS = {
    "diameter": _NUMBER,
    "density": _NUMBER,
    "viscosity": _NUMBER,
    "gas_rotation": _OPTIONAL,
}
_torque = _library_function(
    "rbt_gas_torque", {"omega": _VECTOR} | _GAS, count=3, returns=types.void
)
_spin_after = _library_function(
    "rbt_spin_after",
    {"omega": _VECTOR, "time": _NUMBER, "moment": _NUMBER} | _GAS,
    count=3,
    returns=types.void,
)
_half_size = _library_function(
    "rbt_half_size",
    {"handle": _HANDLE, "diameter": _NUMBER, "grain": _VECTOR},
    count=0,
    returns=types.float64,
)
_mean_inertia = _library_function(
    "rbt_mean_inertia", {"handle": _HANDLE, "grain": _VECTOR}, count=0, returns=types.float64
)
_sphericity = _library_function(
    "rbt_sphericity", {"handle": _HANDLE, "grain": _VECTOR}, count=0, returns=types.float64
)
_moment_of_inertia = _library_function(
    "rbt_moment_of_inertia",
    {"handle": _HANDLE, "seed": _SEED, "index": _INDEX}
    | dict.fromkeys(("inertia", "mass", "half_size", "diameter"), _NUMBER),
    count=0,
    returns=types.float64,
)
_deposits = _library_function(
    "rbt_deposits",
    {
        "velocity": _VECTOR,
        "normal": _VECTOR,
        "critical_speed": _NUMBER,
        "wall_velocity": _OPTIONAL,
    },
    count=0,
)


@numba.njit(nogil=True)
def _check_keys(seed: int, index: int, hit: int) -> None:
    """Refuse keys that would wrap, and so be those of another particle: -1 would be 2**64 - 1."""
    if seed < 0 or index < 0:
        raise ValueError("seed or index: got a number below 0, allowed: 0 to 2**64 - 1")
    if hit < 0 or hit > 0xFFFFFFFF:
        raise ValueError("hit: got a number out of range, allowed: 0 to 2**32 - 1")


@numba.njit(nogil=True)
def sample(
    handle: int,
    alpha1: float,
    speed: float,
    spin: Maybe = None,
    inertia: float = 0.0,
    grain: Maybe = None,
    index: int = _REQUIRED,
    hit: int = _REQUIRED,
    inertia_after: NDArray[np.float64] | None = None,
    fresh: bool = False,
    seed: int = _REQUIRED,
    out: NDArray[np.float64] = _REQUIRED,
) -> int:
    """Draw the state of one particle after a rebound, in the frame of the wall.

    Parameters
    ----------
    handle : int
        ``table.handle`` of a loaded table. Keep the table as long as you use the handle.
    alpha1, speed, inertia : float
        As for `sampler.Table.sample`.
    spin : tuple of three float, optional
        As for `sampler.Table.sample`.
    grain : tuple of three float, optional
        Shape code, b/a and c/b of the particle. By default the particle has the grain that `grain`
        draws for its keys.
    index, hit, seed : int
        Keys, as for `sampler.Table.sample`. All three are required.
    inertia_after : float64 array, shape (1,), optional
        Array to which the inertia about the spin after the rebound is written.
    fresh : bool, optional
        Whether the particle has another grain at each hit.
    out : float64 array, shape (n_columns,)
        Array to which the state is written, in the order of ``table.columns``; NaN after an error.

    Returns
    -------
    int
        Code of the draw: 0, a sum of the flags of `sampler.errors`, or an error below 0.
        ``table.counts`` does not count draws in compiled code.

    Raises
    ------
    numba.TypingError
        If an argument has a wrong type or is missing. It is raised when the caller is compiled.
    ValueError
        If `out` does not have one number for each column of the table, or if a key is negative or
        too large: the seed and the index have 64 bits, and `hit` has 32. Nothing is written then.
    """
    result = _sample(handle, alpha1, speed, spin, inertia, grain, index, hit, fresh, seed, out)
    _check_keys(seed, index, hit)
    numbers = result[1:]
    if result[0] != MISSING and out.size != _columns(handle, None)[0]:
        raise ValueError("out: has a wrong length; give one number for each column of the table")
    for k in range(10):  # a number that the compiler knows
        if k < out.size:
            out[k] = numbers[k]
    if inertia_after is not None:
        inertia_after[0] = numbers[10]
    return result[0]


@numba.njit(nogil=True)
def rebound(
    handle: int,
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Maybe = None,
    omega: Maybe = None,
    inertia: float = 0.0,
    roughness: float = 0.0,
    grain: Maybe = None,
    index: int = _REQUIRED,
    hit: int = _REQUIRED,
    fresh: bool = False,
    isotropic: bool = False,
    seed: int = _REQUIRED,
    out: NDArray[np.float64] = _REQUIRED,
) -> int:
    """Rebound one particle from a wall, in the lab frame.

    Parameters
    ----------
    handle, inertia, grain, index, hit, seed
        As for `sample`.
    velocity, normal : tuple of three float
        As for `sampler.Table.rebound`.
    half_size, roughness : float
        As for `sampler.Table.rebound`.
    wall_velocity, omega : tuple of three float, optional
        As for `sampler.Table.rebound`.
    fresh : bool, optional
        Whether the particle has another grain at each hit. From a smooth wall, without `omega` and
        `grain`, the draw is from the law of first impacts. A table without a spin law allows
        nothing else.
    isotropic : bool, optional
        As for `sampler.Table.rebound`.
    out : float64 array, shape (7,) or (9,)
        Array to which the results are written: velocity [m/s], mean angular velocity [rad/s] and
        the inertia about it over m a^2. An array of 9 numbers also gets the energies that impulses
        along the normal and along the wall take [J for each kg of the particle]. After an error the
        results are NaN, but a particle that moves away from the wall keeps its values.

    Returns
    -------
    int
        Code of the rebound, as for `sample`. From a rough wall it has the flags of all bounces.

    Raises
    ------
    numba.TypingError, ValueError
        As for `sample`.
    """
    result = _rebound(
        handle,
        velocity,
        normal,
        half_size,
        wall_velocity,
        omega,
        inertia,
        roughness,
        grain,
        index,
        hit,
        fresh,
        isotropic,
        seed,
        out,
    )
    _check_keys(seed, index, hit)
    numbers = result[1:]
    if out.size not in (7, 9):
        raise ValueError("out: has a wrong length; give 7 numbers, or 9 to get the works, too")
    for k in range(9):
        if k < out.size:
            out[k] = numbers[k]
    return result[0]


@numba.njit(nogil=True)
def grain(handle: int, seed: int, index: int, hit: int | None = None) -> Vector:
    """Draw the grain of a particle.

    Parameters
    ----------
    handle, seed, index : int
        As for `sample`.
    hit : int, optional
        If it is given, the grain is the fresh one of this hit. By default it is the grain that the
        particle keeps from wall to wall.

    Returns
    -------
    tuple of three float
        Shape code of `sampler.formats.shape_codes`, b/a and c/b; NaN if the table has no spin law.
    """
    _check_keys(seed, index, 0 if hit is None else hit)
    return _grains(handle, 1, seed, index, hit)[1:]


@numba.njit(nogil=True)
def half_size(handle: int, diameter: float, grain: Vector) -> float:
    """Compute the largest half-size of a grain [m]: `sampler.half_size`. 0: not in the table."""
    return _half_size(handle, diameter, grain)[0]


@numba.njit(nogil=True)
def mean_inertia(handle: int, grain: Vector) -> float:
    """Compute the mean moment of inertia of a grain over m a^2; 0: not in the table."""
    return _mean_inertia(handle, grain)[0]


@numba.njit(nogil=True)
def sphericity(handle: int, grain: Vector) -> float:
    """Compute the sphericity of a grain; see `sampler.sphericity`. 0: not in the table."""
    return _sphericity(handle, grain)[0]


@numba.njit(nogil=True)
def moment_of_inertia(
    handle: int,
    seed: int,
    index: int,
    inertia: float,
    mass: float,
    half_size: float,
    diameter: float,
) -> float:
    """Compute the moment of inertia of a particle about its spin [kg m^2], for `spin_after`.

    Parameters
    ----------
    handle, seed, index : int
        As for `sample`.
    inertia : float
        Inertia k over m a^2, as a rebound gives it. If it is 0, not known, the mean moment of the
        particle's grain is taken; if the table does not have that, the moment of a sphere.
    mass : float
        Mass of the particle [kg].
    half_size, diameter : float
        Largest half-size a, and diameter of the sphere of equal volume [m].

    Returns
    -------
    float
        k m a^2.
    """
    _check_keys(seed, index, 0)
    return _moment_of_inertia(handle, seed, index, inertia, mass, half_size, diameter)[0]


@numba.njit(nogil=True)
def gas_torque(
    omega: Vector, diameter: float, density: float, viscosity: float, gas_rotation: Maybe = None
) -> Vector:
    """Compute the torque of the gas on one particle [N m]; see `sampler.gas_torque`."""
    return _torque(omega, diameter, density, viscosity, gas_rotation)


@numba.njit(nogil=True)
def spin_after(
    omega: Vector,
    time: float,
    moment: float,
    diameter: float,
    density: float,
    viscosity: float,
    gas_rotation: Maybe = None,
) -> Vector:
    """Compute the spin of one particle after a flight [rad/s]; see `sampler.spin_after`."""
    return _spin_after(omega, time, moment, diameter, density, viscosity, gas_rotation)


@numba.njit(nogil=True)
def deposits(
    velocity: Vector, normal: Vector, critical_speed: float, wall_velocity: Maybe = None
) -> bool:
    """Tell whether one particle stays on the wall that it meets; see `sampler.deposits`."""
    return _deposits(velocity, normal, critical_speed, wall_velocity)[0] != 0
