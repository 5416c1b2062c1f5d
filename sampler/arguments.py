"""Arguments of draws and rebounds: coerced to rows of arrays, or refused in one line.

Arguments broadcast as in numpy, but arrays of several rows have the same number of dimensions. A
single number stands for every row and is not copied; an array of the full shape is passed on as it
is where its type and layout allow.
"""

import math
import operator
import sys
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.errors import InputError, value_text
from sampler.formats.bounds import SINGLE_ROUNDING
from sampler.library import Rows
from sampler.limits import Bounds

Shape = tuple[int, ...]

#: Largest roughness, rad: beyond it a normal law of tilts describes no surface.
MAX_ROUGHNESS = 0.5

#: "own": a particle has the same grain at every hit, drawn by (seed, index). "fresh": another one
#: at every hit, drawn by (seed, index, hit). An array (..., 3): shape code, b/a, c/b.
Grain = Literal["own", "fresh"] | ArrayLike

#: Numbers on the last axis of some arguments: the components of a vector, a grain, a `Geometry`.
VECTORS = {
    "velocity": 3,
    "normal": 3,
    "wall_velocity": 3,
    "spin": 3,
    "omega": 3,
    "grain": 3,
    "gas_rotation": 3,
    "geometry": 4,
}

#: What to do where the random numbers of a draw are not chosen.
_GIVE_KEYS = "give seed=, index= and hit=, or rng= and size= in place of these"


class Rebound(NamedTuple):
    """Velocity and rotation of particles after a rebound, from `Table.rebound`.

    Keep ``omega`` and ``inertia`` with each particle, and pass them to its next rebound.

    Attributes
    ----------
    velocity : float64 array, shape (..., 3)
        Velocity after the rebound [m/s], in the lab frame.
    omega : float64 array, shape (..., 3)
        Mean angular velocity of the tumbling particle after the rebound [rad/s], in the lab frame.
    inertia : float64 array, shape (...)
        Inertia k about ``omega`` over m a^2: the rotational energy is ``k m a^2 |omega|^2 / 2``.
        Neither omega nor k changes in free flight. The law of first impacts gives 0, not known.
    """

    velocity: NDArray[np.float64]
    omega: NDArray[np.float64]
    inertia: NDArray[np.float64]


def text_beside(value: float, *limits: float, digits: int = 9) -> str:
    """Write a refused value with enough digits that it differs from the limits beside it."""
    others = [limit for limit in limits if limit != value]
    for count in range(digits, 18):
        text = f"{value:.{count}g}"
        if text not in (f"{limit:.{count}g}" for limit in others):
            break
    return text


def row_index(row: int, shape: Shape) -> int | tuple[int, ...]:
    """Return the index of a row, counted from 0, into arrays of a shape."""
    if len(shape) < 2:
        return row
    return tuple(int(k) for k in np.unravel_index(row, shape))


# -- numbers ---------------------------------------------------------------------------------------


def is_masked(values: Any) -> bool:
    """Tell whether values are a masked array, without the time of importing `numpy.ma`."""
    return "numpy.ma" in sys.modules and isinstance(values, np.ma.MaskedArray)


def unit_of(values: Any) -> Any:
    """Find the unit that values carry, as those of astropy, pint and xarray do; None if none."""
    if isinstance(values, list | tuple):
        units = (unit_of(value) for value in values if type(value) is not float)
        return next((unit for unit in units if unit is not None), None)
    if type(values) in (float, int, np.ndarray, np.float64):  # of most calls
        return None
    return getattr(values, "unit", getattr(values, "units", None))


def check_kind(name: str, array: Any, kinds: str, allowed: str) -> None:
    """Refuse an array of another kind of numbers; an empty one has no kind yet."""
    if array.size and array.dtype.kind not in kinds:
        raise InputError(name, f"{array.dtype.name} values", allowed)


def _numeric(name: str, values: ArrayLike, kinds: str, allowed: str) -> NDArray[Any]:
    """Make an array of one of the dtype kinds."""
    if is_masked(values):  # numpy would hand on the numbers under the mask
        raise InputError(name, "a masked array", f"{allowed} without a mask")
    if (unit := unit_of(values)) is not None:  # which numpy would drop
        problem = f"carries the unit {value_text(str(unit))}"
        raise InputError(
            name, problem=problem, remedy="give plain numbers, in the unit that help() states"
        )
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(name, "rows of unequal length", allowed) from None
    check_kind(name, array, kinds, allowed)
    return array


