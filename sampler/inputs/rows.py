"""Arguments of a call turned into what a kernel takes: rows, and the keys of their random numbers.

Arguments broadcast as in numpy. A single number stands for every row and is not copied; an array
that has the shape of all is passed on as it is where its type and layout allow.
"""

import math
import operator
import textwrap
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sampler.arguments import told_apart
from sampler.errors import InputError

Shape = tuple[int, ...]

#: Arguments whose last axis has three numbers: the components of a vector, or what a grain is.
VECTORS = ("velocity", "normal", "wall_velocity", "spin", "omega", "grain")


def place(row: int, shape: Shape) -> str:
    """Where a row lies in arrays of a shape, for messages: ``index 7`` or ``index (1, 2)``."""
    if len(shape) < 2:
        return f"index {row}"
    return f"index {tuple(int(k) for k in np.unravel_index(row, shape))}"


def _numeric(name: str, values: ArrayLike, kinds: str, allowed: str) -> NDArray[Any]:
    """Array of one of the dtype kinds; an empty array has no kind yet and passes."""
    if isinstance(values, np.ma.MaskedArray):  # numpy would hand on what lies under the mask
        raise InputError(f"{name}: got a masked array, allowed: {allowed} without a mask")
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(f"{name}: got rows of unequal length, allowed: {allowed}") from None
    check_kind(name, array, kinds, allowed)
    return array


def check_kind(name: str, array: Any, kinds: str, allowed: str) -> None:
    """Refuse an array of another kind of numbers; an empty one has no kind yet."""
    if array.size and array.dtype.kind not in kinds:
        raise InputError(f"{name}: got {array.dtype.name} values, allowed: {allowed}")


