"""Parameters that a calibration can free: their names, bounds and places in a pair file.

A name is the path of a field of the pair file, such as ``pair.resistance.strength``. Fields that
hold several numbers are freed together.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from sampler.arguments import MAX_ROUGHNESS
from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.config.messages import shown
from tablegen.config.population import FixedAspect, TruncatedNormalAspect
from tablegen.config.scenes import Tree
from tablegen.measured.search_coordinates import (
    Bernstein,
    Coordinates,
    Descending,
    Logarithm,
    Plain,
    Shares,
)
from tablegen.model.float_array import FloatArray
from tablegen.model.model_bounds import ASPECT

#: Name of the roughness of the wall, which is no field of a pair file: flow codes are told it.
WALL_TILT = "wall_tilt_deg"

#: Names of the weights of all shapes together, and of one.
SHAPES = "population.shapes"

#: Digits of a fitted number in a file, far below any standard error.
_DIGITS = 7


class Range(NamedTuple):
    """Where a number may lie, and how it is searched there."""

    #: Bounds that physics or a pair file sets.
    low: float
    high: float
    #: Part of them in which a search begins.
    first: float
    last: float
    #: Step of finite differences in the coordinate: see EXPERIMENTS.md.
    step: float
    logarithmic: bool = False


_UNIT = Range(0.0, 1.0, 0.1, 0.95, 0.04)
_FRICTION = Range(0.0, 10.0, 0.05, 1.0, 0.02)

#: What each law has to be freed, by its name in the file: restitution, then resistance.
_OF_LAWS: Mapping[str, Mapping[str, Mapping[str, Range]]] = {
    "restitution": {
        "exponential": {
            "coefficient": Range(1e-4, 1e2, 0.01, 1.0, 0.05, logarithmic=True),
            "exponent": Range(0.01, 3.0, 0.1, 1.0, 0.02),
        },
        "polynomial": {"coefficients": _UNIT},
        "constant": {"value": _UNIT},
        "power": {
            "coefficient": Range(1e-3, 1e3, 0.1, 2.0, 0.05, logarithmic=True),
            "exponent": Range(1e-3, 2.0, 0.05, 0.5, 0.02),
        },
        "tabulated": {"value": _UNIT},
    },
    "resistance": {
        "exponential-orientation": {
            "strength": Range(-10.0, 10.0, -6.0, 3.0, 0.2),
            "factor": Range(1e-3, 100.0, 0.1, 10.0, 0.1, logarithmic=True),
        },
        "constant": {"value": Range(1e-3, 100.0, 0.05, 2.0, 0.05, logarithmic=True)},
        "tabulated": {"value": Range(0.0, 20.0, 0.0, 1.5, 0.1)},
        "coulomb": {"static": _FRICTION, "dynamic": _FRICTION},
    },
}

_DEVIATION = Range(0.01, 3.0, 0.02, 0.5, 0.3, logarithmic=True)
_TRUNCATION = Range(0.01, 0.99, 0.1, 0.9, 0.05)
_TILT = Range(0.0, float(np.degrees(MAX_ROUGHNESS)), 0.5, 10.0, 0.5)
_SHARE = Range(0.0, 1.0, 0.0, 1.0, 0.05)


@dataclass(frozen=True)
class Parameter:
    """A freed field: k numbers of the file, which follow from m coordinates.

    Attributes
    ----------
    name : str
        As the user frees it.
    labels : tuple of k str
        Of its numbers.
    scale : Coordinates
    start : (m,) float64
        Coordinates of the pair that the search starts from.
    low, high, first, last, step : (m,) float64
        As in `Range`, of the coordinates.
    changes : callable
        Gives what to lay over the pair file for k numbers.
    exact : bool
        Whether the numbers must not be rounded, which could break a rule between them.
    """

    name: str
    labels: tuple[str, ...]
    scale: Coordinates
    start: FloatArray
    low: FloatArray
    high: FloatArray
    first: FloatArray
    last: FloatArray
    step: FloatArray
    changes: Callable[[FloatArray], Tree]
    exact: bool = False

    def numbers(self, x: FloatArray) -> FloatArray:
        """Numbers of the file for coordinates (m,), rounded as the file has them."""
        values = self.scale.values(x)
        if self.exact:
            return values
        return np.array([float(f"{value:.{_DIGITS}g}") for value in values])


def _nested(path: str, value: Any) -> Tree:
    """Tree with one value at a dotted path."""
    for key in reversed(path.split(".")):
        value = {key: value}
    return dict(value)


def _parameter(
    name: str,
    given: Sequence[float],
    allowed: Range,
    changes: Callable[[FloatArray], Tree],
    labels: Sequence[str] | None = None,
    scale: Coordinates | None = None,
) -> Parameter:
    """Make a parameter of numbers that have the same range.

    Raises
    ------
    InputError
        If a given number is out of it.
    """
    scale = scale or (Logarithm() if allowed.logarithmic else Plain())
    own = Logarithm() if allowed.logarithmic else Plain()
    ends = own.coordinates(np.array(allowed[:4]))
    start = scale.coordinates(np.array(given, dtype=np.float64))
    names = tuple(labels or (name,))
    slack = 1e-9 * (ends[1] - ends[0])
    for label, x, value in zip(names, start, given, strict=False):
        if not ends[0] - slack <= x <= ends[1] + slack:
            words = f"{allowed.low:g} to {allowed.high:g}"
            raise InputError(f"{label}: got {shown(float(value))} to start from, allowed: {words}")
    shape = np.ones(start.size)
    return Parameter(
        name,
        names,
        scale,
        np.clip(start, ends[0], ends[1]),
        low=ends[0] * shape,
        high=ends[1] * shape,
        first=ends[2] * shape,
        last=ends[3] * shape,
        step=allowed.step * shape,
        changes=changes,
    )


def _of_law(config: Config, section: str, field: str, allowed: Range) -> Parameter:
    """Parameter of a law of the pair."""
    name, law = f"pair.{section}.{field}", getattr(config.pair, section)
    if law.law == "coulomb":
        allowed = _beside(law.dynamic, law.static, field)
    given = np.asarray(getattr(law, field), dtype=np.float64)
    if given.ndim == 0:
        return _parameter(name, [float(given)], allowed, lambda v: _nested(name, float(v[0])))
    labels = ["".join(f"[{k}]" for k in place) for place in np.ndindex(given.shape)]
    if given.ndim == 2 and given.shape[1] == 1:
        labels = [f"[{k}]" for k in range(len(given))]
    scale = Bernstein(given.size, np.pi / 2) if law.law == "polynomial" else None
    made = _parameter(
        name,
        list(given.ravel()),
        allowed,
        lambda v: _nested(name, v.reshape(given.shape).tolist()),
        [name + label for label in labels],
        scale,
    )
    return replace(made, exact=scale is not None)


def _beside(dynamic: float, static: float, field: str) -> Range:
    """Range of one friction coefficient where the other is fixed."""
    low, high = (dynamic, _FRICTION.high) if field == "static" else (0.0, static)
    first, last = np.clip((_FRICTION.first, _FRICTION.last), low, high)
    return _FRICTION._replace(low=low, high=high, first=float(first), last=float(last))


def _coulomb(config: Config) -> Parameter:
    """Both friction coefficients, of which the dynamic one is at most the static one."""
    law: Any = config.pair.resistance
    names = ("pair.resistance.static", "pair.resistance.dynamic")
    made = _parameter(
        names[0],
        [law.static, law.dynamic],
        _FRICTION,
        lambda v: {"pair": {"resistance": {"static": float(v[0]), "dynamic": float(v[1])}}},
        names,
    )
    scale, low = Descending(), made.low.copy()
    low[0] = 1e-3
    return replace(
        made,
        scale=scale,
        start=np.maximum(scale.coordinates(np.array([law.static, law.dynamic])), low),
        low=low,
        high=np.array([_FRICTION.high, 1.0]),
        first=np.array([_FRICTION.first, 0.3]),
        last=np.array([_FRICTION.last, 1.0]),
    )


def _aspect(config: Config) -> dict[str, Callable[[], Parameter]]:
    """Parameters of the law of aspect ratios."""
    aspect = config.population.aspect
    if isinstance(aspect, TruncatedNormalAspect):
        mean, deviation = "population.aspect.mean", "population.aspect.standard_deviation"
        low, high = aspect.range
        wide = Range(low, high, low, high, 0.1 * (high - low))
        return {
            mean: lambda: _parameter(
                mean, [aspect.mean], wide, lambda v: _nested(mean, float(v[0]))
            ),
            deviation: lambda: _parameter(
                deviation,
                [aspect.standard_deviation],
                _DEVIATION,
                lambda v: _nested(deviation, float(v[0])),
            ),
        }
    if isinstance(aspect, FixedAspect):
        name = "population.aspect.values"
        allowed = Range(ASPECT.low, ASPECT.high, 0.3, ASPECT.high, 0.02)
        labels = [f"{name}[{k}]" for k in range(2)]
        return {
            name: lambda: _parameter(
                name, aspect.values, allowed, lambda v: _nested(name, v.tolist()), labels
            )
        }
    return {}


def _shares(config: Config, names: Sequence[str]) -> Parameter:
    """Shares of some shapes among all shapes; those of the others keep their ratios."""
    weights = config.population.shapes.model_dump(by_alias=True)
    total = sum(weights.values())
    rest = {name: w for name, w in weights.items() if w > 0.0 and name not in names}
    # of all shapes together the last has what the others leave
    free = list(names) if rest else list(names[:-1])
    others = rest or {names[-1]: 1.0}

    def changes(values: FloatArray) -> Tree:
        left = max(1.0 - values[: len(free)].sum(), 0.0) / sum(others.values())
        made = {name: float(v) for name, v in zip(free, values, strict=False)}
        made |= {name: float(f"{w * left:.{_DIGITS}g}") for name, w in others.items()}
        return {"population": {"shapes": {n: total * w for n, w in made.items()}}}

    return _parameter(
        SHAPES,
        [weights[name] / total for name in free],
        _SHARE,
        changes,
        [f"{SHAPES}.{name}" for name in free],
        Shares(),
    )


def _kinds(config: Config, wall_tilt_deg: float) -> dict[str, Callable[[], Parameter]]:
    """List what can be freed of a pair, by name, but for the weights of shapes."""
    kinds: dict[str, Callable[[], Parameter]] = {}
    for section, laws in _OF_LAWS.items():
        law = getattr(config.pair, section).law
        for field, allowed in laws.get(law, {}).items():
            kinds[f"pair.{section}.{field}"] = partial(_of_law, config, section, field, allowed)
    kinds |= _aspect(config)
    if config.population.shapes.positive().get("truncated-prism"):
        name = "population.truncation"
        kinds[name] = lambda: _parameter(
            name,
            [config.population.truncation],
            _TRUNCATION,
            lambda v: _nested("population.truncation", float(v[0])),
        )
    kinds[WALL_TILT] = lambda: _parameter(
        WALL_TILT, [wall_tilt_deg], _TILT, lambda v: {WALL_TILT: float(v[0])}
    )
    return kinds


def allowed_names(config: Config) -> tuple[str, ...]:
    """Names that can be freed of a pair."""
    names = [*_kinds(config, 0.0)]
    if len(config.population.shapes.positive()) > 1:
        names.append(SHAPES)
    every = config.population.shapes.model_dump(by_alias=True)
    if config.population.shapes.positive():
        names += [f"{SHAPES}.{name}" for name in every]
    return tuple(names)


def default_names(config: Config) -> tuple[str, ...]:
    """Names that are freed where none is named: both laws, and the mean aspect ratio."""
    chosen = ("pair.", "population.aspect.mean", "population.aspect.values")
    return tuple(name for name in allowed_names(config) if name.startswith(chosen))


def make_parameters(
    config: Config, names: Sequence[str], wall_tilt_deg: float = 0.0
) -> tuple[Parameter, ...]:
    """Parameters for the names of what is free.

    Parameters
    ----------
    config : Config
        Of the pair that the search starts from.
    names : sequence of str
        Some of `allowed_names`.
    wall_tilt_deg : float
        Where the search for the roughness starts, if it is free.

    Returns
    -------
    tuple of Parameter

    Raises
    ------
    InputError
        If a name is unknown or stands twice, or a number to start from is out of its bounds.
    """
    allowed = allowed_names(config)
    for name in names:
        if name not in allowed:
            raise InputError(f"free: got {shown(name)}, allowed: {', '.join(allowed)}")
    if not names or len(set(names)) < len(names):
        raise InputError(f"free: got {shown(list(names))}, allowed: each name once, at least one")
    kinds, made, shapes = _kinds(config, wall_tilt_deg), [], []
    friction = {"pair.resistance.static", "pair.resistance.dynamic"}
    for name in names:
        if name.startswith(SHAPES):
            shapes.append(name.removeprefix(SHAPES).removeprefix("."))
        elif name == "pair.resistance.dynamic" and friction <= set(names):
            continue
        else:
            both = name in friction and friction <= set(names)
            made.append(_coulomb(config) if both else kinds[name]())
    if shapes:
        if "" in shapes and len(shapes) > 1:
            raise InputError(f"free: got {SHAPES} and one of its shapes, allowed: one of both")
        every = [*config.population.shapes.positive()] if "" in shapes else shapes
        made.append(_shares(config, every))
    return tuple(made)
