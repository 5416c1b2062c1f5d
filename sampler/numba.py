"""Draws and rebounds of single particles inside ``@numba.njit`` code, by the compiled library.

The functions here are compiled into their caller, with ``cache=True``, ``parallel=True`` and
``nogil=True`` as well. Their arguments are checked while the caller compiles.

>>> import numba
>>> import numpy as np
>>> import sampler
>>> table = sampler.load("corundum-steel-compact")
>>> @numba.njit
... def speed_after(handle, n):
...     v, up, out, total = (90.0, -90.0, 0.0), (0.0, 1.0, 0.0), np.empty(6), 0.0
...     for k in range(n):
...         sampler.rebound(handle, v, up, 1e-5, None, None, 7, k, 0, out)
...         total += np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
...     return total / n
>>> bool(50.0 < speed_after(table.handle, 1000) < 127.0)
True
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

from sampler.library import library

Vector = tuple[float, float, float]

_LONG, _WORD, _REAL = ir.IntType(64), ir.IntType(32), ir.DoubleType()
_POINTER = _REAL.as_pointer()


def _is_real(kind: Any) -> bool:
    return isinstance(kind, types.Float | types.Integer)


def _is_vector(kind: Any) -> bool:
    plain = isinstance(kind, types.BaseTuple) and len(kind) == 3
    return plain and all(_is_real(part) for part in kind)


def _is_missing(kind: Any) -> bool:
    omitted = isinstance(kind, types.Omitted) and kind.value is None
    return omitted or isinstance(kind, types.NoneType)


def _is_output(kind: Any) -> bool:
    plain = isinstance(kind, types.Array) and kind.ndim == 1
    return plain and kind.mutable and kind.dtype == types.float64


#: Numba's, whose caller leaves the typing context out.
_intrinsic = cast(Callable[[Any], Callable[..., Any]], intrinsic)


class _Kind(NamedTuple):
    """Kind of an argument: the types that fit, the allowed ones in words, and the type in C."""

    fits: Callable[[Any], bool]
    allowed: str
    in_c: Any


_HANDLE = _Kind(lambda kind: isinstance(kind, types.Integer), "table.handle", _LONG)
_NUMBER = _Kind(_is_real, "a number", _REAL)
_KEY = _Kind(lambda kind: isinstance(kind, types.Integer), "an integer", _LONG)
_HIT = _KEY._replace(in_c=_WORD)
_VECTOR = _Kind(_is_vector, "a tuple of three numbers", _POINTER)
_OPTIONAL = _Kind(
    lambda kind: _is_missing(kind) or _is_vector(kind),
    "a tuple of three numbers, or None",
    _POINTER,
)
_NONE = _Kind(_is_missing, "None", _POINTER)
_OUTPUT = _Kind(_is_output, "a writable float64 array of one dimension", _POINTER)

#: Functions of the library that compiled code calls. A cached caller looks for them by name.
_GAS = ("rbt_gas_torque", "rbt_spin_after")
_SYMBOLS = ("rbt_draw_all", "rbt_rebound_grain", "rbt_fresh_grain", *_GAS)
for _symbol in _SYMBOLS:
    _address = ctypes.cast(getattr(library(), _symbol), ctypes.c_void_p).value
    llvmlite.binding.add_symbol(_symbol, _address)


def _in_c(context: Any, builder: Any, value: Any, kind: Any, what: _Kind) -> Any:
    """Turn an argument of numba code into one of C."""
    if what.in_c is not _POINTER:
        number = {_REAL: types.float64, _LONG: types.uint64, _WORD: types.uint32}[what.in_c]
        return context.cast(builder, value, kind, number)
    if _is_missing(kind):
        return ir.Constant(_POINTER, None)
    place = cgutils.alloca_once(builder, ir.ArrayType(_REAL, 3))
    for k, part in enumerate(cgutils.unpack_tuple(builder, value, 3)):
        number = context.cast(builder, part, kind[k], types.float64)
        builder.store(number, builder.gep(place, [_WORD(0), _WORD(k)]))
    return builder.bitcast(place, _POINTER)


def _call(symbol: str, arguments: dict[str, _Kind], given: tuple[Any, ...], *at: int) -> Any:
    """Type a call of a function of the library and write its code.

    The call returns its status and the numbers that the function writes. The last argument, the
    array for them or None, is only looked at: the caller copies them, whatever its stride.

    Parameters
    ----------
    symbol : str
    arguments : dict
        Name and kind of each.
    given : tuple
        Types in numba.
    *at : int
        Where the outputs of the function begin among the numbers, and how many there are in all.
    """
    for (name, what), kind in zip(arguments.items(), given, strict=True):
        if not what.fits(kind):
            raise TypingError(f"{name}: got {kind}, allowed: {what.allowed}")
    *begins, count = at
    found = types.Tuple((types.int32, types.UniTuple(types.float64, count)))

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kinds = list(arguments.values())
        parts = zip(args[:-1], sig.args[:-1], kinds[:-1], strict=True)
        values = [_in_c(context, builder, *part) for part in parts]
        room = cgutils.alloca_once(builder, ir.ArrayType(_REAL, count))
        places = [builder.gep(room, [_WORD(0), _WORD(k)]) for k in range(count)]
        values += [places[k] for k in begins]
        result = ir.VoidType() if symbol in _GAS else _WORD
        kind = ir.FunctionType(result, [value.type for value in values])
        function = cgutils.get_or_insert_function(builder.module, kind, symbol)
        status = builder.call(function, values)
        status = _WORD(0) if symbol in _GAS else status
        numbers = context.make_tuple(builder, found[1], [builder.load(place) for place in places])
        return context.make_tuple(builder, found, [status, numbers])

    return found(*given), emit


def _function(symbol: str, arguments: dict[str, _Kind], *at: int) -> Callable[..., Any]:
    """Make a function of numba code of one of the library; arguments are those of `_call`."""

    def typed(typingctx: Any, *given: Any) -> Any:
        return _call(symbol, arguments, given, *at)

    # numba takes the number and the names of the arguments from the signature
    kind = Parameter.POSITIONAL_OR_KEYWORD
    parameters = [Parameter(name, kind) for name in ("typingctx", *arguments)]
    typed.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    return _intrinsic(typed)


_KEYS = {"seed": _KEY, "index": _KEY, "hit": _HIT}
_draw = _function(
    "rbt_draw_all",
    {"handle": _HANDLE, "alpha1": _NUMBER, "speed": _NUMBER, "spin": _OPTIONAL}
    | {"grain": _OPTIONAL, **_KEYS, "state": _OUTPUT},
    *(0, 10),
)
_rebound = _function(
    "rbt_rebound_grain",
    {"handle": _HANDLE, "velocity": _VECTOR, "normal": _VECTOR, "half_size": _NUMBER}
    | {"wall_velocity": _OPTIONAL, "roughness": _NUMBER, "isotropic": _HIT, "omega": _OPTIONAL}
    | {"grain": _OPTIONAL, **_KEYS, "out": _OUTPUT},
    *(0, 3, 6),
)
_grain = _function("rbt_fresh_grain", {"handle": _HANDLE, **_KEYS, "out": _NONE}, 0, 3)
_GASEOUS = {"diameter": _NUMBER, "density": _NUMBER, "viscosity": _NUMBER, "gas_rotation": _VECTOR}
_torque = _function("rbt_gas_torque", {"omega": _VECTOR, **_GASEOUS, "out": _NONE}, 0, 3)
_after = _function(
    "rbt_spin_after",
    {"omega": _VECTOR, "time": _NUMBER, "inertia": _NUMBER, **_GASEOUS, "out": _NONE},
    *(0, 3),
)


def _check_of(name: str) -> Callable[[Any], None]:
    """Make a function of numba code that compiles only for an array to write to."""

    @_intrinsic
    def check(typingctx: Any, given: Any) -> Any:
        if not _OUTPUT.fits(given):
            raise TypingError(f"{name}: got {given}, allowed: {_OUTPUT.allowed}")
        return types.void(given), lambda context, builder, sig, args: context.get_dummy_value()

    return check


_check_state, _check_out = _check_of("state"), _check_of("out")


@numba.njit(nogil=True)
def draw(
    handle: int,
    alpha1: float,
    speed: float,
    spin: Vector | None,
    seed: int,
    index: int,
    hit: int,
    state: NDArray[np.float64],
    grain: Vector | None = None,
) -> int:
    """Draw one rebound state.

    A pure function of its arguments: equal ones give an equal state on any thread, in any order.

    Parameters
    ----------
    handle : int
        ``table.handle`` of a loaded table, which must live as long.
    alpha1 : float
        Impact angle in rad from the wall, in (0, pi/2].
    speed : float
        Impact speed V in m/s, > 0.
    spin : tuple of three float, or None
        Angular velocity before the impact times a/V, wall frame: then the rebound is drawn from the
        spin law, also where the spin is zero. None: from the law of first impacts, of any grain.
    seed, index : int
        Seed of the run and identity of the particle, read as uint64.
    hit : int
        How many walls the particle has met before, read as uint32.
    state : float64 array, shape (6,), written
        u, v, w over V and omega_x, omega_y, omega_z times a/V in the wall frame: x along the
        tangential velocity before impact, y into the gas. Variables that the table leaves out
        are 0. An array of shape (10,) also gets the rotational energy over the initial kinetic
        energy, the number of collisions, and the work of the normal and of the tangential impulses
        over m V^2 / 2; the first two only without a spin.
    grain : tuple of three float, optional
        Shape code, b/a and c/b, from the spin law too; for example a fresh one at each hit, from
        `sampler.grain`. None: with a spin, the particle's own, which it keeps from hit to hit.

    Returns
    -------
    int
        A sum of flags: `CLAMPED` (1), angle, speed or spin outside the table, and `EXTRAPOLATED`
        (2), a speed at which the pair was not measured. Else one of the negative codes of
        `sampler.errors`, with nothing written. So an error is ``status < 0``.

    Raises
    ------
    numba.TypingError
        While the caller compiles, if an argument has a wrong type.
    ValueError
        If `state` has fewer than six numbers.
    """
    _check_state(state)
    if state.size < 6:
        raise ValueError("state: got fewer than 6 numbers, allowed: shape (6,) or (10,)")
    status, values = _draw(handle, alpha1, speed, spin, grain, seed, index, hit, state)
    if status >= 0:
        for k in range(min(state.size, 10)):
            state[k] = values[k]
    return status


@numba.njit(nogil=True)
def rebound(
    handle: int,
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Vector | None,
    omega: Vector | None,
    seed: int,
    index: int,
    hit: int,
    out: NDArray[np.float64],
    grain: Vector | None = None,
) -> int:
    """Rebound one particle, in the lab frame.

    Parameters
    ----------
    handle, seed, index, hit, grain
        As for `draw`.
    velocity : tuple of three float
        Velocity of the particle at the contact, m/s.
    normal : tuple of three float
        From the wall into the gas, any length but zero.
    half_size : float
        Largest half-size a of the particle, 1e-30 m or more.
    wall_velocity : tuple of three float, or None
        Velocity of the wall at the contact, m/s; None: at rest.
    omega : tuple of three float, or None
        Angular velocity before the impact, rad/s. None: not spinning, the same as zeros; of a table
        without a spin law, from the law of first impacts.
    out : float64 array, shape (6,), written
        Velocity in m/s, then angular velocity in rad/s.

    Returns
    -------
    int
        As `draw`.

    Raises
    ------
    numba.TypingError, ValueError
        As `draw`, of `out`.
    """
    return rough_rebound(
        handle, velocity, normal, half_size, wall_velocity, 0.0, omega, seed, index, hit, out, grain
    )


@numba.njit(nogil=True)
def rough_rebound(
    handle: int,
    velocity: Vector,
    normal: Vector,
    half_size: float,
    wall_velocity: Vector | None,
    roughness: float,
    omega: Vector | None,
    seed: int,
    index: int,
    hit: int,
    out: NDArray[np.float64],
    grain: Vector | None = None,
    isotropic: bool = False,
) -> int:
    """Rebound one particle from a rough wall, in the lab frame.

    Parameters
    ----------
    handle, velocity, normal, half_size, wall_velocity, omega, seed, index, hit, out, grain
        As for `rebound`; the normal is that of the mean wall.
    roughness : float
        Standard deviation of the tilt of facets, rad, 0 to 0.5.
    isotropic : bool
        Whether facets are tilted across the plane of incidence as well, and not only in it.

    Returns
    -------
    int
        As `draw`, with the flags of any bounce of this hit.

    Raises
    ------
    numba.TypingError, ValueError
        As `draw`, of `out`.
    """
    _check_out(out)
    if out.size < 6:
        raise ValueError("out: got fewer than 6 numbers, allowed: shape (6,)")
    status, values = _rebound(
        handle,
        velocity,
        normal,
        half_size,
        wall_velocity,
        roughness,
        1 if isotropic else 0,
        omega,
        grain,
        seed,
        index,
        hit,
        out,
    )
    if status >= 0:
        for k in range(6):
            out[k] = values[k]
    return status


@numba.njit(nogil=True)
def grain(handle: int, seed: int, index: int, hit: int) -> Vector:
    """Draw the grain of a particle at a hit.

    Parameters
    ----------
    handle, seed, index, hit
        As for `draw`. With hit 0 it is the grain that the particle keeps.

    Returns
    -------
    tuple of three float
        Shape code of `sampler.formats.shape_codes`, b/a and c/b; zeros without a spin law.
    """
    status, found = _grain(handle, seed, index, hit, None)
    return found if status >= 0 else (0.0, 0.0, 0.0)


@numba.njit(nogil=True)
def gas_torque(
    omega: Vector,
    diameter: float,
    density: float,
    viscosity: float,
    gas_rotation: Vector = (0.0, 0.0, 0.0),
) -> Vector:
    """Compute the torque of the gas on one particle, N m: `sampler.gas_torque` of tuples."""
    return _torque(omega, diameter, density, viscosity, gas_rotation, None)[1]


@numba.njit(nogil=True)
def spin_after(
    omega: Vector,
    time: float,
    inertia: float,
    diameter: float,
    density: float,
    viscosity: float,
    gas_rotation: Vector = (0.0, 0.0, 0.0),
) -> Vector:
    """Compute the angular velocity of one particle, rad/s: `sampler.spin_after` of tuples."""
    return _after(omega, time, inertia, diameter, density, viscosity, gas_rotation, None)[1]


@numba.njit(nogil=True)
def deposits(
    velocity: Vector, normal: Vector, critical_speed: float, wall_velocity: Vector = (0.0, 0.0, 0.0)
) -> bool:
    """Tell whether one particle stays on the wall that it meets: `sampler.deposits` of tuples."""
    approach, square = 0.0, 0.0
    for k in range(3):
        approach -= (velocity[k] - wall_velocity[k]) * normal[k]
        square += normal[k] * normal[k]
    return 0.0 < approach < critical_speed * np.sqrt(square)