def as_reals(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Real numbers of any shape as float64; raises `InputError` if they are none."""
    return np.asarray(_numeric(name, values, "fiu", "real numbers"), dtype=np.float64)


def as_reals_up_to(
    name: str, values: ArrayLike, high: float, unit: str = ""
) -> NDArray[np.float64]:
    """Real numbers from 0 to a largest one; raises `InputError` if one is not."""
    array = as_reals(name, values)
    refused = ~((array >= 0.0) & (array <= high))
    if refused.any():
        k = int(refused.argmax())
        where = f"{told_apart(float(array.flat[k]), high)} at {place(k, array.shape)}"
        raise InputError(f"{name}: got {where}, allowed: 0 to {high:g}{unit}")
    return array


def as_rows_of(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Real numbers, or vectors where the name is that of one."""
    array = as_reals(name, values)
    check_vector(name, array.shape)
    return array


def check_vector(name: str, shape: Shape) -> None:
    """Refuse the shape of an argument that is no vector where its name is that of one."""
    if name in VECTORS and shape[-1:] != (3,):
        raise InputError(f"{name}: got shape {shape}, allowed: (3,) or (..., 3)")


def _integers(name: str, values: ArrayLike, allowed: str) -> NDArray[Any]:
    """Array of integers; numpy makes floats of Python's own where some exceed int64, and rounds."""
    if not isinstance(values, list | tuple) and type(values) is not int:
        return _numeric(name, values, "iu", allowed)
    if isinstance(values, list | tuple) and set(map(type, values)) == {int}:
        plain = np.asarray(values)
        if plain.dtype.kind in "iu":
            return plain
    array = np.array(values, dtype=object)
    kinds = {type(value) for value in array.flat}
    if bool in kinds or np.bool_ in kinds:  # which numpy counts among integers
        raise InputError(f"{name}: got bool values, allowed: {allowed}")
    if all(issubclass(kind, int | np.integer) for kind in kinds):
        return array
    return _numeric(name, values, "iu", allowed)


def as_keys(name: str, values: ArrayLike, bits: int) -> NDArray[Any]:
    """Keys of random numbers as uint32 or uint64; raises `InputError` if they do not fit."""
    kind = np.dtype(f"u{bits // 8}")
    if type(values) is int and 0 <= values < 2**bits:
        return np.array(values, dtype=kind)
    array = _integers(name, values, keys_of(bits))
    check_keys(name, array, bits)
    return np.asarray(array, dtype=kind)


def keys_of(bits: int) -> str:
    """Which keys are allowed, in words."""
    return f"integers from 0 to 2**{bits} - 1"


def check_keys(name: str, array: Any, bits: int) -> None:
    """Refuse the first integer of an array, of any array library, that is no key."""
    if not array.size:
        return
    flat = array.reshape(-1)
    refused = flat < 0
    if array.dtype == object or array.dtype.itemsize * 8 > bits:
        refused = refused | (flat > 2**bits - 1)
    if refused.any():
        k = int(refused.argmax())
        got = f"{_shown(flat[k : k + 1].item())} at {place(k, array.shape)}"
        raise InputError(f"{name}: got {got}, allowed: {keys_of(bits)}")


def _shown(value: Any) -> str:
    """Text of a value for a message of one line."""
    if isinstance(value, int) and value.bit_length() > 256:
        # Python refuses to write out thousands of digits
        return f"an integer of {value.bit_length()} bits"
    return textwrap.shorten(repr(value), 80, placeholder=" ...")


def as_integer(name: str, value: Any, low: int, high: int, allowed: str) -> int:
    """Integer from low to high; raises `InputError` if it is none.

    Parameters
    ----------
    name : str
        Of the argument, for the message.
    value : object
        What was given; True and False, and floats of any value, are no integers.
    low, high : int
    allowed : str
        The range in words.
    """
    try:
        number = operator.index(value)
    except TypeError:
        number = None
    if isinstance(value, bool | np.ma.MaskedArray) or number is None or not low <= number <= high:
        raise InputError(f"{name}: got {_shown(value)}, allowed: {allowed}")
    return number


def as_seed(seed: Any) -> int:
    """Seed of a run; raises `InputError` if it is none."""
    return as_integer("seed", seed, 0, 2**64 - 1, "an integer from 0 to 2**64 - 1")


def _as_size(size: Any) -> Shape:
    """Shape from an integer or a sequence of integers."""
    allowed = "an integer or a tuple of integers, at least 0"
    try:
        parts = tuple(size) if np.ndim(size) else (size,)
    except (TypeError, ValueError):
        parts = (size,)
    return tuple(as_integer("size", part, 0, 2**62, allowed) for part in parts)


def common_shape(shapes: Mapping[str, Shape], size: Any = None) -> Shape:
    """Shape to which all arguments broadcast: that of `size`, if given.

    Raises
    ------
    InputError
        If an argument does not fit those before it, or all of them not `size`.
    """
    shape: Shape = ()
    for name, own in shapes.items():
        try:
            shape = np.broadcast_shapes(shape, own) if shape and own else shape or own
        except ValueError:
            allowed = f"one that broadcasts with {shape}"
            raise InputError(f"{name}: got shape {own}, allowed: {allowed}") from None
    if size is None:
        return shape
    wanted = _as_size(size)
    try:
        fits = np.broadcast_shapes(shape, wanted) == wanted
    except ValueError:
        fits = False
    if not fits:
        raise InputError(f"size: got {_shown(size)}, allowed: a shape to which {shape} broadcasts")
    return wanted


def _flat(array: NDArray[Any], shape: Shape, tail: Shape) -> NDArray[Any]:
    """Rows of an array, shape (n, *tail), or (1, *tail) where one row stands for all.

    What cannot be written is copied: it has another type to numba, which would compile for it.
    """
    if array.size != math.prod(tail) and array.shape != shape + tail:
        array = np.broadcast_to(array, shape + tail)
    rows = np.ascontiguousarray(array).reshape(-1, *tail)
    return rows if rows.flags.writeable else rows.copy()


class Keys(NamedTuple):
    """What selects random numbers, as the user gave it: keys, or a generator and a size."""

    seed: Any = None
    index: Any = None
    hit: Any = None
    rng: Any = None
    size: Any = None

    def checked(self) -> "Keys":
        """Return the same; raises `InputError` if it is neither keys nor a generator, or both."""
        both = "seed=, index= and hit=, or rng= and size= in their place"
        if self.rng is None:
            for name, value in (("seed", self.seed), ("index", self.index)):
                if value is None:
                    raise InputError(f"{name}: is missing, allowed: {both}")
            if self.size is not None:
                raise InputError(f"size: got {_shown(self.size)} without rng, allowed: {both}")
            return self
        for name, value in (("seed", self.seed), ("index", self.index), ("hit", self.hit)):
            if value is not None:
                raise InputError(f"{name}: got a value besides rng, allowed: {both}")
        if not isinstance(self.rng, np.random.Generator):
            allowed = "a numpy.random.Generator, such as numpy.random.default_rng(1)"
            raise InputError(f"rng: got {type(self.rng).__name__}, allowed: {allowed}")
        return self


class Rows(NamedTuple):
    """Arguments of a call, broadcast.

    Attributes
    ----------
    shape : tuple of int
        Shape of the call's arrays; n is the number of their elements.
    values : dict of arrays, shape (n,) or (1,), vectors (n, 3) or (1, 3)
        Arguments by name.
    keys : tuple
        Seed, uint64; index, uint64, and hit, uint32, of shape (n,) or (1,).
    """

    shape: Shape
    values: dict[str, NDArray[np.float64]]
    keys: tuple[np.uint64, NDArray[np.uint64], NDArray[np.uint32]]

    @property
    def n(self) -> int:
        """Number of rows."""
        return math.prod(self.shape)

    def at(self, name: str, row: int) -> Any:
        """Value of an argument in a row."""
        values = self.values[name]
        return values[row if len(values) > 1 else 0]


def broadcast(arguments: Mapping[str, ArrayLike], keys: Keys) -> Rows:
    """Rows of arguments and of their keys.

    A generator gives one 64-bit number, which is the seed; rows are numbered from 0, and hit is 0.

    Raises
    ------
    InputError
        If an argument has a wrong type or shape.
    """
    keys = keys.checked()
    arrays = {name: as_rows_of(name, values) for name, values in arguments.items()}
    tails: dict[str, Shape] = {name: (3,) if name in VECTORS else () for name in arrays}
    shapes = {name: a.shape[: a.ndim - len(tails[name])] for name, a in arrays.items()}
    if keys.rng is None:
        hit = as_keys("hit", 0 if keys.hit is None else keys.hit, 32)
        index = as_keys("index", keys.index, 64)
        seed = as_seed(keys.seed)
        shape = common_shape(shapes | {"hit": hit.shape, "index": index.shape})
    else:
        shape = common_shape(shapes, keys.size)
        seed = int(keys.rng.integers(2**64, dtype=np.uint64))
        hit, index = np.zeros(1, dtype=np.uint32), np.arange(math.prod(shape), dtype=np.uint64)
        index = index.reshape(shape)
    values = {name: _flat(array, shape, tails[name]) for name, array in arrays.items()}
    return Rows(shape, values, (np.uint64(seed), _flat(index, shape, ()), _flat(hit, shape, ())))
