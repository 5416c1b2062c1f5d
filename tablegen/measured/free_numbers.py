"""Free numbers of contact laws: names, ranges, roughness, and their places in a pair file.

A name is the path of a field of the pair file, such as ``pair.resistance.strength``. Fields that
hold several numbers are freed together.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.special import comb

from sampler.errors import InputError
from tablegen.config.complaints import shown
from tablegen.config.config import Config
from tablegen.config.pairs import MaterialPair
from tablegen.config.scenes import Tree, merged
from tablegen.model.float_array import FloatArray

STATIC = "pair.resistance.static"

#: Coefficients that are searched as those of Bernstein, so that the restitution stays in [0, 1].
_POLYNOMIAL = "pair.restitution.coefficients"

#: Weights of roughness: second differences along angles, first ones along speeds, and distances
#: from the start, which decide what nothing else does.
_BEND_WEIGHT, _SPEED_WEIGHT, _START_WEIGHT = 1.0, 0.3, 0.01

#: A second difference of this size counts as a mean that is off by its tolerance.
_ROUGH_DIFFERENCE = 0.1

#: Decimals of a fitted number in a file, far below any standard error.
_DIGITS = 5


class Range(NamedTuple):
    """Range of a number in a pair file, and the step of its finite differences."""

    low: float
    high: float
    #: A small change of a law decides whether some particles hit once more: EXPERIMENTS.md.
    step: float
    #: Whether the coordinate is the logarithm.
    logarithmic: bool = False


_UNIT_RANGE = Range(0.0, 1.0, 0.04)
_FRICTION_RANGE = Range(0.0, 3.0, 0.05)

#: Ranges of the fields of the laws that can be freed.
_FIELDS: Mapping[tuple[str, str], Mapping[str, Range]] = {
    ("restitution", "exponential"): {
        "coefficient": Range(1e-4, 1e2, 0.05, logarithmic=True),
        "exponent": Range(0.01, 3.0, 0.02),
    },
    ("restitution", "polynomial"): {"coefficients": _UNIT_RANGE},
    ("restitution", "constant"): {"value": _UNIT_RANGE},
    ("restitution", "power"): {
        "coefficient": Range(1e-3, 1e3, 0.05, logarithmic=True),
        "exponent": Range(1e-3, 2.0, 0.02),
    },
    ("restitution", "tabulated"): {"value": _UNIT_RANGE},
    ("resistance", "exponential-orientation"): {
        "strength": Range(-10.0, 10.0, 0.2),
        "factor": Range(1e-3, 1e2, 0.1, logarithmic=True),
    },
    ("resistance", "constant"): {"value": Range(1e-3, 1e2, 0.05, logarithmic=True)},
    ("resistance", "tabulated"): {"value": _FRICTION_RANGE},
    ("resistance", "coulomb"): {
        "static": _FRICTION_RANGE,
        "dynamic": _FRICTION_RANGE,
        "tangential_restitution": Range(-1.0, 1.0, 0.04),
    },
}


def allowed_ranges(config: Config) -> dict[str, Range]:
    """List the fields of a pair that can be freed: those with an effect on its grains."""
    ranges: dict[str, Range] = {}
    for (section, law), fields in _FIELDS.items():
        if getattr(config.pair, section).law == law:
            ranges |= {f"pair.{section}.{field}": one for field, one in fields.items()}
    if config.population.only_spheres:
        ranges.pop(STATIC, None)  # a sphere that does not slide has stuck for good
    if getattr(config.pair.resistance, "tangential_restitution", None) is None:
        ranges.pop("pair.resistance.tangential_restitution", None)
    return ranges


def chosen_names(config: Config, free: Sequence[str]) -> tuple[str, ...]:
    """Choose free fields: those named; by default all, to which ``+NAME`` adds.

    Raises `InputError` if a name is unknown or given twice.
    """
    allowed, plain = allowed_ranges(config), [name.removeprefix("+") for name in free]
    for name in plain:
        if name not in allowed:
            raise InputError("free", shown(name), ", ".join(allowed))
    if len(set(plain)) < len(plain):
        raise InputError("free", shown(plain), "each name once")
    added = all(name.startswith("+") for name in free)
    return tuple(name for name in allowed if added or name in plain)


@dataclass(frozen=True)
class _Field:
    """A field of a pair file with k free numbers."""

    name: str
    shape: tuple[int, ...]
    #: Makes numbers of the file from coordinates (k,).
    values: Callable[[FloatArray], FloatArray]
    start: FloatArray
    low: FloatArray
    high: FloatArray
    step: FloatArray
    #: Rows whose squares say how rough the law is, (r, k).
    rough: FloatArray

    @property
    def labels(self) -> list[str]:
        """Name each number."""
        single = len(self.shape) == 2 and self.shape[1] == 1
        places = np.ndindex(self.shape[:1] if single else self.shape)
        return [self.name + "".join(f"[{k}]" for k in place) for place in places]

    def tree(self, x: FloatArray) -> Tree:
        """Make the field of the pair file."""
        numbers = self.values(x).reshape(self.shape)
        rounded = numbers if self.name == _POLYNOMIAL else np.round(numbers, _DIGITS)
        return reduce(
            lambda tree, part: {part: tree}, reversed(self.name.split(".")), rounded.tolist()
        )


def _field(config: Config, name: str, allowed: Range) -> _Field:
    """Make a free field with the numbers that a pair has."""
    value = reduce(getattr, name.split("."), config)
    given = np.asarray(value, dtype=np.float64)
    inside = (given >= allowed.low) & (given <= allowed.high)
    if name != _POLYNOMIAL and not inside.all():
        got, words = shown(float(given[~inside][0])), f"{allowed.low:g} to {allowed.high:g}"
        raise InputError(name, f"{got} to start from", words)
    values: Callable[[FloatArray], FloatArray] = np.asarray
    start, ends, k = given.ravel(), np.array([allowed.low, allowed.high]), given.size
    if allowed.logarithmic:
        start, ends, values = np.log(start), np.log(ends), _exponential
    elif name == _POLYNOMIAL:
        powers = _from_bernstein(k)
        start = np.asarray(np.linalg.solve(powers, start), dtype=np.float64)
        values = powers.__matmul__
    return _Field(
        name=name,
        shape=given.shape,
        values=values,
        start=np.clip(start, *ends),
        low=np.full(k, ends[0]),
        high=np.full(k, ends[1]),
        step=np.full(k, allowed.step),
        rough=_roughness(given.shape) if given.ndim and name != _POLYNOMIAL else np.zeros((0, k)),
    )


def _exponential(x: FloatArray) -> FloatArray:
    return np.asarray(np.exp(x), dtype=np.float64)


def _from_bernstein(count: int) -> FloatArray:
    """Make the matrix from coefficients of Bernstein on [0, pi/2] to those of powers.

    A polynomial lies between the least and the largest of them. Source: R. T. Farouki, Comput.
    Aided Geom. Des. 29 (2012) 379-419, sec. 3.
    """
    n, matrix = count - 1, np.zeros((count, count))
    for k, j in np.ndindex(count, count):
        if j <= k:
            matrix[k, j] = (-1.0) ** (k - j) * comb(n, k) * comb(k, j) / (0.5 * np.pi) ** k
    return matrix


def _roughness(shape: tuple[int, ...]) -> FloatArray:
    """Make the rows of second differences along angles, and of first ones along speeds."""
    angles, speeds = shape[0], int(np.prod(shape[1:]))
    along = np.kron(np.diff(np.eye(angles), 2, axis=0), np.eye(speeds)) * _BEND_WEIGHT
    across = np.kron(np.eye(angles), np.diff(np.eye(speeds), axis=0)) * _SPEED_WEIGHT
    return np.vstack([along, across])


class FreeNumbers:
    """The p free numbers of a pair as coordinates of a bounded search.

    Raises `InputError` if a number to start from is out of its range.
    """

    def __init__(self, config: Config, names: Sequence[str]) -> None:
        ranges = allowed_ranges(config)
        self._fields = [_field(config, name, ranges[name]) for name in names]
        self._spheres = config.population.only_spheres
        self._pair = config.pair.model_dump(mode="json", by_alias=True, exclude_none=True)
        self.labels = tuple(label for field in self._fields for label in field.labels)
        self.start, self.low, self.high, self.step = (
            np.concatenate([getattr(field, part) for field in self._fields])
            for part in ("start", "low", "high", "step")
        )
        self._ends = np.cumsum([field.start.size for field in self._fields])[:-1]

    @property
    def smoothness(self) -> FloatArray:
        """Rows (r, p) whose squares are to be small: differences, and distances from the start.

        Laws that are no tables have none of the former.
        """
        rough = block_diag(*(field.rough for field in self._fields))
        return np.vstack([rough, _START_WEIGHT * np.eye(self.start.size)]) / _ROUGH_DIFFERENCE

    def bend(self, x: FloatArray) -> float:
        """Find the largest second difference of a free table of restitution along angles, or 0."""
        value = self.changes(x)["pair"].get("restitution", {}).get("value", 0.0)
        return float(np.abs(np.diff(np.atleast_1d(value), 2, axis=0)).max(initial=0.0))

    def numbers(self, x: FloatArray) -> FloatArray:
        """Compute the numbers (p,) of a file from coordinates (p,)."""
        parts = zip(self._fields, np.split(x, self._ends), strict=True)
        return np.concatenate([field.values(part) for field, part in parts])

    def changes(self, x: FloatArray) -> Tree:
        """Make the fields of the pair file that differ."""
        parts = zip(self._fields, np.split(x, self._ends), strict=True)
        tree: Tree = {}
        for field, part in parts:
            tree = merged(tree, field.tree(part))
        resistance = tree.get("pair", {}).get("resistance", {})
        if {"static", "dynamic"} & resistance.keys():
            # the static coefficient is at least the dynamic one, which alone acts on spheres
            both = {**self._pair["resistance"], **resistance}
            least = 0.0 if self._spheres else both["static"]
            resistance["static"] = max(least, both["dynamic"])
        return tree

    def pair(self, x: FloatArray) -> MaterialPair:
        """Make the laws of contact."""
        return MaterialPair.from_tree(merged({"pair": self._pair}, self.changes(x))["pair"])