def as_reals(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Coerce real numbers of any shape to float64; raises `InputError`."""
    return np.asarray(_numeric(name, values, "fiu", "real numbers"), dtype=np.float64)


def _check_each(name: str, array: NDArray[np.float64], bounds: Bounds, words: str = "") -> None:
    """Refuse the first number of an array that is out of bounds.

    `words` say in the error what is allowed; by default those of the bounds.
    """
    good = bounds.hold(array)
    if not good.all():
        k = int(good.argmin())
        row = row_index(k, array.shape) if array.ndim else None
        given = text_beside(float(array.flat[k]), bounds.high)
        raise InputError(name, given, words or bounds.words, row=row)


def as_reals_up_to(name: str, values: ArrayLike, high: float) -> NDArray[np.float64]:
    """Coerce real numbers from 0 to a largest one, or its rounding; raises `InputError`."""
    array = as_reals(name, values)
    rounded = Bounds(0.0, high * (1.0 + SINGLE_ROUNDING))
    _check_each(name, array, rounded, Bounds(0.0, high).words)
    return np.asarray(np.minimum(array, high))


def as_positive(name: str, values: ArrayLike, least: float = math.ulp(0.0)) -> NDArray[np.float64]:
    """Coerce finite real numbers, positive ones unless `least` is 0; raises `InputError`."""
    array = as_reals(name, values)
    allowed = "a finite number, 0 or more" if least == 0.0 else "a finite number above 0"
    _check_each(name, array, Bounds(least, text=allowed))
    return array


def as_finite(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Coerce finite real numbers; an argument of `VECTORS` has vectors on its last axis."""
    array = as_rows_of(name, values)
    _check_each(name, array, Bounds(text="finite numbers"))
    return array


def as_rows_of(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Coerce real numbers; an argument of `VECTORS` has vectors on its last axis.

    Raises `InputError`.
    """
    array = as_reals(name, values)
    check_vector(name, array.shape)
    return array


def check_vector(name: str, shape: Shape) -> None:
    """Refuse an argument of `VECTORS` whose last axis does not have the length of its vectors."""
    length = VECTORS.get(name)
    if length is not None and shape[-1:] != (length,):
        raise InputError(name, f"shape {shape}", f"({length},) or (..., {length})")


def _integers(name: str, values: ArrayLike, allowed: str) -> NDArray[Any]:
    """Make an array of integers; numpy makes floats of lists with some beyond int64."""
    if not isinstance(values, list | tuple) and type(values) is not int:
        return _numeric(name, values, "iu", allowed)
    array = np.array(values, dtype=object)
    kinds = {type(value) for value in array.flat}
    if bool in kinds or np.bool_ in kinds:  # which numpy counts among integers
        raise InputError(name, "bool values", allowed)
    if all(issubclass(kind, int | np.integer) for kind in kinds):
        return array
    return _numeric(name, values, "iu", allowed)


def as_keys(name: str, values: ArrayLike, bits: int) -> NDArray[Any]:
    """Coerce keys of random numbers to uint32 or uint64; raises `InputError`."""
    kind = np.dtype(f"u{bits // 8}")
    if type(values) is int and 0 <= values < 2**bits:
        return np.array(values, dtype=kind)
    array = _integers(name, values, keys_of(bits))
    check_keys(name, array, bits)
    return np.asarray(array, dtype=kind)


def keys_of(bits: int) -> str:
    """Say which keys are allowed."""
    return f"integers from 0 to 2**{bits} - 1"


def check_keys(name: str, array: Any, bits: int) -> None:
    """Refuse the first integer of an array, of any array library, that is no key."""
    if not array.size or array.dtype == f"u{bits // 8}":
        return
    flat = array.reshape(-1)
    refused = flat < 0
    if array.dtype == object or array.dtype.itemsize * 8 > bits:
        refused = refused | (flat > 2**bits - 1)
    if refused.any():
        k = int(refused.argmax())
        given = value_text(flat[k : k + 1].item())
        raise InputError(name, given, keys_of(bits), row=row_index(k, array.shape))


def as_integer(name: str, value: Any, low: int, high: int, allowed: str) -> int:
    """Coerce an integer, no bool, from low to high; `allowed` is the range in words."""
    try:  # numpy 1 would take its True for 1
        unfit = isinstance(value, bool | np.bool_) or is_masked(value)
        number = None if unfit else operator.index(value)
    except TypeError:
        number = None
    if number is None or not low <= number <= high:
        raise InputError(name, value_text(value), allowed)
    return number


def as_seed(seed: Any) -> int:
    """Coerce the seed of a run; raises `InputError`."""
    return as_integer("seed", seed, 0, 2**64 - 1, "an integer from 0 to 2**64 - 1")


def as_threads(threads: Any) -> int | None:
    """Coerce a number of threads, or None; raises `InputError`."""
    if threads is None:
        return None
    return as_integer("threads", threads, 1, 4096, "an integer from 1 to 4096")


# -- shapes ----------------------------------------------------------------------------------------


def _as_size(size: Any) -> Shape:
    """Coerce an integer or a sequence of integers to a shape."""
    allowed = "an integer or a tuple of integers, at least 0"
    try:
        parts = tuple(size) if np.ndim(size) else (size,)
    except (TypeError, ValueError):
        parts = (size,)
    shape = tuple(as_integer("size", part, 0, 2**62, allowed) for part in parts)
    if math.prod(shape) <= 2**32:
        return shape
    raise InputError("size", value_text(size), "2**32 draws at most in one call")


def common_shape(shapes: Mapping[str, Shape], size: Any = None) -> Shape:
    """Find the shape to which the rows of all arguments broadcast: that of `size`, if given.

    Arrays of several rows have the same number of dimensions: (n, 1) beside (n,) would quietly
    become (n, n). Raises `InputError`.
    """
    shape: Shape = ()
    first = ""  # argument of several rows
    for name, own in shapes.items():
        several = math.prod(own) != 1
        if several and first and len(own) != len(shapes[first]):
            allowed = f"one row, or rows of as many dimensions as {first} has, {shapes[first]}"
            raise InputError(name, f"rows of shape {own}", allowed)
        try:
            shape = np.broadcast_shapes(shape, own) if shape and own else shape or own
        except ValueError:
            allowed = f"one that broadcasts with {shape}"
            raise InputError(name, f"shape {own}", allowed) from None
        first = first or (name if several else "")
    if size is None:
        return shape
    wanted = _as_size(size)
    try:
        fits = np.broadcast_shapes(shape, wanted) == wanted
    except ValueError:
        fits = False
    if not fits:
        raise InputError("size", value_text(size), f"a shape to which {shape} broadcasts")
    return wanted


def _flat(library: Any, array: Any, shape: Shape, tail: Shape) -> Any:
    """Make rows of an array, shape (n, *tail), or (1, *tail) where one row stands for all."""
    if array.size != math.prod(tail) and array.shape != shape + tail:
        array = library.broadcast_to(array, shape + tail)
    return library.ascontiguousarray(array).reshape(-1, *tail)


# -- calls -----------------------------------------------------------------------------------------


class Keys(NamedTuple):
    """The choice of random numbers as a user gave it: keys, or a generator and a size."""

    seed: Any = None
    index: Any = None
    hit: Any = None
    rng: Any = None
    size: Any = None

    def checked(self) -> "Keys":
        """Return the same; raises `InputError` if it is neither keys nor a generator, or both."""
        if self.rng is None:
            for name, value in (("seed", self.seed), ("index", self.index)):
                if value is None:
                    raise InputError(name, problem="is missing", remedy=_GIVE_KEYS)
            if self.size is not None:
                raise InputError("size", problem="is given without rng", remedy=_GIVE_KEYS)
            return self
        for name, value in (("seed", self.seed), ("index", self.index), ("hit", self.hit)):
            if value is not None:
                raise InputError(name, problem="is given beside rng", remedy=_GIVE_KEYS)
        if not isinstance(self.rng, np.random.Generator):
            allowed = "a numpy.random.Generator, such as numpy.random.default_rng(1)"
            raise InputError("rng", type(self.rng).__name__, allowed)
        return self


class Call(NamedTuple):
    """Arguments of a call, broadcast: their shape without the last axis of vectors, and rows."""

    shape: Shape
    rows: Rows

    def at(self, name: str, row: int) -> Any:
        """Give an argument of a row."""
        values = self.rows.arrays[name]
        return values[row if len(values) > 1 else 0]

    def refusal(
        self, row: int, name: str, given: object = None, allowed: str = "", problem: str = ""
    ) -> InputError:
        """Make the error of a row, with its index in the arrays and its particle."""
        index, particle = row_index(row, self.shape), int(self.at("index", row))
        return InputError(name, given, allowed, problem=problem, row=index, particle=particle)


def without_none(**optional: Any) -> dict[str, Any]:
    """Give the arguments that are not None."""
    return {name: values for name, values in optional.items() if values is not None}


class HostArrays:
    """How arguments become arrays of numpy; `sampler.device` makes them arrays of CuPy."""

    library: Any = np
    reals = staticmethod(as_rows_of)
    keys = staticmethod(as_keys)


def broadcast(
    arguments: Mapping[str, ArrayLike], keys: Keys, fresh: bool = False, arrays_of: Any = HostArrays
) -> Call:
    """Make rows of arguments and of their keys; raises `InputError` for a wrong type or shape.

    A generator gives one 64-bit number, which is the seed; rows are numbered from 0, and hit is 0.
    """
    keys = keys.checked()
    for name in ("spin", "omega"):
        if name in arguments and keys.rng is None and keys.hit is None:
            remedy = f"with {name}=, give how many walls each particle has met before"
            raise InputError("hit", problem="is missing", remedy=remedy)
    arrays: dict[str, Any] = {n: arrays_of.reals(n, v) for n, v in arguments.items()}
    tails: dict[str, Shape] = {name: (VECTORS[name],) if name in VECTORS else () for name in arrays}
    shapes = {name: a.shape[: a.ndim - len(tails[name])] for name, a in arrays.items()}
    if keys.rng is None:
        hit = arrays_of.keys("hit", 0 if keys.hit is None else keys.hit, 32)
        index = arrays_of.keys("index", keys.index, 64)
        seed = as_seed(keys.seed)
        shape = common_shape(shapes | {"hit": hit.shape, "index": index.shape})
        if index.size == hit.size == 1 < math.prod(shape):
            given = f"one number, {int(index.reshape(-1)[0])}, for {math.prod(shape)} rows"
            raise InputError("index", given, "one number for each row, such as numpy.arange(n)")
    else:
        shape = common_shape(shapes, keys.size)
        seed = int(keys.rng.integers(2**64, dtype=np.uint64))
        hit, index = np.zeros(1, dtype=np.uint32), np.arange(math.prod(shape), dtype=np.uint64)
        index = index.reshape(shape)
    arrays |= {"index": index, "hit": hit}
    library = arrays_of.library
    rows = {n: _flat(library, array, shape, tails.get(n, ())) for n, array in arrays.items()}
    return Call(shape, Rows(math.prod(shape), seed, rows, fresh))


def with_zero_spin_if_own(given: dict[str, Any], grain: str | None) -> dict[str, Any]:
    """Add a spin of zero to the arguments of a draw of the own grain that have no spin."""
    return {"spin": (0.0, 0.0, 0.0)} | given if grain == "own" and "alpha1" in given else given


def check_grain_word(grain: Any) -> None:
    """Refuse a word for a grain that is neither "own" nor "fresh"."""
    if isinstance(grain, str) and grain not in ("own", "fresh"):
        raise InputError("grain", repr(grain), "'own', 'fresh', or numbers of shape (..., 3)")


def check_written(name: str, array: Any, shape: Shape, *dtypes: Any) -> None:
    """Refuse an array for results that has another shape or dtype, or is read-only; allow None."""
    plain = isinstance(array, np.ndarray) and not is_masked(array)
    fits = plain and array.dtype in dtypes and array.shape == shape and array.flags.writeable
    if array is not None and not fits:
        given = f"{array.dtype} {array.shape}" if plain else type(array).__name__
        kinds = " or ".join(np.dtype(dtype).name for dtype in dtypes)
        raise InputError(name, given, f"a writable {kinds} array {shape}")


def as_isotropic(isotropic: Any, roughness: Any) -> bool:
    """Coerce whether rough walls are isotropic; raises `InputError`, for smooth ones too."""
    if not isinstance(isotropic, bool | np.bool_):
        raise InputError("isotropic", value_text(isotropic), "True or False")
    if isotropic and roughness is None:
        problem, remedy = "is True for a smooth wall", "give roughness=, or leave isotropic= out"
        raise InputError("isotropic", problem=problem, remedy=remedy)
    return bool(isotropic)
