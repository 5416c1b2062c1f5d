"""Parameters that a calibration can free: their names, ranges and places in a pair file.

A name is the path of a field of the pair file, such as ``pair.resistance.strength``. Fields that
hold several numbers are freed together.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

import numpy as np

from sampler.errors import InputError
from tablegen.config.complaints import shown
from tablegen.config.config import Config
from tablegen.config.population import FixedAspect, TruncatedNormalAspect
from tablegen.config.scenes import Tree, merged
from tablegen.measured.search_coordinates import (
    DESCENDING,
    LOGARITHM,
    PLAIN,
    SHARES,
    Coordinates,
    bernstein,
)
from tablegen.measured.simulated_rows import WALL_TILT_DEG
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import ASPECT

#: Name of the roughness of the wall, which is not a field of a pair file.
WALL_TILT = "wall_tilt_deg"

#: Name of the weights of all shapes together; ``.SHAPE`` behind it: of one shape.
SHAPES = "population.shapes"

STATIC, DYNAMIC = "pair.resistance.static", "pair.resistance.dynamic"

#: Coefficients that are searched, and not rounded, so that the restitution stays from 0 to 1.
POLYNOMIAL = "pair.restitution.coefficients"

#: Digits of a fitted number in a file, far below any standard error.
_DIGITS = 7


@dataclass(frozen=True)
class Range:
    """Range of a number in a pair file."""

    #: Bounds that physics or a pair file sets.
    low: float
    high: float
    #: Part of it in which random starts lie.
    first: float
    last: float
    #: Step of finite differences of the coordinate: see EXPERIMENTS.md.
    step: float
    #: Whether the coordinate is the logarithm.
    logarithmic: bool = False


#: Restitution.
_UNIT = Range(low=0.0, high=1.0, first=0.1, last=0.95, step=0.04)
_RESISTANCE = Range(low=1e-3, high=1e2, first=0.05, last=2.0, step=0.05, logarithmic=True)
_TABLE = Range(low=0.0, high=20.0, first=0.0, last=1.5, step=0.1)
_SHARE = Range(low=0.0, high=1.0, first=0.0, last=1.0, step=0.05)
_FRICTION = Range(low=0.0, high=10.0, first=0.05, last=1.0, step=0.02)
#: Coordinates of both coefficients of friction: the static one, and the ratio of the dynamic one.
_BOTH_FRICTIONS = (
    Range(low=1e-3, high=10.0, first=0.05, last=1.0, step=0.02),
    Range(low=0.0, high=1.0, first=0.3, last=1.0, step=0.02),
)
#: Aspect ratios.
_RATIO = Range(low=ASPECT.low, high=ASPECT.high, first=0.3, last=ASPECT.high, step=0.02)
_DEVIATION = Range(low=0.01, high=3.0, first=0.02, last=0.5, step=0.3, logarithmic=True)
_TRUNCATION = Range(low=0.01, high=0.99, first=0.1, last=0.9, step=0.05)
_TILT = Range(low=0.0, high=WALL_TILT_DEG.high, first=0.5, last=10.0, step=0.5)


#: Ranges of the fields of the laws that can be freed.
LAWS: Mapping[tuple[str, str], Mapping[str, Range]] = {
    ("restitution", "exponential"): {
        "coefficient": Range(low=1e-4, high=1e2, first=0.01, last=1.0, step=0.05, logarithmic=True),
        "exponent": Range(low=0.01, high=3.0, first=0.1, last=1.0, step=0.02),
    },
    ("restitution", "polynomial"): {"coefficients": _UNIT},
    ("restitution", "constant"): {"value": _UNIT},
    ("restitution", "power"): {
        "coefficient": Range(low=1e-3, high=1e3, first=0.1, last=2.0, step=0.05, logarithmic=True),
        "exponent": Range(low=1e-3, high=2.0, first=0.05, last=0.5, step=0.02),
    },
    ("restitution", "tabulated"): {"value": _UNIT},
    ("resistance", "exponential-orientation"): {
        "strength": Range(low=-10.0, high=10.0, first=-6.0, last=3.0, step=0.2),
        "factor": Range(low=1e-3, high=1e2, first=0.1, last=10.0, step=0.1, logarithmic=True),
    },
    ("resistance", "constant"): {"value": _RESISTANCE},
    ("resistance", "tabulated"): {"value": _TABLE},
    ("resistance", "coulomb"): {"static": _FRICTION, "dynamic": _FRICTION},
}


class Space(NamedTuple):
    """Coordinates of a search, (p,) float64 each: the start, and the ranges as in `Range`."""

    start: FloatArray
    low: FloatArray
    high: FloatArray
    first: FloatArray
    last: FloatArray
    step: FloatArray

    @property
    def width(self) -> FloatArray:
        """Width of the range in which random starts lie."""
        return self.last - self.first


@dataclass(frozen=True)
class Parameter:
    """Numbers of a pair file that are freed together."""

    name: str
    #: Names of the k numbers.
    labels: Sequence[str]
    scale: Coordinates
    space: Space
    #: Makes the fields of a pair file from the numbers.
    fields: Callable[[FloatArray], Tree]
    #: Whether a file gets rounded numbers, which could break a rule between them.
    rounded: bool = True

    def changes(self, x: FloatArray) -> Tree:
        """Make the fields of the pair file for coordinates (k,)."""
        values = self.scale.values(x)
        if self.rounded:
            values = np.array([_rounded(value) for value in values])
        return self.fields(values)


def _rounded(value: float) -> float:
    """Round a number as a file has it."""
    return float(f"{value:.{_DIGITS}g}")


def _nested(path: str, value: object) -> Tree:
    """Make a tree with one value at a dotted path."""
    head, _, rest = path.partition(".")
    return {head: _nested(rest, value) if rest else value}


def _given(config: Config, path: str) -> FloatArray:
    """Read the numbers at a dotted path of a pair."""
    value = reduce(getattr, path.split("."), config)
    return np.asarray(value, dtype=np.float64)


def _space(
    labels: Sequence[str], given: FloatArray, ranges: Sequence[Range], scale: Coordinates
) -> Space:
    """Make the coordinates of given numbers (k,), with a range for each; refuse others."""
    ends = np.array([(r.low, r.high, r.first, r.last) for r in ranges]).T
    low, high, first, last = scale.coordinates(ends) if scale is LOGARITHM else ends
    start, slack = scale.coordinates(given), 1e-9 * (high - low)
    for k, one in enumerate(ranges):
        if not low[k] - slack[k] <= start[k] <= high[k] + slack[k]:
            got, allowed = shown(float(given[k])), f"{one.low:g} to {one.high:g}"
            raise InputError(f"{labels[k]}: got {got} to start from, allowed: {allowed}")
    step = np.array([r.step for r in ranges])
    return Space(np.clip(start, low, high), low, high, first, last, step)


def _field(name: str, given: FloatArray, allowed: Range) -> Parameter:
    """Make the parameter of one field with given numbers."""
    places = ["".join(f"[{k}]" for k in place) for place in np.ndindex(given.shape)]
    if given.ndim == 2 and given.shape[1] == 1:
        places = [f"[{k}]" for k in range(len(given))]
    labels = [name + place for place in places]
    scale = LOGARITHM if allowed.logarithmic else PLAIN
    polynomial = name == POLYNOMIAL
    if polynomial:
        scale = bernstein(given.size, np.pi / 2)
    space = _space(labels, given.ravel(), [allowed] * given.size, scale)

    def fields(values: FloatArray) -> Tree:
        return _nested(name, values.reshape(given.shape).tolist())

    return Parameter(name, labels, scale, space, fields, rounded=not polynomial)


def _both_frictions(config: Config) -> Parameter:
    labels, given = (STATIC, DYNAMIC), np.array([_given(config, n) for n in (STATIC, DYNAMIC)])
    space = _space(labels, given, _BOTH_FRICTIONS, DESCENDING)

    def fields(values: FloatArray) -> Tree:
        return merged(*(_nested(n, x) for n, x in zip(labels, values.tolist(), strict=True)))

    return Parameter(STATIC, labels, DESCENDING, space, fields)


def _shares(config: Config, names: Sequence[str]) -> Parameter:
    """Make the parameter of the shares of some shapes; the others keep their ratios."""
    weights = config.population.shapes.model_dump(by_alias=True)
    total = sum(weights.values())
    rest = {name: w for name, w in weights.items() if w > 0.0 and name not in names}
    # if all shapes are free, the last has the share that the others leave
    free = list(names) if rest else list(names[:-1])
    if not free:
        raise InputError(f"free: got {SHAPES}.{names[0]}, the only shape, allowed: one of several")
    labels = [f"{SHAPES}.{name}" for name in free]
    given = np.array([weights[name] / total for name in free])
    space = _space(labels, given, [_SHARE] * len(free), SHARES)
    others = rest or {names[-1]: 1.0}

    def fields(values: FloatArray) -> Tree:
        left = max(1.0 - values.sum(), 0.0) / sum(others.values())
        shares = dict(zip(free, values.tolist(), strict=True))
        shares |= {shape: _rounded(weight * left) for shape, weight in others.items()}
        return {"population": {"shapes": {shape: total * x for shape, x in shares.items()}}}

    return Parameter(SHAPES, labels, SHARES, space, fields)


def _ranges(config: Config) -> dict[str, Range]:
    """List the fields of a pair that can be freed, except for the weights of shapes."""
    found: dict[str, Range] = {}
    for (section, law), allowed in LAWS.items():
        if getattr(config.pair, section).law == law:
            found |= {f"pair.{section}.{field}": one for field, one in allowed.items()}
    aspect = config.population.aspect
    if isinstance(aspect, TruncatedNormalAspect):
        low, high = aspect.range
        step = 0.1 * (high - low)
        found["population.aspect.mean"] = Range(low, high, first=low, last=high, step=step)
        found["population.aspect.standard_deviation"] = _DEVIATION
    elif isinstance(aspect, FixedAspect):
        found["population.aspect.values"] = _RATIO
    if "truncated-prism" in config.population.shapes.positive():
        found["population.truncation"] = _TRUNCATION
    return found | {WALL_TILT: _TILT}


def _beside(config: Config, name: str) -> Range:
    """Find the range of one friction coefficient if the other is fixed."""
    low = float(_given(config, DYNAMIC)) if name == STATIC else 0.0
    high = float(_given(config, STATIC)) if name == DYNAMIC else _FRICTION.high
    first, last = np.clip((_FRICTION.first, _FRICTION.last), low, high)
    return replace(_FRICTION, low=low, high=high, first=float(first), last=float(last))


def allowed_names(config: Config) -> tuple[str, ...]:
    """List the names that can be freed of a pair."""
    shapes = config.population.shapes
    together = [SHAPES] if len(shapes.positive()) > 1 else []
    every = shapes.model_dump(by_alias=True) if shapes.positive() else {}
    return (*_ranges(config), *together, *(f"{SHAPES}.{name}" for name in every))


def default_names(config: Config, means: int) -> tuple[str, ...]:
    """List the names that are free by default: both laws and the mean aspect ratio.

    Shapes and the spread of the ratios follow if there are more measured means than free numbers.
    """
    allowed = allowed_names(config)
    chosen = ("pair.", "population.aspect.mean", "population.aspect.values")
    names = [name for name in allowed if name.startswith(chosen)]
    for name in (SHAPES, "population.aspect.standard_deviation"):
        wider = [*names, name]
        if name in allowed:
            free = sum(len(part.labels) for part in make_parameters(config, wider))
            names = wider if free < means else names
    return tuple(names)


def in_words(config: Config, label: str) -> str:
    """Say what a fitted number is: "resistance at 30 degrees" for ``pair.resistance.value[1]``."""
    path, *places = re.split(r"\[|\]\[|\]", label.removesuffix("]"))
    section, _, name = path.partition(".")[2].rpartition(".")
    law = getattr(config.pair, section, None)
    if law is not None and law.law == "tabulated":
        speed = f" and {law.speed[int(places[1])]:g} m/s" if len(places) > 1 else ""
        return f"{section} at {law.angle_deg[int(places[0])]:g} degrees{speed}"
    if section == "shapes":
        return f"share of shape {name}"
    number = f" {places[0]}" if places else ""
    section = {"aspect": "aspect ratio", "": "wall"}.get(section, section)
    return f"{section} {name or 'roughness'}{number}".replace("_", " ")


def make_parameters(
    config: Config, names: Sequence[str], wall_tilt_deg: float = 0.0
) -> tuple[Parameter, ...]:
    """Make the parameters of free names, with the pair and the roughness to start from.

    Raises `InputError` if a name is unknown or given twice, or a number to start from is out of
    its range.
    """
    allowed = allowed_names(config)
    for name in names:
        if name not in allowed:
            raise InputError(f"free: got {shown(name)}, allowed: {', '.join(allowed)}")
    if not names or len(set(names)) < len(names):
        raise InputError(f"free: got {shown(list(names))}, allowed: each name once, at least one")
    if SHAPES in names and any(name.startswith(f"{SHAPES}.") for name in names):
        raise InputError(f"free: got {SHAPES} and one of its shapes, allowed: one of both")
    ranges, made = _ranges(config), []
    both = {STATIC, DYNAMIC} <= set(names)
    for name in names:
        if name == WALL_TILT:
            made.append(_field(name, np.array(wall_tilt_deg), ranges[name]))
        elif both and name in (STATIC, DYNAMIC):
            made += [_both_frictions(config)] if name == STATIC else []
        elif not name.startswith(SHAPES):
            allowed_range = _beside(config, name) if name in (STATIC, DYNAMIC) else ranges[name]
            made.append(_field(name, _given(config, name), allowed_range))
    shapes = [name.removeprefix(f"{SHAPES}.") for name in names if name.startswith(SHAPES)]
    if SHAPES in names:
        shapes = [*config.population.shapes.positive()]
    return (*made, _shares(config, shapes)) if shapes else tuple(made)
